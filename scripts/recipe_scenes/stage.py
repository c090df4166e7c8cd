# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What recipes share: the register, how a scene is opened, and lamps as the Add menu and the panels make them."""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable
from dataclasses import dataclass

import bpy
import host

SIZE, GALLERY_SIZE = (480, 320), (600, 400)
LOOK = "AgX - Medium High Contrast"


@dataclass(frozen=True)
class Recipe:
    """A scene with its steps. ``about`` and ``steps`` are Markdown; ``samples`` of a pixel make its picture."""

    name: str
    title: str
    about: str
    steps: tuple[str, ...]
    build: Callable[[bpy.types.Scene], None]
    samples: int
    gallery: bool
    texts: dict[str, str]  # expressions of several lines, by what they are

    @property
    def size(self) -> tuple[int, int]:
        return GALLERY_SIZE if self.gallery else SIZE


RECIPES: dict[str, Recipe] = {}


def recipe(title: str, samples: int, gallery: bool = False, **texts: str):
    """Register a function that fills an empty scene. Its docstring has a sentence, and then the steps, each with a
    number. ``texts``: expressions that the page shows."""

    def register(build):
        text = inspect.cleandoc(build.__doc__)
        about, _, listed = text.partition("\n\n")
        steps: list[str] = []
        for line in listed.splitlines():
            number, _, rest = line.partition(". ")
            if number.isdecimal():
                steps.append(rest)
            else:
                steps[-1] += " " + line.strip()
        about = " ".join(about.split())
        RECIPES[build.__name__] = Recipe(build.__name__, title, about, tuple(steps), build, samples, gallery, texts)
        return build

    return register


def build(name: str) -> bpy.types.Scene:
    """Open a new file with the scene of a recipe, ready to be rendered."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    host.register_extension()
    made, scene = RECIPES[name], bpy.context.scene
    scene.name = made.title
    scene.render.engine = host.ENGINE
    scene.render.resolution_x, scene.render.resolution_y = made.size
    scene.sdf_lights.samples, scene.sdf_lights.noise_threshold, scene.sdf_lights.denoise = made.samples, 0.0, True
    scene.view_settings.view_transform, scene.view_settings.look = "AgX", LOOK
    made.build(scene)
    bpy.context.view_layer.update()
    return scene


# -- lamps -------------------------------------------------------------------------------------------------------------


def lamp(location, rotation=(0.0, 0.0, 0.0), scale=1.0, **choice) -> bpy.types.Object:
    """Add > Light > SDF Lamp, with what is chosen there; rotation in degrees."""
    bpy.ops.sdf_lights.lamp_add(location=location, rotation=[math.radians(angle) for angle in rotation], **choice)
    made = bpy.context.active_object
    made.scale = (scale,) * 3 if isinstance(scale, float) else scale
    return made


def preset(name: str, location, rotation=(0.0, 0.0, 0.0), scale=1.0, **sliders) -> bpy.types.Object:
    """Add > Light > SDF Lamp > Presets; ``sliders`` of its shape."""
    made = lamp(location, rotation, scale, source="PRESET", preset=name.upper())
    for slider, value in sliders.items():
        made.data[f"sdf_{slider}"] = value
    return made


def expression(name: str, text: str, location, rotation=(0.0, 0.0, 0.0), scale=1.0) -> bpy.types.Object:
    """Add > Light > SDF Lamp > From an Expression; a text of several lines goes into a text block."""
    made = lamp(location, rotation, scale, source="EXPRESSION")
    made.name = made.data.name = name
    settings = made.data.sdf_lamp
    if "\n" in text.strip():
        settings.text = bpy.data.texts.new(name)
        settings.text.from_string(text)
    else:
        settings.expression = text
    return made


def primitive(shape: str, location, rotation=(0.0, 0.0, 0.0), **sizes) -> bpy.types.Object:
    """Add > Light > SDF Lamp, and a shape of its menus."""
    made = lamp(location, rotation, source="PRIMITIVE", shape=shape.upper())
    for name, value in sizes.items():
        setattr(getattr(made.data.sdf_lamp, shape), name, value)
    return made


def of_object(thing: bpy.types.Object, form: str = "SOLID") -> bpy.types.Object:
    """Object > Convert > To SDF Lamp, or To Neon Lamp."""
    bpy.ops.object.select_all(action="DESELECT")
    thing.select_set(True)
    bpy.context.view_layer.objects.active = thing
    bpy.ops.sdf_lights.object_to_lamp(form=form)
    return bpy.context.active_object


def shine(made: bpy.types.Object, power: float, color=None, kelvins: float = 0.0, camera: float | None = None):
    """The panel Emission, and the camera brightness of the panel Visibility; returns the lamp."""
    light = made.data
    light.energy = power
    if color is not None:
        light.use_temperature, light.color = False, color
    if kelvins:
        light.use_temperature, light.temperature, light.color = True, kelvins, (1.0, 1.0, 1.0)
    if camera is not None:
        light.sdf_lamp.camera_brightness = camera
    return made


def pattern(made: bpy.types.Object, source: str, **sliders) -> bpy.types.Object:
    """The panel Pattern: one of its patterns with its sliders, or an expression; returns the lamp."""
    settings = made.data.sdf_lamp.emission
    if "\n" in source or "(" in source:
        settings.text = bpy.data.texts.new(f"{made.name} Emission")
        settings.text.from_string(source)
        settings.source = "EXPRESSION"
    else:
        settings.source = source.upper()
    for slider, value in sliders.items():
        made.data[f"sdf_emission.{slider}"] = value
    return made
