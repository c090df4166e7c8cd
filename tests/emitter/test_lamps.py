# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A lamp's samples, densities and radiance; and lamps that cannot give light."""

import math

import numpy as np
import pytest

from sdf_lights.emitter import lamps
from sdf_lights.emitter.arrays import Lamps
from sdf_lights.emitter.building import build, pack, remarks
from sdf_lights.emitter.building.build import LampError
from sdf_lights.jit import kernel
from sdf_lights.sdf.shapes import SHAPES as REGISTRY
from sdf_lights.sdf.shapes import Box, Cylinder, Difference, Ellipsoid, Intersection, Sphere, Torus, Transformed, Union
from support.chi2 import chi2_sphere, sphere_integral
from support.lamps.shapes_under_test import FIELDS, LAMPS, PLACEMENTS, FieldOf, moved, scaled, turned

PLACES = ("outside", "inside", "surface")


def place(lamp, where):
    """A world point outside, inside or on the surface of a lamp."""
    row = lamp.row
    if where == "outside":
        return row["center"] + row["half"] * (0.9, -1.6, 2.1)
    x = lamp.points(np.full((1, 3), 0.37))[0]
    if where == "inside":
        return x
    d = np.array([0.48, 0.6, 0.64])
    for c, h in lamp.trace(x, d):
        return x + (c + h) * d


@pytest.mark.parametrize("where", PLACES)
@pytest.mark.parametrize("name", LAMPS)
def test_density_integrates_to_one(name, where):
    """Over the sphere by jittered quadrature, within five of its standard errors and the error of the volume."""
    lamp = Lamps(build.build_lamp(name, LAMPS[name], np.eye(4)))
    x = place(lamp, where)
    total, error = sphere_integral(lambda d: lamp.pdf(x, d), 60_000, seed=1, axis=lamp.row["center"] - x + 1e-9)
    assert error < 0.02
    assert abs(total - 1.0) < 5.0 * error + 1e-5 + lamp.row["volume_error"]


@pytest.mark.parametrize("where", PLACES)
@pytest.mark.parametrize("placement", PLACEMENTS)
@pytest.mark.parametrize("name", ["torus", "cone", "box_frame", "frame", "nested", "blob"])
def test_density_integrates_to_one_under_affine_maps(name, placement, where):
    """Against samples of the bounding box's own density q: the mean of p/q is ∫p, at any stretch and distance."""
    shape, matrix = LAMPS[name], PLACEMENTS[placement]
    low, high = shape.bounds()
    box = Transformed(Box(tuple(0.5 * (high - low))), moved(*(0.5 * (low + high))))
    lamp, around = (Lamps(build.build_lamp(name, s, matrix)) for s in (shape, box))
    x = place(lamp, where)
    directions = around.sample(x, np.random.default_rng(3).random((30_000, 3)))
    ratio = lamp.pdf(x, directions) / around.pdf(x, directions)
    error = ratio.std() / math.sqrt(len(ratio))
    assert error < 0.05
    assert abs(ratio.mean() - 1.0) < 5.0 * error


@pytest.mark.parametrize("where", PLACES)
@pytest.mark.parametrize("name", LAMPS)
def test_samples_have_their_density(name, where):
    """χ² at 99.999 % each."""
    lamp = Lamps(build.build_lamp(name, LAMPS[name], PLACEMENTS["uneven"]))
    x = place(lamp, where)
    result = chi2_sphere(
        lambda u: lamp.sample(x, u),
        lambda d: lamp.pdf(x, d),
        20_000,
        seed=2,
        confidence=0.99999,
        axis=lamp.row["center"] - x + 1e-9,
        bins=(8, 12),
        quadrature=20 if name in FIELDS else 48,
    )
    assert result.passed and result.lost == 0, result


@pytest.mark.parametrize("placement", PLACEMENTS)
@pytest.mark.parametrize("name", LAMPS)
def test_every_sample_hits_the_lamp(name, placement):
    """Also stretched 10,000 : 1, far away and tiny: no direction has density zero, none is lost to rounding."""
    lamp = Lamps(build.build_lamp(name, LAMPS[name], PLACEMENTS[placement]))
    u = np.random.default_rng(5).random((2000, 3))
    for where in PLACES:
        x = place(lamp, where)
        directions = lamp.sample(x, u)
        assert np.allclose(np.linalg.norm(directions, axis=1), 1.0, rtol=1e-12)
        pdf = lamp.pdf(x, directions)
        assert np.isfinite(pdf).all()
        assert np.mean(pdf > 0.0) > 0.998  # the rest are points within rounding of the surface, seen edge on


