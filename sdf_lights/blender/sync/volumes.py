# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The Volume socket of materials and of the world: a medium that is the same everywhere."""

from __future__ import annotations

import math
from dataclasses import replace

import bpy
import numpy as np

from ...graph.formula import Vector, constant
from ...render.medium import BLACK, RGB, Medium, Scattering
from ...render.nodes.means import mean_inside, varies
from ...render.nodes.spectra import blackbody_in
from ...render.phases import fournier_forand_mean, limited, mie
from .common import Warnings
from .node_values import numbers_of, working_space
from .nodes import Reader, Stack, by_identifier

STEFAN_BOLTZMANN = 5.670373e-8 * 1e-6 / math.pi  # radiance, in the units of Cycles


def medium_of(reader: Reader, output: bpy.types.Node, owner: str, warn: Warnings) -> Medium | None:
    """The medium of an output node's Volume socket; None if it is empty."""
    found = _Volume(reader, owner, warn).read(output.inputs["Volume"], (), 1.0)
    endless = any(glow > 0.0 and not fading > 0.0 for glow, fading in zip(found.emission, found.extinction))
    if reader.domain == "WORLD" and endless:
        warn(
            f"{owner}: its volume glows without absorption, so its light would be infinite and is left out: give it "
            "some density."
        )
        found = replace(found, emission=BLACK)
    return None if found.does_nothing else found


class _Volume:
    """Reads the volume shaders of one output."""

    def __init__(self, reader: Reader, owner: str, warn: Warnings):
        self.reader, self._owner, self._warn = reader, owner, warn

    def read(self, socket, outer: Stack, weight: float) -> Medium:
        """Coefficients of the shader at a socket, times ``weight``."""
        node, end, stack = self.reader.resolve(socket, outer)
        if node is None or not weight > 0.0:
            return Medium()
        if end.type != "SHADER":  # a value at a shader input is emitted, as on surfaces
            like = 0.0 if end.type == "VALUE" else BLACK
            value = self._number(self.reader.value(socket, outer)[0], like, node, end.name)
            color = (value,) * 3 if isinstance(value, float) else value
            return Medium(emission=_scaled(_positive(color), weight))
        reading = SHADERS.get(node.bl_idname)
        if reading is None:
            self.reader.report(node, "not supported as a volume, so it is left out there")
            return Medium()
        return reading(_Sockets(self, node, stack), weight)

    def value(self, node, identifier: str, like, stack: Stack):
        """A constant input, or the mean of a varying one."""
        return self._number(
            self.reader.read(by_identifier(node.inputs, identifier), like, stack), like, node, identifier
        )

    def _number(self, value, like, node, name: str):
        """The node's value of this name, as a float or three."""
        number = like if value is None else numbers_of(self.reader.parameters, value)
        if number is None:
            formulas = value if isinstance(value, Vector) else (value,)
            means = mean_inside(formulas, self.reader.parameters)
            number = tuple(means) if len(means) == 3 else means[0]
            if varies(formulas):
                self._warn(
                    f"{self._owner}: node '{node.name}': {name} varies in space, which is not supported in volumes: "
                    f"its mean, {_text(number)}, is used everywhere."
                )
        if not np.all(np.isfinite(number)):
            self.reader.report(node, f"{name} is not a finite number and is read as 0")
            return like
        return number


def _positive(color: RGB) -> RGB:
    return max(color[0], 0.0), max(color[1], 0.0), max(color[2], 0.0)


def _text(number) -> str:
    return f"{number:.3g}" if isinstance(number, float) else "({:.3g}, {:.3g}, {:.3g})".format(*number)


class _Sockets:
    """Inputs of a volume shader, as numbers."""

    def __init__(self, volume: _Volume, node: bpy.types.Node, stack: Stack):
        self._volume, self.node, self._stack = volume, node, stack

    def number(self, identifier: str) -> float:
        return self._volume.value(self.node, identifier, 0.0, self._stack)

    def positive(self, identifier: str) -> float:
        return max(self.number(identifier), 0.0)

    def color(self, identifier: str) -> RGB:
        """With negative parts set to zero."""
        return _positive(self._volume.value(self.node, identifier, BLACK, self._stack))

    def shader(self, identifier: str, weight: float) -> Medium:
        return self._volume.read(by_identifier(self.node.inputs, identifier), self._stack, weight)

    def report(self, what: str) -> None:
        self._volume.reader.report(self.node, what)


def _scaled(color: RGB, factor: float) -> RGB:
    return color[0] * factor, color[1] * factor, color[2] * factor


