# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Saves the meaning of files with this version of the settings, so that tests can check it for ever.

    .venv-3.11-blender-4.5/bin/python scripts/version_files.py FOLDER [settings|scenes …]

Writes ``settings<version>-blender<x.y>.blend``, with all settings off their defaults, every primitive, every preset and
presets as nodes. And ``scenes<version>-blender<x.y>.blend``, with small scenes: one for each kind of source of a lamp
and one of view layers and passes. Beside each it writes a ``.json`` with its meaning: the settings by name, the
distances and emissions of lamps at some points, and the mean of a render of each view layer of the small scenes. Save
with the oldest supported Blender, because later ones must open it, and with the newest.
"""

from __future__ import annotations

import json
import os
import pathlib
import sys
import tempfile

import bpy
import host
import numpy as np
import object_lamps

from sdf_lights import blender
from sdf_lights.blender import lamp_presets, versions
from sdf_lights.blender.lamp import pattern_of, shape_of
from sdf_lights.blender.naming import ENGINE
from sdf_lights.blender.nodes.editor import to_nodes
from sdf_lights.blender.presets import presets
from sdf_lights.blender.properties import PRIMITIVES
from support import openexr

POINTS = np.random.default_rng(1).uniform(-1.0, 1.0, (10, 3))
# Means of their renders then have a standard deviation of 0.2 % at most.
SAMPLES = 256
IN_NODES = ("lantern", "campfire", "snowflake")
PLAIN = ("BOOLEAN", "INT", "FLOAT", "STRING", "ENUM")


def settings_of(group: bpy.types.PropertyGroup, unset: bool = False) -> dict:
    """Values of the plain properties of a group, and of the groups in it, that are set, by name; with ``unset``, of
    all: a file keeps its meaning, even if a default changes."""
    found = {}
    for item in group.bl_rna.properties:
        value = getattr(group, item.identifier)
        if item.identifier in ("rna_type", "name") or item.is_readonly and item.type != "POINTER":
            continue
        if item.type in PLAIN and (unset or group.is_property_set(item.identifier)):
            found[item.identifier] = list(value) if getattr(item, "is_array", False) else value
        elif isinstance(value, bpy.types.PropertyGroup):
            found |= {item.identifier: inner} if (inner := settings_of(value, unset)) else {}
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


def _plaster() -> bpy.types.Material:
    """A diffuse material: that of surfaces without one differs between versions of Blender."""
    made = bpy.data.materials.get("Plaster") or bpy.data.materials.new("Plaster")
    made.use_nodes = True
    tree = made.node_tree
    tree.nodes.clear()
    diffuse, output = tree.nodes.new("ShaderNodeBsdfDiffuse"), tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(diffuse.outputs[0], output.inputs["Surface"])
    return made


def _stage() -> bpy.types.Scene:
    """The open scene: a camera above a floor."""
    scene = bpy.context.scene
    scene.render.engine = ENGINE
    scene.render.resolution_x, scene.render.resolution_y = 16, 12
    settings = scene.sdf_lights
    settings.device, settings.samples, settings.noise_threshold, settings.seed = "CPU", 8, 0.0, 7
    # What is measured while it renders may differ between two renders.
    settings.guided_samples, settings.indirect_paths, settings.lamp_paths = False, 1, "NEVER"
    settings.path_reuse = settings.caustic_paths = "NEVER"
    camera = object_lamps.add("Camera", bpy.data.cameras.new("Camera"), (0.0, -5.0, 1.5), (1.4, 0.0, 0.0))
    scene.camera = camera
    floor = bpy.data.meshes.new("Floor")
    floor.from_pydata([(-4, -4, 0), (4, -4, 0), (4, 4, 0), (-4, 4, 0)], [], [(0, 1, 2, 3)])
    floor.materials.append(_plaster())
    object_lamps.add("Floor", floor, rotation=(0.0, 0.0, 0.0))
    return scene


def _lamp(name: str, x: float, **settings) -> bpy.types.Light:
    light = bpy.data.lights.new(name, "POINT")
    light.energy, light.color = 60.0, (1.0, 0.6, 0.3)
    light.sdf_lamp.use = True
    for key, value in settings.items():
        setattr(light.sdf_lamp, key, value)
    object_lamps.add(name, light, (x, 0.0, 1.2), (0.3, 0.2, 0.1))
    return light


def expressions() -> None:
    """Operators, fields and sliders, in a line and in a text; emissions as a preset and as formulas."""
    _stage()
    line = "smooth_union(box(0.4), torus(0.5, 0.1), radius=0.1) - cylinder(0.2, 1)"
    _lamp("Operators", -1.4, source="EXPRESSION", expression=line).sdf_lamp.emission.source = "SHELL"
    text = bpy.data.texts.new("Gyroid")
    text.write(
        "cell = slider(0.5, 0.2, 2)\nq = p * tau / cell\n"
        "field(abs(dot(sin(q), cos((q.y, q.z, q.x)))) - 0.25) & sphere(0.6)\n"
    )
    field = _lamp("Field", 0.0, source="EXPRESSION", text=text)
    field["sdf_cell"] = 0.7
    glow = _lamp("Glow", 1.4, shape="SPHERE").sdf_lamp.emission
    glow.source, glow.expression = "EXPRESSION", "exp(-9 * depth) * blackbody(mix(2500, 1300, height))"


def nodes() -> None:
    """A preset as a node tree, and a tree of the start."""
    _stage()
    light = _lamp("Lantern", -0.8)
    lamp_presets.load_preset(light, "lantern")
    to_nodes(light)
    light = _lamp("Campfire", 0.8)
    lamp_presets.load_preset(light, "campfire")
    to_nodes(light)


def fractals() -> None:
    """Fractals off their defaults."""
    _stage()
    for x, name in ((-1.2, "mandelbulb"), (0.0, "menger_sponge"), (1.2, "koch_snowflake")):
        _change(getattr(_lamp(name, x, shape=name.upper()).sdf_lamp, name))


def things() -> None:
    """Lamps of a text, a curve, a mesh, a picture and a network."""
    _stage()
    text = object_lamps.add("Text", object_lamps.text("hi", 0.9), (-1.5, 0.0, 0.6))
    curve = object_lamps.add("Curve", object_lamps.bend(), (0.0, 0.5, 0.4))
    roof = bpy.data.meshes.new("Roof")
    corners = [(-0.3, -0.3, 0), (0.3, -0.3, 0), (0.3, 0.3, 0), (-0.3, 0.3, 0), (0.1, 0.0, 0.5)]
    roof.from_pydata(corners, [], [(3, 2, 1, 0), (0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4)])
    mesh = object_lamps.add("Mesh", roof, (0.3, -0.4, 0.5))
    for x, obj, form in ((-1.5, text, "NEON"), (0.0, curve, "SOLID"), (0.3, mesh, "SOLID")):
        obj.hide_render = True
        _lamp(f"Of {obj.name}", x, source="OBJECT", object=obj, object_form=form, neon_radius=0.04)
    picture = _lamp("Picture", 1.5, source="IMAGE", image=object_lamps.logo(64), image_size=0.9, thickness=0.2)
    picture.sdf_lamp.camera_brightness = 0.5
    _lamp("Network", 0.0, source="NETWORK").energy = 12.0


def layers() -> None:
    """Two view layers with passes, another lamp in each, and settings off their defaults."""
    scene = _stage()
    for name, x, power in (("Left", -0.8, 40.0), ("Right", 0.8, 90.0)):
        _lamp(name, x, normalize=False, density=2.5, use_pass=True).energy = power
        collection = bpy.data.collections.new(name)
        scene.collection.children.link(collection)
        collection.objects.link(bpy.data.objects[name])
        scene.collection.objects.unlink(bpy.data.objects[name])
    second = scene.view_layers.new("Second")
    second.layer_collection.children["Left"].exclude = True
    second.samples = 8
    for layer, passes in ((scene.view_layers[0], ("z", "normal", "mist")), (second, ("position", "emit"))):
        for name in passes:
            setattr(layer, f"use_pass_{name}", True)
        _change(layer.sdf_lights)
    settings = scene.sdf_lights
    settings.max_bounces, settings.clamp_indirect, settings.exposure, settings.filter = 3, 5.0, 0.8, "BOX"
    settings.viewport.samples, settings.layer_samples = 77, "USE"


SCENES = {each.__name__: each for each in (expressions, nodes, fractals, things, layers)}


def build_scenes() -> None:
    """The file of small scenes, as the open one: one file, because what Blender adds to each is most of it."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    empty = bpy.context.scene
    for name, make in SCENES.items():
        scene = bpy.data.scenes.new(name)
        with bpy.context.temp_override(scene=scene, view_layer=scene.view_layers[0]):
            make()
    bpy.data.scenes.remove(empty)


