# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Render passes in Blender: their switches, registration and names, from the table ``render.passes.PASSES``."""

from collections.abc import Iterable

import bpy

from ..render.passes import (
    MATTES,
    OLD_NAMES,
    PASSES,
    Kind,
    Owner,
    Pass,
    aov_pass,
    light_group_pass,
    matte_passes,
    own_pass,
)
from .properties import group


def blender_name(item: Pass) -> str:
    """The name of a pass in this version of Blender."""
    return OLD_NAMES.get(item.name, item.name) if bpy.app.version < (5, 0, 0) else item.name


def _own_switches() -> dict:
    """A property for each of our own switches. Its tooltip describes all passes of the switch."""
    switches: dict[str, list[Pass]] = {}
    for item in PASSES:
        if item.owner is Owner.OWN:
            switches.setdefault(item.switch, []).append(item)
    return {
        switch: bpy.props.BoolProperty(
            name=switch.removeprefix("use_pass_").replace("_", " ").title().replace("Sdf", "SDF"),
            description="; ".join(item.description for item in items),
            default=False,
            update=_passes_changed,
        )
        for switch, items in switches.items()
    }


def _passes_changed(self, context):
    """Let Blender ask the engine again for its passes, so the compositor shows their sockets."""
    for view_layer in self.id_data.view_layers:
        view_layer.update_render_passes()


SDFLIGHTS_ViewLayerSettings = group(
    "SDFLIGHTS_ViewLayerSettings", "Passes of the SDF Lights render engine", _own_switches()
)


def owner_of(item: Pass, view_layer: bpy.types.ViewLayer):
    """The owner of the property ``item.switch``."""
    if item.owner is Owner.CYCLES:
        return getattr(view_layer, "cycles", None)  # exists only while the Cycles add-on is enabled
    return view_layer.sdf_lights if item.owner is Owner.OWN else view_layer


def is_enabled(item: Pass, view_layer: bpy.types.ViewLayer) -> bool:
    """Whether the switch of the pass is on in the view layer."""
    return item.switch is None or getattr(owner_of(item, view_layer), item.switch, False)


def own_pass_name(obj: bpy.types.Object) -> str:
    """Name of the pass of a single light. Dots would end a name in files, so they are replaced."""
    return f"Light {obj.name}".replace(".", "_")[:60]


def layer_passes(view_layer: bpy.types.ViewLayer) -> list[Pass]:
    """Passes of a view layer that are not in ``PASSES``: Cryptomatte, shader AOVs, light groups, and single lights."""
    found = []
    for kind in MATTES:
        if getattr(view_layer, f"use_pass_cryptomatte_{kind}"):
            found += matte_passes(kind, view_layer.pass_cryptomatte_depth)
    found += [aov_pass(aov.name, aov.type == "VALUE") for aov in view_layer.aovs if aov.is_valid]
    found += [light_group_pass(group.name) for group in view_layer.lightgroups]
    names = [own_pass_name(obj) for obj in view_layer.objects if obj.type == "LIGHT" and obj.data.sdf_lamp.use_pass]
    known = {item.name for item in (*PASSES, *found)}
    return found + [own_pass(name) for name in dict.fromkeys(names) if name not in known]


def register_passes(engine: bpy.types.RenderEngine, scene: bpy.types.Scene, view_layer: bpy.types.ViewLayer) -> None:
    """Tell Blender the passes of the view layer."""
    for item in (*PASSES, *layer_passes(view_layer)):
        if is_enabled(item, view_layer):
            engine.register_pass(
                scene, view_layer, blender_name(item), len(item.channels), item.channels, item.kind.value
            )


def enabled_passes(names, others: Iterable[Pass] = ()) -> dict[str, str]:
    """Blender's pass names among ``names`` (those of a render result), by the name in the table or in ``others``."""
    return {item.name: blender_name(item) for item in (*PASSES, *others) if blender_name(item) in set(names)}


def switches(light: bool) -> list[tuple[Pass, str]]:
    """Passes with a switch, each switch once, with a label if Blender's does not fit: those of light, or of data."""
    first: dict[str, Pass] = {}
    for item in PASSES:
        if item.switch:
            first.setdefault(item.switch, item)
    return [
        (item, "" if item.owner is Owner.OWN else item.name)
        for item in first.values()
        if (item.kind is Kind.COLOR) == light
    ]


CLASSES = (SDFLIGHTS_ViewLayerSettings,)


def register():
    bpy.types.ViewLayer.sdf_lights = bpy.props.PointerProperty(name="SDF Lights", type=SDFLIGHTS_ViewLayerSettings)


def unregister():
    del bpy.types.ViewLayer.sdf_lights
