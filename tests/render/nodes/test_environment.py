# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Environment, Sky and IES textures in a graph: colours as in Cycles, or as of the functions that they stand for."""

import numpy as np
import pytest

from sdf_lights.graph.formula import Vector
from sdf_lights.render import ies
from sdf_lights.render.material import Node
from sdf_lights.render.nodes.variables import POSITION
from sdf_lights.render.sky import MODELS, Sky, radiance
from support.graphs import Graph
from tests.render.ies_files import BROKEN, FILES
from tests.render.shading.surfaces import Surface
from tests.render.sky.panoramas import FULL, panoramas
from tests.render.sky.test_models import directions

PIXELS_SHAPE = (6, 12)


def pixels():
    # As in render_world.py, which imports bpy.
    values = np.random.default_rng(1).random((*PIXELS_SHAPE, 4)).astype(np.float32) ** 2
    values[..., 3] = 1.0
    return values


def emitted(graph, value, points, images=()):
    """(n, 3) values of a graph where the position is ``points``."""
    surface = Surface(Node("emission", {"color": value}), images, graph.parameters)
    return np.array([surface.shade(1.0, position=point).hit["emission"].copy() for point in points])


@pytest.mark.parametrize("interpolation", ["Linear", "Closest", "Cubic"])
@pytest.mark.parametrize("projection", ["EQUIRECTANGULAR", "MIRROR_BALL"])
def test_environment_as_in_cycles(projection, interpolation, tmp_path):
    settings = {"projection": projection, "interpolation": interpolation}
    ((found, theirs),) = panoramas(
        [["ShaderNodeTexEnvironment", {"image": PIXELS_SHAPE, **settings}, (*FULL[:4], 24, 12)]], tmp_path
    )
    graph = Graph()
    color = graph.node("ShaderNodeTexEnvironment", {"Vector": POSITION}, {"image": 0, **settings})["Color"]
    np.testing.assert_allclose(emitted(graph, color, 3.0 * found, [pixels()]), theirs, rtol=2e-3, atol=2e-4)


def test_the_zero_vector_is_harmless():
    for projection in ("EQUIRECTANGULAR", "MIRROR_BALL"):
        graph = Graph()
        color = graph.node(
            "ShaderNodeTexEnvironment",
            {"Vector": POSITION},
            dict(image=0, projection=projection, interpolation="Linear"),
        )["Color"]
        points = [(0.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, -1.0, 0.0), (0.0, 0.0, 1.0), (0.0, 0.0, -1.0)]
        assert np.isfinite(emitted(graph, color, points, [pixels()])).all()


@pytest.mark.parametrize("model", MODELS)
def test_sky(model):
    properties = dict(
        sky_type=model,
        sun_direction=(0.4, -0.3, 0.5),
        turbidity=3.0,
        ground_albedo=0.3,
        sun_disc=True,
        sun_size=0.3,
        sun_intensity=1.0,
        sun_elevation=0.3,
        sun_rotation=1.0,
        altitude=100.0,
        air_density=1.0,
        ozone_density=1.0,
        **{"dust_density" if model == "NISHITA" else "aerosol_density": 2.0},
    )
    graph = Graph()
    color = graph.node("ShaderNodeTexSky", {"Vector": POSITION}, properties)["Color"]
    sky = Sky(
        model,
        sun_direction=(0.4, -0.3, 0.5),
        turbidity=3.0,
        sun_size=0.3,
        sun_elevation=0.3,
        sun_rotation=1.0,
        aerosol_density=2.0,
    )
    d = np.concatenate((directions(20), sky.sun()[None]))
    np.testing.assert_allclose(emitted(graph, color, d), radiance(sky, d), rtol=1e-9)


def test_ies():
    graph = Graph()
    factor = graph.node(
        "ShaderNodeTexIES",
        {"Vector": POSITION, "Strength": 3.0},
        dict(ies_text=FILES["C, all"], blender_version=(5, 2)),
    )["Fac"]
    values, d = ies.numbers_of(FILES["C, all"]), directions(20)
    expected = 3.0 * np.array([ies.intensity(values, 0, tuple(direction)) for direction in d])
    np.testing.assert_allclose(emitted(graph, Vector(factor, factor, factor), d)[:, 0], expected, rtol=1e-9)


def test_a_broken_ies_file_is_reported():
    with pytest.raises(ValueError, match="choose another"):
        Graph().node("ShaderNodeTexIES", {"Vector": POSITION}, dict(ies_text=BROKEN["type"], blender_version=(5, 2)))
