# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A short notation for material graphs: one line per node, with the names that artists use."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import bpy
from scenery.materials import Graph


@dataclass(frozen=True)
class Entry:
    """``build(shader)`` returns the socket for the Surface, or (Surface, Volume, Displacement), each of them or None;
    ``shape`` names the object of ``stage`` with the material."""

    build: Callable
    shape: str


MATERIALS: dict[str, Entry] = {}


def material(shape: str = "ball"):
    """Register a function under its own name."""

    def note(build):
        MATERIALS[build.__name__] = Entry(build, shape)
        return build

    return note


class Shader(Graph):
    """A material's graph. Every method returns the output of a new node; inputs are sockets or constants."""

    # -- coordinates

    def coordinates(self, output: str = "Object", scale=None, rotation=None, location=None):
        """Texture coordinates, through a Mapping if they are scaled, rotated or moved."""
        vector = self.node("ShaderNodeTexCoord", output)
        return self.mapped(vector, scale, rotation, location)

    def mapped(self, vector, scale=None, rotation=None, location=None):
        given = dict(Scale=scale, Rotation=rotation, Location=location)
        given = {
            name: (value,) * 3 if isinstance(value, float) else value
            for name, value in given.items()
            if value is not None
        }
        return self.node("ShaderNodeMapping", Vector=vector, **given) if given else vector

    def geometry(self, output: str):
        return self.node("ShaderNodeNewGeometry", output)

    def facing(self, blend: float = 0.5):
        return self.node("ShaderNodeLayerWeight", "Facing", Blend=blend)

    def fresnel(self, ior: float = 1.45, **inputs):
        return self.node("ShaderNodeFresnel", IOR=ior, **inputs)

    # -- textures

    def noise(self, vector, scale: float, detail: float = 2.0, roughness: float = 0.5, output: str = "Fac", **more):
        return self.node(
            "ShaderNodeTexNoise", output, Vector=vector, Scale=scale, Detail=detail, Roughness=roughness, **more
        )

    def voronoi(self, vector, scale: float, output: str = "Distance", **more):
        return self.node("ShaderNodeTexVoronoi", output, Vector=vector, Scale=scale, **more)

    def wave(self, vector, scale: float, distortion: float = 0.0, **more):
        return self.node("ShaderNodeTexWave", "Fac", Vector=vector, Scale=scale, Distortion=distortion, **more)

    def random(self, vector, output: str = "Value"):
        return self.node("ShaderNodeTexWhiteNoise", output, Vector=vector)

    # -- numbers, vectors, colours

    def math(self, operation: str, a, b=None, c=None, clamp: bool = False):
        given = {f"_{place}": value for place, value in enumerate((a, b, c)) if value is not None}
        return self.node("ShaderNodeMath", operation=operation, use_clamp=clamp, **given)

    def vector_math(self, operation: str, a, b=None, **more):
        given = {f"_{place}": value for place, value in enumerate((a, b)) if value is not None}
        return self.node("ShaderNodeVectorMath", operation=operation, **given, **more)

    def map_range(
        self, value, low: float, high: float, to_low: float = 0.0, to_high: float = 1.0, smooth: bool = False
    ):
        return self.node(
            "ShaderNodeMapRange",
            Value=value,
            From_Min=low,
            From_Max=high,
            To_Min=to_low,
            To_Max=to_high,
            interpolation_type="SMOOTHSTEP" if smooth else "LINEAR",
        )

    def axis(self, vector, name: str):
        return self.node("ShaderNodeSeparateXYZ", name, Vector=vector)

    def ramp(self, factor, *stops, interpolation: str = "LINEAR"):
        """A colour ramp through (position, colour or grey) stops."""
        socket = self.node("ShaderNodeValToRGB", Fac=factor)
        ramp = socket.node.color_ramp
        ramp.interpolation = interpolation
        while len(ramp.elements) > 1:
            ramp.elements.remove(ramp.elements[-1])
        for index, (position, shade) in enumerate(stops):
            element = ramp.elements[0] if index == 0 else ramp.elements.new(position)
            element.position = position
            element.color = (*((shade,) * 3 if isinstance(shade, float) else shade), 1.0)
        return socket

    def mix(self, factor, a, b, blend: str = "MIX"):
        """Two colours."""
        return self.node("ShaderNodeMix", data_type="RGBA", blend_type=blend, Factor=factor, A=_color(a), B=_color(b))

    def mix_numbers(self, factor, a, b):
        return self.node("ShaderNodeMix", data_type="FLOAT", Factor=factor, A=a, B=b)

    def hue(self, color, hue=0.5, saturation=1.0, value=1.0):
        return self.node("ShaderNodeHueSaturation", Color=color, Hue=hue, Saturation=saturation, Value=value)

    # -- surfaces

    def bump(self, height, distance: float, strength: float = 1.0, normal=None):
        more = {} if normal is None else dict(Normal=normal)
        return self.node("ShaderNodeBump", Height=height, Distance=distance, Strength=strength, **more)

    def principled(self, color, roughness, **inputs):
        return self.node("ShaderNodeBsdfPrincipled", Base_Color=_color(color), Roughness=roughness, **inputs)

    def emission(self, color, strength):
        return self.node("ShaderNodeEmission", Color=_color(color), Strength=strength)

    def mix_shaders(self, factor, a, b):
        return self.node("ShaderNodeMixShader", _0=factor, _1=a, _2=b)

    def add_shaders(self, a, b):
        return self.node("ShaderNodeAddShader", _0=a, _1=b)


def _color(value):
    return value if isinstance(value, bpy.types.NodeSocket) or len(value) == 4 else (*value, 1.0)
