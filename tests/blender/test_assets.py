# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Lamps as assets, and the presets as a library."""

import bpy
import numpy as np
import pytest

from sdf_lights.blender import assets
from sdf_lights.blender.lamp import shape_of
from sdf_lights.blender.presets import presets


def pixels(preview) -> np.ndarray:
    values = np.empty(4 * preview.image_size[0] * preview.image_size[1], np.float32)
    preview.image_pixels_float.foreach_get(values)
    return values.reshape(preview.image_size[1], preview.image_size[0], 4)


def test_a_lamp_is_marked_with_a_picture_of_its_shape(file, add, lamp, monkeypatch):
    monkeypatch.setattr(assets, "_SIZE", 16)  # the NumPy reference renders these few
    obj = add("Lamp", lamp(shape="TORUS", major_radius=0.5, minor_radius=0.2), location=(7.0, 0.0, 0.0))
    obj.data.color = (1.0, 0.1, 0.1)
    obj.select_set(True)
    assert bpy.ops.sdf_lights.lamp_mark_asset() == {"FINISHED"}
    assert obj.asset_data is not None
    picture = pixels(obj.preview)
    assert picture.shape == (16, 16, 4) and picture[..., 0].max() > 0.5 > picture[0, 0, 0]
    assert picture[..., 0].mean() > picture[..., 2].mean()


def test_the_presets_become_a_library(file, tmp_path, monkeypatch):
    monkeypatch.setattr(assets, "folder", lambda: tmp_path)
    libraries = bpy.context.preferences.filepaths.asset_libraries
    before = len(libraries)
    for _ in range(2):  # again is no second library
        assert bpy.ops.sdf_lights.asset_library_add() == {"FINISHED"}
    assert len(libraries) == before + 1 and libraries[-1].name == assets.LIBRARY
    libraries.remove(libraries[-1])
    assert not bpy.data.lights and not bpy.data.texts and not bpy.data.objects.get("Campfire")
    with bpy.data.libraries.load(str(tmp_path / "lamps.blend"), assets_only=True) as (there, here):
        here.objects = list(there.objects)
    assert {obj.name for obj in here.objects} == {preset.title for preset in presets().values()}
    fire = bpy.data.objects["Campfire"]
    assert fire.data.energy == presets()["campfire"].power and fire.asset_data is not None
    assert shape_of(fire.data.sdf_lamp).bounds()[1].max() > 0.1
    assert pixels(fire.preview).max() == pytest.approx(1.0)


def test_a_library_that_cannot_be_written_is_named(file, tmp_path, monkeypatch):
    (tmp_path / "file").write_text("")
    monkeypatch.setattr(assets, "folder", lambda: tmp_path / "file" / "below")
    with pytest.raises(RuntimeError, match="cannot be written"):
        bpy.ops.sdf_lights.asset_library_add()
    assert not bpy.data.lights
