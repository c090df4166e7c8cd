# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Closures that few scenes have are the same in the reference, which shares no code with the kernels."""

import numpy as np
import pytest

from sdf_lights import jit
from sdf_lights.render.material import Material, Node
from sdf_lights.render.reference.fibers import Huang
from sdf_lights.render.reference.geometry import Geometry
from sdf_lights.render.reference.geometry import Surface as Points
from sdf_lights.render.reference.materials import Materials, _evaluate
from sdf_lights.render.reference.special_materials import radial
from sdf_lights.render.scene import Instance, Mesh, Scene
from tests.render.shading.surfaces import Surface
from tests.render.shading.test_special_closures import CLOSURES, RUST, VIEW, hair

pytestmark = pytest.mark.skipif(not jit.AVAILABLE, reason="Numba is not installed")

# A triangle whose edges are the first two axes.
CORNERS = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], np.float32)
PLACE = np.array([0.2, 0.3, 0.0])
MORE = {
    "turned": Node("metallic", {"roughness": 0.4, "anisotropy": 0.7, "rotation": 0.2, "thin_film_thickness": 350.0}),
    "conductor under a film": Node(
        "metallic",
        {"roughness": 0.4, "thin_film_thickness": 350.0},
        {"fresnel_type": "PHYSICAL_CONDUCTOR", "distribution": "BECKMANN"},
    ),
    **{
        f"{name} under a film": Node(
            "principled",
            {"base_color": RUST, "roughness": 0.4, "metallic": 0.5, "thin_film_thickness": 350.0},
            {"film_on_metal": name == "metal"},
        )
        for name in ("metal", "all but metal")
    },
    "pane of half": Node(
        "principled", {"base_color": RUST, "roughness": 0.4, "transmission_weight": 0.7, "thin_wall": 1.0, "ior": 1.3}
    ),
    "melanin": Node(
        "principled_hair",
        {
            "melanin": 0.4,
            "melanin_redness": 0.3,
            "tint": RUST,
            "random": 0.8,
            "random_color": 0.5,
            "random_roughness": 0.4,
        },
        {"model": "CHIANG", "parametrization": "MELANIN"},
    ),
    "chiang before 5.0": Node(
        "principled_hair",
        {"absorption_coefficient": (0.05, 0.2, 0.6)},
        {"model": "CHIANG", "parametrization": "ABSORPTION", "light_rays": "ALL"},
    ),
    "hair of a tangent": Node("hair", {"tangent": (0.6, 0.8, 0.1), "offset": 0.3}, {"component": "REFLECTION"}),
}
NODES = {**CLOSURES, **MORE}


def reference(node: Node, count: int, wo=VIEW, kind: int = 1) -> tuple[Materials, Points]:
    """Materials of a scene that has the node alone, and so many times the same point."""
    scene = Scene(
        camera=None,
        width=1,
        height=1,
        materials=[Material("test", node)],
        meshes=[Mesh("triangle", CORNERS, np.array([[0, 1, 2]], np.int32))],
        instances=[Instance(0, np.eye(4), (0,))],
    )
    geometry = Geometry(scene, use_embree=False)
    z, nowhere = np.tile([0.0, 0.0, 1.0], (count, 1)), np.zeros(count, int)
    points = Points(
        np.tile(PLACE, (count, 1)),
        z,
        z,
        np.tile(wo, (count, 1)),
        np.zeros(count, bool),
        nowhere,
        nowhere,
        np.tile([1.0 - PLACE[0] - PLACE[1], PLACE[0], PLACE[1]], (count, 1)),
        np.zeros(count, bool),
        np.ones(count),
        np.full(count, kind),
        np.zeros(count, bool),
        np.zeros((count, 5), int),
        np.zeros(count),
        nowhere,
        np.zeros((count, 3)),
        nowhere - 1,
    )
    return Materials(scene, geometry), points


def kernels(node: Node, wo=VIEW, **fields) -> Surface:
    materials, points = reference(node, 1)
    found = type("At", (), dict(surface=points, geometry=materials.geometry, count=1))
    return Surface(node).shade(wo=wo, position=PLACE, radial=radial(found)[0], ray_kind=1, **fields)


def directions(count: int) -> np.ndarray:
    wi = np.random.default_rng(1).normal(size=(count, 3))
    return wi / np.linalg.norm(wi, axis=1, keepdims=True)


