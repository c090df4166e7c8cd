# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Saves the meaning of files with this version of the settings, so that tests can check it for ever.

    .venv-3.11-blender-4.5/bin/python scripts/version_files.py FOLDER

Writes ``settings<version>-blender<x.y>.blend``, with all settings off their defaults, every primitive, every preset and
presets as nodes. Beside it, it writes a ``.json`` with their meaning: the settings by name, and the distances and
emissions of lamps at some points. Save with the oldest supported Blender, because later ones must open it.
"""

from __future__ import annotations

import json
import pathlib
import sys

import bpy
import host  # noqa: F401  (puts the repository on the path)
import numpy as np

from sdf_lights import blender
from sdf_lights.blender import lamp_presets, versions
from sdf_lights.blender.lamp import pattern_of, shape_of
from sdf_lights.blender.nodes.editor import to_nodes
from sdf_lights.blender.presets import presets
from sdf_lights.blender.properties import PRIMITIVES

POINTS = np.random.default_rng(1).uniform(-1.0, 1.0, (10, 3))
IN_NODES = ("lantern", "campfire", "snowflake")
PLAIN = ("BOOLEAN", "INT", "FLOAT", "STRING", "ENUM")


def settings_of(group: bpy.types.PropertyGroup) -> dict:
    """Values of the plain properties of a group, and of the groups in it, that are set, by name."""
    found = {}
    for item in group.bl_rna.properties:
        value = getattr(group, item.identifier)
        if item.identifier in ("rna_type", "name") or item.is_readonly and item.type != "POINTER":
            continue
        if item.type in PLAIN and group.is_property_set(item.identifier):
            found[item.identifier] = list(value) if getattr(item, "is_array", False) else value
        elif isinstance(value, bpy.types.PropertyGroup):
            found |= {item.identifier: inner} if (inner := settings_of(value)) else {}
    return found


def meaning_of(light: bpy.types.Light) -> dict:
    """Distances of a lamp's shape at ``POINTS``, and its emission there; None if that is uniform."""
    shape, pattern = shape_of(light.sdf_lamp), pattern_of(light.sdf_lamp)
    emission = None if pattern is None else pattern.placed(shape).evaluate(POINTS)
    return dict(distances=_rounded(shape.distance(POINTS)), emission=None if emission is None else _rounded(emission))


def _rounded(values: np.ndarray) -> list:
    return np.round(np.asarray(values, float), 7).tolist()


def _change(group: bpy.types.PropertyGroup) -> None:
    """Change all plain settings from their defaults."""
    for item in group.bl_rna.properties:
        name = item.identifier
        if name in ("rna_type", "name", "version") or item.is_readonly and item.type != "POINTER":
            continue
        if item.type == "POINTER" and isinstance(getattr(group, name), bpy.types.PropertyGroup):
            _change(getattr(group, name))
        elif item.type == "BOOLEAN":
            setattr(group, name, not item.default)
        elif item.type == "INT":
            setattr(group, name, min(item.default + 3, item.hard_max))
        elif item.type == "FLOAT" and not item.is_array:
            setattr(group, name, min(item.default * 0.75 + 0.05, item.hard_max))
        elif item.type == "ENUM":
            setattr(group, name, item.enum_items[-1].identifier)


def build() -> None:
    """The file of this version, as the open one."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.engine = "SDF_LIGHTS"
    _change(scene.sdf_lights)

    def add(name: str) -> bpy.types.Light:
        light = bpy.data.lights.new(name, "POINT")
        scene.collection.objects.link(bpy.data.objects.new(name, light))
        return light

    for name in PRIMITIVES:
        light = add(f"primitive {name}")
        light.sdf_lamp.use, light.sdf_lamp.shape = True, name.upper()
        _change(getattr(light.sdf_lamp, name))
        light.sdf_lamp.density, light.sdf_lamp.normalize = 2.5, False
    for name in presets():
        lamp_presets.load_preset(add(f"preset {name}"), name)
    for name in IN_NODES:
        light = add(f"nodes {name}")
        lamp_presets.load_preset(light, name)
        to_nodes(light)


def contents() -> dict:
    """The meaning of the open file. For a lamp's primitives, only the shown one."""
    lamps = {}
    for light in sorted((light for light in bpy.data.lights if light.sdf_lamp.use), key=lambda light: light.name):
        settings = settings_of(light.sdf_lamp)
        shown = light.sdf_lamp.shape.lower() if light.sdf_lamp.source == "PRIMITIVE" else None
        kept = {name: value for name, value in settings.items() if name not in PRIMITIVES or name == shown}
        lamps[light.name] = kept | meaning_of(light)
    return dict(scene=settings_of(bpy.context.scene.sdf_lights), lamps=lamps)


def main() -> None:
    folder = pathlib.Path(sys.argv[1])
    blender.register()
    build()
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"settings{versions.VERSION}-blender{bpy.app.version[0]}.{bpy.app.version[1]}.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path), compress=True, check_existing=False)
    path.with_suffix(".json").write_text(json.dumps(contents()) + "\n", encoding="utf-8")
    print(f"{path}: {path.stat().st_size / 1e3:.0f} KB; {len(bpy.data.lights)} lamps")


if __name__ == "__main__":
    main()
