# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Odd texts, meshes, pictures and files at F12: each is a lamp, or is named in one sentence, and the others are
rendered."""

import bpy
import numpy as np
import pytest

from sdf_lights.sdf.data.network import EXAMPLE
from support import grids

GLYPHS = (*range(33, 127), *range(161, 384), *range(0x391, 0x3CA), *range(0x410, 0x450))
"""Of Blender's own font."""


@pytest.fixture
def lamp_from(file, lamp, add):
    """Function: adds a lamp of a source, with settings."""

    def make(name: str, data: bpy.types.ID | None = None, **settings) -> None:
        light = lamp(name)
        if data is not None:
            settings = dict(source="OBJECT", object=add(f"{name} Source", data)) | settings
        for key, value in settings.items():
            setattr(light.sdf_lamp, key, value)
        add(name, light)

    return make


def _text(body: str) -> bpy.types.Curve:
    curve = bpy.data.curves.new("Text", "FONT")
    curve.body = body
    return curve


def _mesh(vertices, faces) -> bpy.types.Mesh:
    mesh = bpy.data.meshes.new("Mesh")
    mesh.from_pydata(np.asarray(vertices).tolist(), [], np.asarray(faces).tolist())
    return mesh


def _suzanne() -> bpy.types.Mesh:
    bpy.ops.mesh.primitive_monkey_add()
    mesh = bpy.context.object.data
    bpy.data.objects.remove(bpy.context.object)
    return mesh


def _wide() -> bpy.types.Image:
    pixels = np.zeros((20, 20_000, 4), np.float32)
    pixels[5:15, 100:-100] = 1.0
    image = bpy.data.images.new("Wide", 20_000, 20, alpha=True)
    image.pixels.foreach_set(pixels.ravel())
    return image


@pytest.mark.parametrize("triangles", [3_000, pytest.param(300_000, marks=pytest.mark.slow)])
def test_odd_sources_are_lamps_or_are_named_in_one_sentence(synced, lamp_from, tmp_path, triangles):
    ring, faces = grids.torus(0.7, 0.25, 48, 24)
    lamp_from("Glyphs", _text("\n".join(map("".join, np.array_split([chr(code) for code in GLYPHS], 20)))))
    lamp_from("Paragraph", _text("\n".join(["the quick brown fox."] * 10)))
    lamp_from("Suzanne", _suzanne(), voxel_size=0.05)
    lamp_from("Scan", _mesh(*grids.scan(triangles)), voxel_size=0.0 if triangles > 10_000 else 0.05)
    lamp_from("Open", _mesh(ring, faces[200:]), voxel_size=0.05)
    lamp_from("Bare", _mesh(ring, np.zeros((0, 3), int)))
    lamp_from("Sheet", _mesh([(0, 0, 0), (1, 0, 0), (1, 1, 0)], [(0, 1, 2)]))
    lamp_from("Undefined", _mesh([(0, 0, 0), (1, 0, 0), (0, np.nan, 0)], [(0, 1, 2)]))
    lamp_from("Picture", source="IMAGE", image=_wide(), image_size=2.0)
    whole = EXAMPLE.read_bytes()
    (tmp_path / "cut.npz").write_bytes(whole[: len(whole) // 2])
    lamp_from("Network", source="NETWORK", network=str(tmp_path / "cut.npz"))
    (tmp_path / "cut.vdb").write_bytes(b" BDV" + bytes(4) + (224).to_bytes(4, "little") + bytes(20))
    volume = bpy.data.volumes.new("Volume")
    volume.filepath = str(tmp_path / "cut.vdb")
    lamp_from("Volume", volume)
    scene = synced()
    expected = {"Glyphs", "Paragraph", "Suzanne", "Scan", "Open", "Picture"}
    assert {lamp.name for lamp in scene.lamps} == expected
    for name in ("Bare", "Sheet", "Undefined", "Network", "Volume"):
        told = [sentence for sentence in scene.warnings if sentence.startswith(f"Lamp '{name}' is left out. ")]
        assert len(told) == 1, (name, scene.warnings)
        assert told[0].endswith(".") and ":" in told[0] and "\n" not in told[0] and len(told[0]) < 300
    assert not [sentence for sentence in scene.warnings if any(f"Lamp '{name}'" in sentence for name in expected)]