def means(scene: bpy.types.Scene) -> dict:
    """The mean of Combined of each view layer, (3,), of a render of a scene with ``SAMPLES`` samples."""
    scene.sdf_lights.samples = SAMPLES
    for layer in scene.view_layers:
        layer.samples = 0
    settings = scene.render.image_settings
    if hasattr(settings, "media_type"):  # new in 5.0
        settings.media_type = "MULTI_LAYER_IMAGE"
    settings.file_format, settings.color_depth = "OPEN_EXR_MULTILAYER", "32"
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "picture.exr"
        scene.render.filepath = str(path)
        bpy.ops.render.render(write_still=True, scene=scene.name)
        return {
            layer: _rounded(passes["Combined"][..., :3].mean(axis=(0, 1)))
            for layer, passes in openexr.read_passes(path).items()
        }


def layers_of(scene: bpy.types.Scene) -> dict:
    """Passes and settings of view layers, by name."""
    return {
        layer.name: settings_of(layer.sdf_lights, unset=True)
        | {"samples": layer.samples}
        | {name: getattr(layer, name) for name in dir(layer) if name.startswith("use_pass_")}
        for layer in scene.view_layers
    }


def contents(unset: bool = False) -> dict:
    """The meaning of the open file. For a lamp's primitives, only the shown one. ``unset``: of ``settings_of``."""
    lamps = {}
    for light in sorted((light for light in bpy.data.lights if light.sdf_lamp.use), key=lambda light: light.name):
        settings = settings_of(light.sdf_lamp, unset)
        shown = light.sdf_lamp.shape.lower() if light.sdf_lamp.source == "PRIMITIVE" else None
        kept = {name: value for name, value in settings.items() if name not in PRIMITIVES or name == shown}
        lamps[light.name] = kept | meaning_of(light)
    return dict(scene=settings_of(bpy.context.scene.sdf_lights, unset), lamps=lamps)


