# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Lamps of another file: every property can be overridden, and keeps its value when the file is opened again."""

import bpy
import numpy as np
import pytest

from sdf_lights.blender import presets, properties
from sdf_lights.blender.lamp import shape_of


@pytest.fixture
def overridden(file, tmp_path):
    """The data of a lamp that is linked from a file and overridden, and the path of the file that it is in."""
    bpy.ops.sdf_lights.lamp_add(source="PRESET", preset="CAMPFIRE")
    source = tmp_path / "lamps.blend"
    bpy.data.libraries.write(str(source), {bpy.context.object}, fake_user=True)
    bpy.ops.wm.read_factory_settings(use_empty=True)
    with bpy.data.libraries.load(str(source), link=True) as (there, here):
        here.objects = there.objects
    (obj,) = here.objects
    bpy.context.scene.collection.objects.link(obj)
    made = obj.override_create(remap_local_usages=True)
    made.data.override_create(remap_local_usages=True)
    return made.data, tmp_path / "scene.blend"


def test_every_property_of_a_lamp_can_be_overridden(overridden):
    data, _ = overridden
    lamp = data.sdf_lamp
    groups = [lamp, lamp.emission, *(getattr(lamp, name) for name in properties.PRIMITIVES)]
    for group in groups:
        for prop in group.bl_rna.properties:
            if prop.identifier not in ("rna_type", "name", "as_text"):
                assert group.is_property_overridable_library(prop.identifier), prop.identifier
    for key in [key for key in data.keys() if key.startswith("sdf_") and key != "sdf_lamp"]:
        assert data.is_property_overridable_library(f'["{key}"]'), key


def test_overrides_are_there_when_the_file_is_opened_again(overridden, capfd):
    data, path = overridden
    name = data.name
    data.sdf_lamp.camera_brightness, data["sdf_unrest"], data["sdf_emission.wisps"] = 0.5, 0.02, 0.25
    data.sdf_lamp.emission.source, data.sdf_lamp.torus.major_radius = "NEON", 0.8
    shape = shape_of(data.sdf_lamp)
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    bpy.ops.wm.open_mainfile(filepath=str(path))
    (data,) = (light for light in bpy.data.lights if light.name == name and light.library is None)
    told = capfd.readouterr()
    assert "ERROR" not in told.out + told.err
    assert data.sdf_lamp.camera_brightness == 0.5 and data["sdf_unrest"] == pytest.approx(0.02)
    assert data.sdf_lamp.emission.source == "NEON" and data.sdf_lamp.torus.major_radius == pytest.approx(0.8)
    points = np.random.default_rng(6).uniform(-0.4, 0.4, (100, 3))
    assert shape_of(data.sdf_lamp).distance(points) == pytest.approx(shape.distance(points), abs=1e-6)
    assert data.energy == presets.presets()["campfire"].power