@pytest.mark.parametrize("name", [name for name in NODES if name not in ("huang", "mixed")])
def test_kernels_evaluate_as_the_reference_does(name):
    wi = directions(300)
    surface = kernels(NODES[name])
    expected, density = surface.evaluate(wi)
    materials, points = reference(NODES[name], len(wi))
    shading = materials.shade(points, np.zeros(len(wi)))
    value, pdf = shading.evaluate(wi)
    assert (expected > 0.0).any()
    # What films reflect is looked up in a table, and a Bessel function is the first terms of its series there.
    loose, absolute = (1e-2, 2e-3) if {"film", "turned", "chiang", "melanin"} & set(name.split()) else (1e-6, 1e-6)
    np.testing.assert_allclose(value, expected, rtol=loose, atol=absolute * np.abs(expected).max())
    np.testing.assert_allclose(shading.albedo[0], surface.hit["albedo"], rtol=loose, atol=absolute)
    if "beckmann" not in name and name not in ("conductor under a film",):  # whose normals it draws in another way
        np.testing.assert_allclose(pdf, density, rtol=loose, atol=absolute * density.max())


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name in NODES if name not in ("huang", "mixed")])
def test_the_reference_draws_what_it_evaluates(name):
    """Mean of a smooth function of directions by its samples, against that by the kernels' values."""
    count = 40_000
    materials, points = reference(NODES[name], count)
    wi, weight, pdf, _ = materials.shade(points, np.zeros(count)).sample(np.random.Generator(np.random.Philox(3)))
    drawn = weight * (1.5 + wi @ (0.3, -0.5, 0.8))[:, None]
    surface = kernels(NODES[name])
    there, value, chance, _ = surface.draw(np.random.default_rng(4).random((count, 3)))
    other = np.where(chance > 0.0, 1.0 / np.where(chance > 0.0, chance, 1.0), 0.0)[:, None] * value
    other = other * (1.5 + there @ (0.3, -0.5, 0.8))[:, None]
    error = np.sqrt((drawn.var(0) + other.var(0)) / count)
    assert np.all(np.abs(drawn.mean(0) - other.mean(0)) < 4.5 * error + 2e-3 * (("film" in name) + ("chiang" in name)))


@pytest.mark.slow
@pytest.mark.parametrize(
    "inputs",
    [
        dict(roughness=0.3, offset=0.05, aspect_ratio=0.8),
        dict(roughness=0.15, offset=0.0, aspect_ratio=1.0),
        dict(roughness=0.4, tt_lobe=0.0, trt_lobe=0.0),
        dict(roughness=0.3, r_lobe=0.0, absorption_coefficient=(0.0, 0.1, 1.0)),
    ],
)
def test_huangs_fiber_scatters_as_a_ray_that_is_followed_through_it(inputs):
    """The kernels integrate over the fiber; the reference follows single rays. Where light rays are not cut, means of
    functions of directions are the same, within their errors and 2 %: mesonormals that scales tilt are treated
    differently by both."""
    node, count = hair("HUANG", **inputs), 60_000
    materials, points = reference(node, count)
    ((_, (lobe,)),) = materials.shade(points, np.zeros(count)).groups
    assert isinstance(lobe, Huang)
    wi, value, probability, singular = lobe.sample(np.random.Generator(np.random.Philox(5)), points.wo)
    assert singular.all()
    traced = value * probability[:, None]
    surface = kernels(node)
    there, weight, pdf, _ = surface.draw(np.random.default_rng(6).random((20_000, 3)))
    integrated = np.where(pdf > 0.0, 1.0 / np.where(pdf > 0.0, pdf, 1.0), 0.0)[:, None] * weight
    x = np.cross([1.0, 0.0, 0.0], VIEW)
    for function in (
        lambda w: np.ones(len(w)),
        lambda w: w @ VIEW > 0.3,
        lambda w: w @ VIEW < -0.3,
        lambda w: w[:, 0] > 0.0,
        lambda w: np.abs(w @ x) < 0.3,
    ):
        a, b = (part * function(w)[:, None] for part, w in ((traced, wi), (integrated, there)))
        error = np.sqrt(a.var(0) / len(a) + b.var(0) / len(b))
        assert np.all(np.abs(a.mean(0) - b.mean(0)) < 4.0 * error + 0.02 * np.maximum(a.mean(0), 0.1)), (
            a.mean(0),
            b.mean(0),
        )


def test_portals_and_panes_let_light_rays_through_alike():
    clear, portal = Node("transparent", {"color": RUST}), Node("ray_portal", {"color": (0.5, 0.5, 0.5)})
    pane = Node("principled", {"base_color": RUST, "roughness": 0.0, "transmission_weight": 1.0, "thin_wall": 1.0})
    for node in (portal, pane, Node("mix_closure", {"factor": 0.25, "a": clear, "b": portal})):
        materials, points = reference(node, 1, kind=16)
        expected = Surface(node).shade(wo=VIEW, ray_kind=16).transparency()
        np.testing.assert_allclose(materials.transparency(points)[0], expected, rtol=1e-6, atol=1e-9)


def test_the_reference_goes_on_from_where_a_portal_leads():
    node = Node("ray_portal", {"color": RUST, "position": (1.0, 2.0, 3.0), "direction": (0.0, 0.0, -2.0)})
    materials, points = reference(node, 5)
    shading = materials.shade(points, np.zeros(5))
    wi, weight, pdf, _ = shading.sample(np.random.default_rng(1))
    assert shading.portal.all() and not pdf.any()
    np.testing.assert_allclose(wi, np.tile([0.0, 0.0, -1.0], (5, 1)))
    np.testing.assert_allclose(weight, np.tile(RUST, (5, 1)))
    np.testing.assert_allclose(shading.exit, np.tile([1.0, 2.0, 3.0], (5, 1)))
    assert _evaluate(points, shading.groups[0][1], -points.wo)[0].max() == 0.0