def test_chords_give_back_the_volume():
    """Crofton: the mean chord over all lines through a sphere around the lamp is V / (its cross-section)."""
    rng = np.random.default_rng(7)
    for name in ("torus", "nested", "twenty", "twisted"):
        lamp = Lamps(build.build_lamp(name, LAMPS[name], PLACEMENTS["uneven"]))
        n, reach = 15_000, lamp.row["bounding_radius"]
        d = rng.normal(size=(n, 3))
        d /= np.linalg.norm(d, axis=1, keepdims=True)
        side = np.cross(d, np.eye(3)[np.argmin(np.abs(d), axis=1)])
        side /= np.linalg.norm(side, axis=1, keepdims=True)
        radius, angle = reach * np.sqrt(rng.random(n)), 2 * np.pi * rng.random(n)
        offset = (radius * np.cos(angle))[:, None] * side + (radius * np.sin(angle))[:, None] * np.cross(d, side)
        origins = lamp.row["center"] + offset - 3.0 * reach * d
        chords = np.concatenate([lamp.chord(o, v[None]) for o, v in zip(origins, d)])
        volumes = chords * np.pi * reach**2
        assert abs(volumes.mean() / lamp.row["volume"] - 1.0) < 5.0 * volumes.std() / volumes.mean() / math.sqrt(n)


def test_stretched_ellipsoid():
    """The density in the sphere's own space over |det| is the world's, if the direction is not renormalised."""
    matrix = turned(0.6, 2) @ scaled(2.0, 1.0, 0.5)
    lamp = Lamps(build.build_lamp("stretched", Sphere(1.0), matrix))
    x = np.array([0.5, -3.0, 0.8])
    directions = lamp.sample(x, np.random.default_rng(1).random((500, 3)))
    world = lamp.pdf(x, directions)
    inverse = np.linalg.inv(matrix[:3, :3])
    o, d = inverse @ x, directions @ inverse.T

    def density(o, d):
        a, b, c = np.sum(d * d, axis=1), d @ o, o @ o - 1.0
        root = np.sqrt(np.maximum(b * b - a * c, 0.0))
        return (((root - b) / a) ** 3 - ((-root - b) / a) ** 3) / (3.0 * 4.0 / 3.0 * np.pi)

    size = np.linalg.norm(d, axis=1, keepdims=True)
    grazing = np.sum(d * d, axis=1) - np.sum(np.cross(o, d) ** 2, axis=1) < 1e-3
    local = density(o, d) / abs(np.linalg.det(matrix[:3, :3]))
    assert np.max(np.abs(local / world - 1.0)[~grazing]) < 2e-12
    renormalised = density(o, d / size) / abs(np.linalg.det(matrix[:3, :3]))
    assert np.max(np.abs(renormalised / world - 1.0)) > 0.5
    assert np.max(np.abs(renormalised * size[:, 0] ** -3 / world - 1.0)[~grazing]) < 2e-12


def test_an_ellipsoid_is_a_stretched_ball():
    radii = (0.9, 0.5, 0.3)
    a = Lamps(build.build_lamp("a", Ellipsoid(radii), PLACEMENTS["sheared"]))
    b = Lamps(build.build_lamp("b", Sphere(1.0), PLACEMENTS["sheared"] @ scaled(*radii)))
    assert a.row["volume"] == pytest.approx(b.row["volume"], rel=1e-14)
    u = np.random.default_rng(0).random((200, 3))
    x = place(a, "outside")
    directions = a.sample(x, u)
    assert np.allclose(directions, b.sample(x, u), atol=1e-12)
    assert np.allclose(a.pdf(x, directions), b.pdf(x, directions), rtol=1e-9)


@kernel
def _radiance(blocks, o, d, t_min, t_max, spans):
    count = lamps.trace(blocks[0], 0, o, d, spans)
    return lamps.radiance(blocks[0], 0, o, d, spans, count, t_min, t_max, 0.5)


def test_radiance_is_density_times_length():
    lamp = Lamps(build.build_lamp("rod", Cylinder(0.5, 2.0), moved(0, 0, 5), density=3.0, color=(1.0, 0.5, 0.0)))
    for t_min, t_max, length in ((0, np.inf, 2.0), (0, 5.5, 1.5), (4.5, 5.5, 1.0), (0, 3, 0.0), (7, np.inf, 0.0)):
        rgb = _radiance(lamp.blocks, (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), float(t_min), float(t_max), lamp.spans)
        assert rgb == pytest.approx((3.0 * length, 1.5 * length, 0.0), rel=1e-14)


