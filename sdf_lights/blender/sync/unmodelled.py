# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a scene asks for and no other part of sync looks at: a sentence for each thing that Cycles would heed.

A check is a function in ``CHECKS``. Where something becomes modelled, its check goes.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import NamedTuple

import bpy

from ...render.kernels.rays import SHADOW_BITS
from ...render.passes import MATTES, PASSES, Owner
from .common import Warnings


class Asked(NamedTuple):
    """What is looked at: evaluated objects, but the scene and layer themselves. Settings of Cycles do not tag them for an
    update, so evaluated copies may be old."""

    scene: bpy.types.Scene
    view_layer: bpy.types.ViewLayer
    world: bpy.types.World | None
    objects: list[bpy.types.Object]  # each once, however many instances show it


def report_unmodelled(depsgraph: bpy.types.Depsgraph, world: bpy.types.World | None, warn: Warnings) -> None:
    """Warn of everything in the dependency graph that a ``CHECKS`` function finds."""
    asked = Asked(depsgraph.scene, depsgraph.view_layer, world, list(depsgraph.objects))
    for check in CHECKS:
        for sentence in check(asked):
            warn(sentence)


def _cycles(block, name: str, otherwise=None):
    """A setting of Cycles; ``otherwise`` where this Cycles has none, or its add-on is off."""
    return getattr(getattr(block, "cycles", None), name, otherwise)


def _names(names) -> str:
    return ", ".join(names)


# -- the scene ---------------------------------------------------------------------------------------------------------


def settings_of_cycles(asked: Asked) -> Iterator[str]:
    scene, render = asked.scene, asked.scene.render
    owner = f"Scene '{scene.name}'"
    if _cycles(scene, "use_fast_gi", False):
        yield f"{owner}: Fast GI is not supported: light is traced as without it; switch it off in Cycles to compare."
    if render.film_transparent and _cycles(scene, "film_transparent_glass", False):
        yield (
            f"{owner}: transparent glass on a transparent film is not supported: glass is opaque there; "
            "render the background, too."
        )
    if _cycles(scene, "use_sample_subset", False):
        yield (
            f"{owner}: a subset of samples is not supported: all of them are taken; to share samples among machines, "
            "give each a seed of its own and fewer samples."
        )
    if not render.use_simplify:
        return
    culling = [name for name in ("camera", "distance") if _cycles(scene, f"use_{name}_cull", False)]
    if any(_cycles(obj, f"use_{name}_cull", False) for name in culling for obj in asked.objects):
        yield f"{owner}: objects are not culled by camera or distance: all of them are rendered."
    if _cycles(scene, "texture_limit_render", "OFF") != "OFF":
        yield f"{owner}: a limit on the size of textures is not supported: they have the size of their files."


# -- the view layer ----------------------------------------------------------------------------------------------------

# Switches of Cycles' own that ask for a pass which has another switch here.
_ELSEWHERE = {"pass_debug_sample_count": "use_pass_sample_count", "denoising_store_passes": "use_pass_denoising_data"}
_OTHERS = {"use_pass_cryptomatte_accurate", "use_pass_grease_pencil"} | {
    f"use_pass_cryptomatte_{kind}" for kind in MATTES
}


def passes(asked: Asked) -> Iterator[str]:
    layer = asked.view_layer
    known = {item.switch for item in PASSES if item.owner is not Owner.OWN} | {"use_pass_combined"} | _OTHERS
    lacking, elsewhere = [], []
    for owner in (layer, getattr(layer, "cycles", None)):
        for prop in owner.bl_rna.properties if owner is not None else ():
            name = prop.identifier
            if name in known or prop.type != "BOOLEAN" or not getattr(owner, name):
                continue
            if name in _ELSEWHERE:
                if not getattr(layer.sdf_lights, _ELSEWHERE[name]):
                    elsewhere.append(prop.name)
            elif name.startswith("use_pass_") or name == "pass_render_time":
                lacking.append(prop.name)
    if lacking:
        yield (
            f"View layer '{layer.name}': these passes are not supported and are left out: {_names(lacking)}; switch "
            "them off, or render them with Cycles."
        )
    if elsewhere:
        yield (
            f"View layer '{layer.name}': these passes have a switch of their own in this engine, which is off: "
            f"{_names(elsewhere)}; find it in View Layer Properties > Passes."
        )


