# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Media of a scene as tables."""

from __future__ import annotations

import numpy as np

from ....graph.formula import CONSTANT
from ...material import WHITE, Material
from ...medium import BLACK, Medium
from ...scene import Camera, Scene
from .records import BOUNDS, CELL, GRID, MEDIUM, NOTHING, PART


def pack_media(scene: Scene) -> tuple[dict[str, np.ndarray], dict[str, int]]:
    """Tables and scalars; ``camera_scalars`` sets ``camera_in_media``, and ``grids.fill_grids`` the grids of media that
    vary."""
    rows: list = []
    parts: list = []

    def add(medium: Medium | None, volume: int) -> int:
        """Add a medium, whose formulas are this row of "volumes"."""
        if medium is None or medium.does_nothing:
            return NOTHING
        first, varies = len(parts), medium.varying is not None
        parts.extend(
            (np.mean(part.coefficient), part.g, part.alpha)
            for part in medium.scattering
            if varies or any(part.coefficient)
        )
        scattering = np.sum([(0.0, 0.0, 0.0), *(part.coefficient for part in medium.scattering)], axis=0)
        numbers = (BLACK,) * 3 if varies else (medium.extinction, scattering, medium.emission)
        rows.append((*numbers, first, len(parts) - first, volume if varies else NOTHING))
        return len(rows) - 1

    bounds = np.zeros(max(len(scene.materials), 1), BOUNDS)
    bounds["medium"] = NOTHING
    for index, (record, material) in enumerate(zip(bounds, scene.materials)):
        record["medium"], record["only"] = add(material.medium, 1 + index), is_only_a_bound(material)
    world = add(scene.world.medium, 0)
    used = {material for instance in scene.instances for material in instance.materials}
    bounded = any(bounds["medium"][material] != NOTHING for material in used)
    return {
        "media": np.array(rows, MEDIUM) if rows else np.zeros(0, MEDIUM),
        "media_parts": np.array(parts, PART) if parts else np.zeros(0, PART),
        "media_bounds": bounds,
        "media_grids": np.zeros(0, GRID),
        "media_first_grid": np.zeros(0, np.int64),
        "media_cells": np.zeros(0, CELL),
    }, {"has_media": world != NOTHING or bounded, "world_medium": world}


def is_only_a_bound(material: Material) -> bool:
    """Whether a surface of the material only bounds a medium."""
    surface = material.surface
    return (
        material.medium is not None
        and surface is not None
        and surface.kind == "transparent"
        and isinstance(surface["color"], tuple)
        and tuple(surface["color"]) == WHITE
    )


def glows(scene: Scene) -> bool:
    """Whether rays can hit emission of media."""
    media = [scene.world.medium, *(material.medium for material in scene.materials)]
    return any(medium is not None and _glows(medium) for medium in media)


def _glows(medium: Medium) -> bool:
    if medium.varying is None:
        return any(medium.emission)
    return any(channel.kind != CONSTANT or channel.value != 0.0 for channel in medium.varying.emission)


def camera_scalars(
    camera: Camera, bounds: np.ndarray, scene: Scene, center: np.ndarray, half: np.ndarray
) -> dict[str, int]:
    """Whether rays may start inside a mesh with a medium. ``center``, ``half``: (instances, 3) boxes around them.

    For cameras whose rays do not start close to one point, all may.
    """
    if not bounds["medium"].max(initial=NOTHING) > NOTHING:
        return {"camera_in_media": False}
    if camera.projection != 0:
        return {"camera_in_media": True}
    room = camera.aperture + np.hypot(camera.clip[0], camera.clip[0] * np.abs(camera.window).max() * 1.5)
    used = [instance for instance in scene.instances if len(scene.meshes[instance.mesh].positions)]
    holds = np.array(
        [any(bounds["medium"][material] != NOTHING for material in instance.materials) for instance in used], bool
    )
    near = (np.abs(np.asarray(camera.matrix)[:3, 3] - center) <= half + room).all(axis=1)
    return {"camera_in_media": bool((holds & near).any())}