def scenes_contents() -> dict:
    """The meaning of the file of small scenes, with their renders."""
    lamps = contents(unset=True)["lamps"]
    return dict(
        lamps=lamps,
        scenes={
            scene.name: dict(
                settings=settings_of(scene.sdf_lights, unset=True), layers=layers_of(scene), means=means(scene)
            )
            for scene in bpy.data.scenes
        },
    )


FILES = {"settings": (build, contents), "scenes": (build_scenes, scenes_contents)}


def main() -> None:
    folder = pathlib.Path(sys.argv[1])
    os.environ.setdefault("SDF_LIGHTS_CACHE", str(host.REPOSITORY / "build" / "kernels"))
    blender.register()
    folder.mkdir(parents=True, exist_ok=True)
    for name in sys.argv[2:] or FILES:
        make, meaning = FILES[name]
        make()
        path = folder / f"{name}{versions.VERSION}-blender{bpy.app.version[0]}.{bpy.app.version[1]}.blend"
        bpy.ops.wm.save_as_mainfile(filepath=str(path), compress=True, check_existing=False)
        path.with_suffix(".json").write_text(json.dumps(meaning()) + "\n", encoding="utf-8")
        print(f"{path}: {path.stat().st_size / 1e3:.0f} KB; {len(bpy.data.lights)} lamps")
    host.finish(0)


if __name__ == "__main__":
    main()
