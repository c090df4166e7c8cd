# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Lamps of networks: the example, files beside the .blend, files that change, and files that are none."""

import os

import bpy
import numpy as np
import pytest

from sdf_lights.blender.lamp import shape_of
from sdf_lights.render.errors import RenderError
from sdf_lights.sdf.data.network import EXAMPLE, Siren, read


@pytest.fixture
def small():
    """A network whose bound takes less time than the example's."""
    rng = np.random.default_rng(5)
    return Siren([rng.uniform(-0.4, 0.4, (6, 3)), rng.uniform(-0.4, 0.4, (1, 6))], [rng.random(6), [-0.05]], 5.0)


@pytest.fixture
def network_lamp(lamp):
    """Function: the settings of a lamp with a network of this path."""

    def make(path=""):
        light = lamp()
        light.sdf_lamp.source, light.sdf_lamp.network = "NETWORK", path
        return light.sdf_lamp

    return make


def test_without_a_file_a_lamp_has_the_example(file, network_lamp):
    shape = shape_of(network_lamp())
    assert shape == read(EXAMPLE).shape() and shape.validate() == "" and shape.certified


def test_one_click_adds_a_lamp_that_lights(file, pictures):
    bpy.ops.sdf_lights.network_lamp_add(location=(0.0, 0.0, 0.0))
    light = bpy.context.object.data
    assert light.sdf_lamp.source == "NETWORK" and light.shadow_soft_size > 0.1
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.location = 0.0, 0.0, 4.0
    bpy.context.scene.collection.objects.link(camera)
    bpy.context.scene.camera = camera
    bpy.context.scene.render.engine = "SDF_LIGHTS"
    bpy.context.scene.sdf_lights.samples, bpy.context.scene.sdf_lights.device = 1, "CPU"
    assert pictures()["ViewLayer"]["Combined"].max() > 0.1


def test_a_file_is_found_beside_the_blend_and_read_again_when_it_changes(file, network_lamp, small, tmp_path):
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "scene.blend"))
    small.save(tmp_path / "own.npz")
    lamp = network_lamp("//own.npz")
    first = shape_of(lamp)
    siren = read(tmp_path / "own.npz")
    siren.biases[-1] = siren.biases[-1] - 0.02
    siren.save(tmp_path / "own.npz")
    os.utime(tmp_path / "own.npz", ns=(1, 1))
    with bpy.context.temp_override(light=lamp.id_data):
        assert bpy.ops.sdf_lights.network_reload() == {"FINISHED"}
    points = np.random.default_rng(1).uniform(-0.5, 0.5, (100, 3))
    np.testing.assert_allclose(shape_of(lamp).distance(points), first.distance(points) - 0.02, atol=1e-5)


def test_files_that_are_no_networks_say_so_in_a_sentence(file, network_lamp, tmp_path):
    with pytest.raises(RenderError, match="Network 'gone.npz' is missing: find it again"):
        shape_of(network_lamp(str(tmp_path / "gone.npz")))
    (tmp_path / "cut.npz").write_bytes(EXAMPLE.read_bytes()[:-40])
    with pytest.raises(RenderError, match="Network 'cut.npz' is damaged"):
        shape_of(network_lamp(str(tmp_path / "cut.npz")))


def test_a_network_has_no_text_and_no_sizes(file, network_lamp, add):
    obj = add("Lamp", network_lamp().id_data)
    obj.scale = 2.0, 2.0, 2.0
    bpy.context.view_layer.objects.active = obj
    obj.select_set(True)
    bpy.context.view_layer.update()
    with pytest.raises(RuntimeError, match="the example of the add-on, which has no file: choose a file first"):
        bpy.ops.sdf_lights.nodes_to_expression()


def test_a_network_of_a_file_is_a_word(file, network_lamp, small, tmp_path):
    lamp = network_lamp(str(tmp_path / "waves.npz"))
    small.save(tmp_path / "waves.npz")
    direct = shape_of(lamp)
    lamp.expression = f"network({str(tmp_path / 'waves.npz')!r}) | sphere(0.1)"
    lamp.source = "EXPRESSION"
    points = np.random.default_rng(1).uniform(-1.0, 1.0, (200, 3))
    expected = np.minimum(direct.distance(points), np.linalg.norm(points, axis=1) - 0.1) < 0.0
    assert ((shape_of(lamp).distance(points) < 0.0) == expected).all()
    lamp.expression = "network('gone.npz')"
    with pytest.raises(RenderError, match="network 'gone.npz' is missing"):
        shape_of(lamp)