def _total(a: RGB, b: RGB) -> RGB:
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


def _scattering(inputs: _Sockets, coefficient: RGB) -> tuple[Scattering, ...]:
    """Scattering with the phase function of a node."""
    if not any(coefficient):
        return ()
    phase = getattr(inputs.node, "phase", "HENYEY_GREENSTEIN")
    if phase == "RAYLEIGH":
        return (Scattering(coefficient, 0.0, 1.0),)
    if phase == "MIE":
        return tuple(
            Scattering(_scaled(coefficient, share), g, alpha)
            for share, g, alpha in mie(inputs.number("Diameter"))
            if share > 0.0
        )
    if phase == "FOURNIER_FORAND":
        g = fournier_forand_mean(inputs.number("IOR"), inputs.number("Backscatter"))
        inputs.report(
            "the Fournier-Forand phase function is not supported, so it is Henyey-Greenstein with the same mean, an "
            f"anisotropy of {g:.2f}"
        )
        return (Scattering(coefficient, g),)
    alpha = inputs.positive("Alpha") if phase == "DRAINE" else 0.0
    return (Scattering(coefficient, limited(inputs.number("Anisotropy")), alpha),)


def _absorption(inputs: _Sockets, weight: float) -> Medium:
    red, green, blue = inputs.color("Color")
    color = max(1.0 - red, 0.0), max(1.0 - green, 0.0), max(1.0 - blue, 0.0)
    return Medium(_scaled(color, weight * inputs.positive("Density")))


def _scatter(inputs: _Sockets, weight: float) -> Medium:
    coefficient = _scaled(inputs.color("Color"), weight * inputs.positive("Density"))
    return Medium(scattering=_scattering(inputs, coefficient))


def _coefficients(inputs: _Sockets, weight: float) -> Medium:
    absorption, scatter, emission = (
        _scaled(inputs.color(f"{name} Coefficients"), weight) for name in ("Absorption", "Scatter", "Emission")
    )
    return Medium(absorption, _scattering(inputs, scatter), emission)


def _principled(inputs: _Sockets, weight: float) -> Medium:
    density = weight * inputs.positive("Density")
    color, tint = inputs.color("Color"), inputs.color("Absorption Color")
    absorption = tuple(density * max(1.0 - c, 0.0) * max(1.0 - math.sqrt(t), 0.0) for c, t in zip(color, tint))
    emission = _scaled(inputs.color("Emission Color"), weight * inputs.positive("Emission Strength"))
    share = inputs.number("Blackbody Intensity")
    if share > 0.0:
        temperature = inputs.positive("Temperature")
        intensity = weight * STEFAN_BOLTZMANN * (1.0 + share * (temperature**4 - 1.0))
        glow = blackbody_in(working_space(), constant(temperature))  # negative out of gamut, as in Cycles' volumes
        emission = _total(
            emission,
            tuple(intensity * tint * channel.value for tint, channel in zip(inputs.color("Blackbody Tint"), glow)),
        )
    return Medium(absorption, _scattering(inputs, _scaled(color, density)), emission)


def _emission(inputs: _Sockets, weight: float) -> Medium:
    return Medium(emission=_scaled(inputs.color("Color"), weight * inputs.positive("Strength")))


def _sum(a: Medium, b: Medium) -> Medium:
    parts: dict[tuple[float, float], RGB] = {}
    for part in a.scattering + b.scattering:
        key = part.g, part.alpha
        parts[key] = _total(parts.get(key, BLACK), part.coefficient)
    scattering = tuple(Scattering(coefficient, *key) for key, coefficient in parts.items())
    return Medium(_total(a.absorption, b.absorption), scattering, _total(a.emission, b.emission))


def _add(inputs: _Sockets, weight: float) -> Medium:
    return _sum(inputs.shader("Shader", weight), inputs.shader("Shader_001", weight))


def _mix(inputs: _Sockets, weight: float) -> Medium:
    factor = min(max(inputs.number("Fac"), 0.0), 1.0)
    return _sum(inputs.shader("Shader", weight * (1.0 - factor)), inputs.shader("Shader_001", weight * factor))


SHADERS = {
    "ShaderNodeVolumePrincipled": _principled,
    "ShaderNodeVolumeScatter": _scatter,
    "ShaderNodeVolumeAbsorption": _absorption,
    "ShaderNodeVolumeCoefficients": _coefficients,
    "ShaderNodeEmission": _emission,
    "ShaderNodeAddShader": _add,
    "ShaderNodeMixShader": _mix,
}
