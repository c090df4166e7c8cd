# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Nodes of values against NumPy: images, mapping, normal maps, bump."""

import numpy as np
import pytest

from sdf_lights.graph.formula import Vector
from sdf_lights.render.material import Node
from support.graphs import PLACE, Graph
from tests.render.shading.surfaces import Surface

PIXELS = np.random.default_rng(1).random((5, 7, 4)).astype(np.float32)


def emitted(graph, value, images=(PIXELS,), **fields):
    surface = Surface(Node("emission", {"color": value}), images, graph.parameters)
    return np.array(surface.shade(1.0, **fields).hit["emission"])


def at(u, v):
    return {"barycentric": (u, v)}


@pytest.mark.parametrize("index", [None, 7, 1])
def test_missing_images_are_magenta(index):
    graph = Graph()
    assert emitted(graph, graph.image(index), (PIXELS, np.zeros((0, 0, 4)))) == pytest.approx((1.0, 0.0, 1.0))


def test_projections():
    graph = Graph()
    flat = emitted(graph, graph.image(0, (0.25, 0.75, 0.0)))
    # The point of the cube's surface that lies at those coordinates of the sphere and of the tube.
    on_sphere = tuple(0.5 + 0.5 * np.array([np.sin(np.pi / 4), 0.0, -np.cos(0.75 * np.pi)]))
    for point, projection in ((on_sphere, "SPHERE"), ((1.0, 0.5, 0.75), "TUBE")):
        assert emitted(graph, graph.image(0, point, projection=projection)) == pytest.approx(flat)


@pytest.mark.parametrize("kind", ["POINT", "TEXTURE", "VECTOR", "NORMAL"])
def test_mapping_by_numbers_and_by_a_texture_agree(kind):
    graph = Graph()
    vector, location, rotation, scale = (0.3, -1.2, 2.0), (0.5, 0.1, -1.0), (0.3, -0.8, 2.1), (2.0, 0.5, 1.5)
    constant = emitted(graph, graph.mapping(vector, location, rotation, scale, kind))
    # An image of one texel makes an input vary without changing its value.
    pixels = np.ones((1, 1, 4), np.float32)
    pixels[..., :3] = rotation
    varying = graph.mapping(vector, location, graph.image(0), scale, kind)
    assert emitted(graph, varying, (pixels,)) == pytest.approx(constant, rel=1e-6)


def test_mapping_of_a_point():
    # Scaled to (2, 2, 3), turned about z to (−2, 2, 3), moved.
    graph = Graph()
    mapped = graph.mapping((1.0, 2.0, 3.0), (0.5, 0.0, -1.0), (0.0, 0.0, np.pi / 2), (2.0, 1.0, 1.0))
    assert emitted(graph, mapped) == pytest.approx((-1.5, 2.0, 2.0))


def normal_mapped(graph, normal, **surface):
    return Surface(Node("diffuse", {"normal": normal}), parameters=graph.parameters, **surface)


def test_normal_map_in_tangent_space():
    graph = Graph()
    color = (0.5 + 0.5 * 0.6, 0.5, 0.5 + 0.5 * 0.8)
    surface = normal_mapped(graph, graph.normal_map(color), tangent=(0.0, 1.0, 0.0, 1.0))
    assert surface.shade(1.0).closures[0]["normal"] == pytest.approx((0.0, 0.6, 0.8))
    # Seen from behind, the mapped normal is turned round with the others.
    surface.shade(wo=(0, 0, -1), n=(0, 0, -1), ng=(0, 0, -1), backfacing=True)
    assert surface.closures[0]["normal"] == pytest.approx((0.0, -0.6, -0.8))


def test_normal_map_without_tangents_changes_nothing():
    graph = Graph()
    surface = normal_mapped(graph, graph.normal_map((1.0, 0.5, 0.5)))
    assert surface.shade(1.0).closures[0]["normal"] == pytest.approx((0.0, 0.0, 1.0))


def test_object_space_normal_map_turns_with_the_object():
    graph = Graph()
    turned = np.eye(4)
    turned[:3, :3] = [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]  # the object's x is the world's y
    surface = normal_mapped(graph, graph.normal_map((1.0, 0.5, 0.5), space="OBJECT"), matrix=turned)
    assert surface.shade(1.0).closures[0]["normal"] == pytest.approx((0.0, 1.0, 0.0))


@pytest.mark.parametrize("strength, invert", [(1.0, False), (1.0, True), (0.5, False)])
@pytest.mark.parametrize("step", [1e-4, 1e-3])
def test_bump_of_a_ramp_tilts_by_its_slope(strength, invert, step):
    across = Vector(PLACE.x + 0.5 * PLACE.y, PLACE.y, PLACE.z)
    ramp = np.zeros((1, 100, 4), np.float32)
    ramp[..., :3] = (np.arange(100.0) / 100.0)[None, :, None]  # height u
    graph = Graph()
    node = graph.bump(graph.image(0, across, extension="EXTEND").x, 0.4, strength, invert)
    surface = Surface(Node("diffuse", {"normal": node}), [ramp], graph.parameters)
    # Two metres a unit of u, on a triangle whose edges are not square: slope 0.4 · 1/2.
    surface.shade(1.0, bump_step=step, dpdu=(2.0, 0.0, 0.0), dpdv=(1.0, 1.0, 0.0), barycentric=(0.25, 0.5))
    full = np.array([0.2 if invert else -0.2, 0.0, 1.0]) / np.hypot(0.2, 1.0)
    expected = strength * full + (1.0 - strength) * np.array([0.0, 0.0, 1.0])
    assert surface.closures[0]["normal"] == pytest.approx(expected / np.linalg.norm(expected), abs=1e-5)