def filters(asked: Asked) -> Iterator[str]:
    layer = asked.view_layer
    off = [
        label
        for name, label in (
            ("use_strand", "Curves"),
            ("use_volumes", "Volumes"),
        )
        if not getattr(layer, name, True)
    ]
    if off:
        yield (
            f"View layer '{layer.name}': its filter is not supported, so this is rendered all the same: {_names(off)}; "
            "exclude collections, or hide the world from the camera."
        )


# -- objects -----------------------------------------------------------------------------------------------------------


def light_linking(asked: Asked) -> Iterator[str]:
    known = {
        collection
        for obj in asked.objects
        if (collection := getattr(getattr(obj, "light_linking", None), "blocker_collection", None)) is not None
    }
    if len(known) > len(SHADOW_BITS):
        yield (
            f"Scene '{asked.scene.name}': there are {len(known)} collections for shadow linking, and no more than "
            f"{len(SHADOW_BITS)} can be told apart: all objects cast the shadows of lights with others; share collections."
        )


def shadow_catchers(asked: Asked) -> Iterator[str]:
    for obj in asked.objects:
        if obj.is_shadow_catcher and obj.type not in {"LIGHT", "LIGHT_PROBE"}:  # where Blender switches it on by itself
            yield (
                f"Object '{obj.name}' is a shadow catcher, which is not supported: it is rendered as it is; "
                "render the scene with and without the other objects, and divide."
            )


def hair(asked: Asked) -> Iterator[str]:
    for obj in asked.objects:
        for modifier in obj.modifiers:
            if modifier.type != "PARTICLE_SYSTEM" or not modifier.show_render:
                continue
            settings = modifier.particle_system.settings
            if settings.render_type == "PATH" and (settings.type == "HAIR" or settings.use_strand_primitive):
                yield (
                    f"Object '{obj.name}': the hair of particle system '{modifier.particle_system.name}' is not "
                    "supported and is left out; convert it to a mesh."
                )


def subdivision(asked: Asked) -> Iterator[str]:
    for obj in asked.objects:
        if _cycles(obj, "use_adaptive_subdivision", False) or any(
            getattr(modifier, "use_adaptive_subdivision", False) for modifier in obj.modifiers
        ):
            yield (
                f"Object '{obj.name}': adaptive subdivision is not supported: it is divided as often as the modifier "
                "says for renders; raise Levels Render."
            )


def shadow_terminators(asked: Asked) -> Iterator[str]:
    for obj in asked.objects:
        if obj.type == "MESH" and obj.shadow_terminator_shading_offset > 0.0:
            yield (
                f"Object '{obj.name}': the shading offset of its shadow terminator is not supported; divide its faces "
                "where they show in the shadow."
            )


# -- lights and the world ----------------------------------------------------------------------------------------------


def shadow_caustics(asked: Asked) -> Iterator[str]:
    lights = [
        obj.name for obj in asked.objects if obj.type == "LIGHT" and _cycles(obj.data, "is_caustics_light", False)
    ]
    if _cycles(asked.world, "is_caustics_light", False):
        lights.append(asked.world.name)
    if lights and any(_cycles(obj, "is_caustics_caster", False) for obj in asked.objects):
        yield (
            f"Scene '{asked.scene.name}': shadow caustics have no method of their own here: the caustics of "
            f"{_names(lights)} are found by chance; give small lights a radius, and take more samples."
        )


def world_shadows(asked: Asked) -> Iterator[str]:
    world = asked.world
    if world is not None and not _cycles(world, "use_shadows", True):
        yield f"World '{world.name}': its light always casts shadows; switch its Cast Shadow on in Cycles to compare."


CHECKS: tuple[Callable[[Asked], Iterator[str]], ...] = (
    settings_of_cycles,
    passes,
    filters,
    light_linking,
    shadow_catchers,
    hair,
    subdivision,
    shadow_terminators,
    shadow_caustics,
    world_shadows,
)