def test_power_is_that_of_a_point_light_far_away():
    """∫ L dω is P/4π over the square of the distance, whatever the shape."""
    lamp = Lamps(build.build_lamp("far", Torus(0.5, 0.2), turned(0.4, 0), power=40.0))
    x = np.array([0.0, 200.0, 0.0])
    directions = lamp.sample(x, np.random.default_rng(2).random((20_000, 3)))
    weight = lamp.chord(x, directions) * lamp.row["emission"][0] / lamp.pdf(x, directions)
    assert weight.mean() == pytest.approx(40.0 / (4.0 * math.pi) / 200.0**2, rel=1e-4)


def test_tables_of_several_lamps():
    """Lamps of one scene do not see one another's programs, terms or trees; equal shapes have them once."""
    built = [
        build.build_lamp(name, LAMPS[name], matrix)
        for name, matrix in (
            ("frame", PLACEMENTS["turned"]),
            ("torus", np.eye(4)),
            ("blob", np.eye(4)),
            ("nested", PLACEMENTS["far"]),
            ("blob", PLACEMENTS["turned"]),
            ("twenty_as_field", PLACEMENTS["uneven"]),
        )
    ]
    tables = pack.pack_lamps(built)
    rng = np.random.default_rng(1)
    together = Lamps(*built)
    for index, lamp in enumerate(built):
        alone = Lamps(lamp)
        together.blocks["lamps_address"] = tables["lamps"][index:].ctypes.data
        directions = alone.sample(np.zeros(3), rng.random((200, 3)))
        assert np.array_equal(alone.pdf(np.zeros(3), directions), together.pdf(np.zeros(3), directions))
    assert len(tables["lamp_nodes"]) == sum(len(lamp.tree.nodes) for lamp in (built[0], built[2], built[3], built[5]))
    empty = pack.pack_lamps([])
    assert all(len(empty[name]) == 0 and empty[name].dtype == dtype for name, dtype in lamps.TABLES.items())


def test_little_is_left_unresolved():
    """Row ``lamp_rows`` of the spans sums what could not be resolved, of which the user is told, and what is inside."""
    rng = np.random.default_rng(6)
    for name in FIELDS:
        lamp = Lamps(build.build_lamp(name, FIELDS[name], np.eye(4)))
        directions = lamp.sample(np.array([2.0, 1.0, 0.5]), rng.random((5000, 3)))
        chords = lamp.chord(np.array([2.0, 1.0, 0.5]), directions)
        left, inside = lamp.spans[lamp.blocks["lamp_rows"][0]]
        assert inside == pytest.approx(chords.sum(), rel=1e-9)
        assert 0.0 <= left < remarks.NOTICEABLE * inside
        assert not remarks.unresolved(lamp.built, lamp.spans[lamp.blocks["lamp_rows"][0] :])
    (sentence,) = remarks.unresolved(lamp.built, np.array([[0.02, 0.98]]))
    assert sentence.startswith(f"Lamp “{name}”: 2 % of its length") and sentence.endswith(".")


BAD = {
    "zero scale": dict(matrix=scaled(1.0, 0.0, 1.0)),
    "NaN": dict(matrix=np.full((4, 4), np.nan)),
    "infinite": dict(matrix=scaled(1.0, np.inf, 1.0)),
    "no power": dict(power=0.0),
    "negative power": dict(power=-1.0),
    "NaN power": dict(power=float("nan")),
    "no density": dict(density=0.0),
    "black": dict(color=(0.0, 0.0, 0.0)),
    "negative color": dict(color=(1.0, -1.0, 0.0)),
    "empty": dict(shape=Intersection(Sphere(0.5), Transformed(Sphere(0.5), moved(3.0)))),
    "carved away": dict(shape=Difference(Sphere(0.5), Box((1, 1, 1)))),
    "bad torus": dict(shape=Torus(0.1, 0.5)),
    "bad radius": dict(shape=Sphere(float("nan"))),
    "no parts": dict(shape=Union()),
    "without limits": dict(shape=REGISTRY["half_space"]()),
    "without limits, of a field": dict(shape=FieldOf(REGISTRY["slab"]())),
    "empty field": dict(shape=FieldOf(Intersection(Sphere(0.5), Transformed(Box((0.1, 0.1, 0.1)), moved(0.5, 0.5))))),
    "thin": dict(shape=Difference(Sphere(0.5), Sphere(0.5 - 1e-6))),
    "thin field": dict(shape=FieldOf(Difference(Sphere(0.5), Sphere(0.5 - 1e-6)))),
}


@pytest.mark.parametrize("name", BAD)
def test_bad_lamps_say_what_is_wrong(name):
    arguments = {"shape": Sphere(0.5), "matrix": np.eye(4), **BAD[name]}
    with pytest.raises(LampError) as caught:
        build.build_lamp("Ceiling", **arguments)
    message = str(caught.value)
    assert message.startswith("Lamp “Ceiling”: ") and message.endswith(".") and "\n" not in message
