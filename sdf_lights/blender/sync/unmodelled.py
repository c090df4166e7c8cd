# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Features of a scene that no other part of sync reads: a sentence for each that Cycles would render.

A check is a function in ``CHECKS``. When a feature becomes supported, remove its check.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import NamedTuple

import bpy

from ...render.kernels.rays import SHADOW_BITS
from ...render.passes import MATTES, PASSES, Owner
from .common import Warnings
from .grids import smoke_domain


class Asked(NamedTuple):
    """The data that checks read: evaluated objects, but the original scene and layer. Cycles' settings do not tag them
    for an update, so evaluated copies may be old."""

    scene: bpy.types.Scene
    view_layer: bpy.types.ViewLayer
    world: bpy.types.World | None
    objects: list[bpy.types.Object]  # each once, however many instances use it


def report_unmodelled(depsgraph: bpy.types.Depsgraph, world: bpy.types.World | None, warn: Warnings) -> None:
    """Warn of everything in the dependency graph that a ``CHECKS`` function finds."""
    asked = Asked(depsgraph.scene, depsgraph.view_layer, world, list(depsgraph.objects))
    for check in CHECKS:
        for sentence in check(asked):
            warn(sentence)


def _cycles(block, name: str, otherwise=None):
    """A setting of Cycles; ``otherwise`` if this Cycles has none, or its add-on is off."""
    return getattr(getattr(block, "cycles", None), name, otherwise)


def _names(names) -> str:
    return ", ".join(names)


# -- the scene ---------------------------------------------------------------------------------------------------------


def settings_of_cycles(asked: Asked) -> Iterator[str]:
    """Settings of Cycles' scene."""
    scene, render = asked.scene, asked.scene.render
    owner = f"Scene '{scene.name}'"
    if _cycles(scene, "use_fast_gi", False):
        yield f"{owner}: Fast GI is not supported: light is traced in full; switch it off in Cycles to compare."
    if render.film_transparent and _cycles(scene, "film_transparent_glass", False):
        yield (
            f"{owner}: transparent glass on a transparent film is not supported: glass is opaque there; "
            "render the background, too."
        )


# -- the view layer ----------------------------------------------------------------------------------------------------

# Cycles' switches for passes that have another switch here.
_ELSEWHERE = {"pass_debug_sample_count": "use_pass_sample_count", "denoising_store_passes": "use_pass_denoising_data"}
_OTHERS = {"use_pass_cryptomatte_accurate", "use_pass_grease_pencil"} | {
    f"use_pass_cryptomatte_{kind}" for kind in MATTES
}


def passes(asked: Asked) -> Iterator[str]:
    """Passes of the view layer that are not in ``PASSES``."""
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
            f"View layer '{layer.name}': these passes have a separate switch in this engine, which is off: "
            f"{_names(elsewhere)}; find it in View Layer Properties > Passes."
        )


# -- objects -----------------------------------------------------------------------------------------------------------


def light_linking(asked: Asked) -> Iterator[str]:
    """More collections of shadow linking than bits."""
    known = {
        collection
        for obj in asked.objects
        if (collection := getattr(getattr(obj, "light_linking", None), "blocker_collection", None)) is not None
    }
    if len(known) > len(SHADOW_BITS):
        yield (
            f"Scene '{asked.scene.name}': it has {len(known)} collections for shadow linking, but at most "
            f"{len(SHADOW_BITS)} are supported: lights with other collections get the shadows of all objects; share "
            "collections."
        )


def subdivision(asked: Asked) -> Iterator[str]:
    """Adaptive subdivision."""
    for obj in asked.objects:
        if _cycles(obj, "use_adaptive_subdivision", False) or any(
            getattr(modifier, "use_adaptive_subdivision", False) for modifier in obj.modifiers
        ):
            yield (
                f"Object '{obj.name}': adaptive subdivision is not supported: it is divided as often as the modifier "
                "says for renders; raise Levels Render."
            )


def shadow_terminators(asked: Asked) -> Iterator[str]:
    """The shading offset of shadow terminators."""
    for obj in asked.objects:
        if obj.type == "MESH" and obj.shadow_terminator_shading_offset > 0.0:
            yield (
                f"Object '{obj.name}': the shading offset of its shadow terminator is not supported; divide its faces "
                "where the shadow shows them."
            )


def velocity_of_voxels(asked: Asked) -> Iterator[str]:
    """Motion blur by the velocity grids of volumes and of smoke."""
    if not asked.scene.render.use_motion_blur:
        return
    for obj in asked.objects:
        if obj.type == "VOLUME":
            moves = obj.data.velocity_grid in {grid.name for grid in obj.data.grids}
        else:
            moves = smoke_domain(obj) is not None
        if moves:
            yield (
                f"Object '{obj.name}': motion blur by the velocity of its voxels is not supported: they stand still in "
                "it; switch Motion Blur off to compare."
            )


# -- lights and the world ----------------------------------------------------------------------------------------------


def shadow_caustics(asked: Asked) -> Iterator[str]:
    """Shadow caustics (manifold next event estimation)."""
    lights = [
        obj.name for obj in asked.objects if obj.type == "LIGHT" and _cycles(obj.data, "is_caustics_light", False)
    ]
    if _cycles(asked.world, "is_caustics_light", False):
        lights.append(asked.world.name)
    if lights and any(_cycles(obj, "is_caustics_caster", False) for obj in asked.objects):
        yield (
            f"Scene '{asked.scene.name}': shadow caustics have no special method here: the caustics of "
            f"{_names(lights)} are noisier; give small lights a radius, and take more samples."
        )


def world_shadows(asked: Asked) -> Iterator[str]:
    """A world that casts no shadows."""
    world = asked.world
    if world is not None and not _cycles(world, "use_shadows", True):
        yield f"World '{world.name}': its light always casts shadows; switch its Cast Shadow on in Cycles to compare."


CHECKS: tuple[Callable[[Asked], Iterator[str]], ...] = (
    settings_of_cycles,
    passes,
    light_linking,
    subdivision,
    shadow_terminators,
    velocity_of_voxels,
    shadow_caustics,
    world_shadows,
)
