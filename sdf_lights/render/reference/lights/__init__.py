# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's lights, the world and emissive triangles over arrays of points. Modules of lights are found automatically.

``EMITTERS`` of a module maps a light of ``render.lights`` to its class.
"""

from __future__ import annotations

import importlib
import pkgutil

from ...scene import Light, Scene
from ..emission_nodes import Emission
from .emitter import Emitter
from .triangles import Triangles
from .world import Sky

__all__ = ["Emitter", "Sky", "Triangles", "blender_light"]

_EMITTERS = {
    light: emitter
    for item in pkgutil.iter_modules(__path__)
    for light, emitter in getattr(importlib.import_module(f".{item.name}", __name__), "EMITTERS", {}).items()
}


def blender_light(light: Light, scene: Scene | None = None) -> Emitter:
    """The emitter of a light; its nodes may look up data in its ``scene``."""
    emitter = _EMITTERS[type(light)](light)
    if light.emission is not None:
        emitter.nodes = Emission(light.emission, scene)
    return emitter
