# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The Volume socket of materials and of the world.

Coefficients are numbers, or formulas where they vary in space. Phase functions are the same everywhere.
"""

from __future__ import annotations

import math
from dataclasses import replace

import bpy
import numpy as np

from ...graph.formula import Formula, Vector, call, clamp, formula_of, maximum, parameter, select, sqrt
from ...render.material import OBJECT_DENSITY, Attribute
from ...render.medium import BLACK, RGB, Medium, Scattering, Varying
from ...render.nodes.lookups import ATTRIBUTE, GRID
from ...render.nodes.means import mean_inside, varies
from ...render.nodes.spectra import blackbody_in
from ...render.nodes.variables import BARYCENTRIC, POSITION
from ...render.phases import fournier_forand_mean, limited, mie
from .common import Warnings
from .node_values import numbers_of, working_space
from .nodes import Reader, Stack, by_identifier

STEFAN_BOLTZMANN = 5.670373e-8 * 1e-6 / math.pi  # radiance, in the units of Cycles
# Since then Cycles takes the temperature of a voxel by chance: hot voxels glow as if their neighbours were not colder.
TEMPERATURE_BY_CHANCE = bpy.app.version >= (5, 0, 0)


def medium_of(
    reader: Reader, output: bpy.types.Node, owner: str, warn: Warnings, in_object_space: bool = False
) -> Medium | None:
    """The medium of an output node's Volume socket; None if it is empty. ``in_object_space``: its coefficients are
    those per metre of object space, so that a smaller object is as opaque."""
    weight = _object_density(reader.parameters) if in_object_space else 1.0
    read = _Volume(reader, owner, warn).read(output.inputs["Volume"], (), weight)
    found = _with_means(read, reader.parameters)
    endless = any(glow > 0.0 and not fading > 0.0 for glow, fading in zip(found.emission, found.extinction))
    if reader.domain == "WORLD" and endless:
        warn(
            f"{owner}: its volume glows without absorption, so its light would be infinite and is left out: give it "
            "some density."
        )
        found = _with_means(replace(read, emission=BLACK), reader.parameters)
    return None if found.does_nothing else found


def _object_density(parameters: list) -> Formula:
    parameters.append(OBJECT_DENSITY)
    return call(ATTRIBUTE, parameter(len(parameters) - 1), *BARYCENTRIC)[0]


def default_medium(in_object_space: bool) -> Medium:
    """That of a Volume object without a material: Cycles' Principled Volume with its defaults; see ``medium_of``."""
    parameters: list = [Attribute("grid", "density")]
    density = maximum(call(GRID["LINEAR"], parameter(0), *POSITION)[4], 0.0)
    if in_object_space:
        density = density * _object_density(parameters)
    half = (0.5 * density,) * 3
    return _with_means(Medium(half, (Scattering(half),)), parameters)


def _is_number(value: float | Formula) -> bool:
    return not isinstance(value, Formula)


def _with_means(medium: Medium, parameters: list) -> Medium:
    """A medium whose coefficients may be formulas, with numbers in their place, and with the formulas beside them."""
    colors = [medium.absorption, *(part.coefficient for part in medium.scattering), medium.emission]
    if all(map(_is_number, sum(colors, ()))):
        return medium
    absorption, *scattering, emission = (Vector(*map(formula_of, color)) for color in colors)
    varying = Varying(absorption, tuple(scattering), emission, parameters)
    means = mean_inside([channel for color in (absorption, *scattering, emission) for channel in color], parameters)
    absorption, *scattering, emission = (tuple(means[place : place + 3]) for place in range(0, len(means), 3))
    parts = tuple(replace(part, coefficient=mean) for part, mean in zip(medium.scattering, scattering))
    return Medium(absorption, parts, emission, varying)


class _Volume:
    """Reads the volume shaders of one output. A coefficient is a number, or a formula where it varies."""

    def __init__(self, reader: Reader, owner: str, warn: Warnings):
        self.reader, self._owner, self._warn = reader, owner, warn

    def read(self, socket, outer: Stack, weight: float | Formula) -> Medium:
        """Coefficients of the shader at a socket, times ``weight``."""
        node, end, stack = self.reader.resolve(socket, outer)
        if node is None or _is_number(weight) and not weight > 0.0:
            return Medium()
        if end.type != "SHADER":  # a value at a shader input is emitted, as on surfaces
            like = 0.0 if end.type == "VALUE" else BLACK
            value = self._number(self.reader.value(socket, outer)[0], like, node, end.name)
            color = value if isinstance(value, tuple) else (value,) * 3
            return Medium(emission=_scaled(_positive(color), weight))
        reading = SHADERS.get(node.bl_idname)
        if reading is None:
            self.reader.report(node, "not supported as a volume, so it is left out there")
            return Medium()
        return reading(_Sockets(self, node, stack), weight)

    def value(self, node, identifier: str, like, stack: Stack):
        """An input: numbers, or formulas if it varies."""
        return self._number(
            self.reader.read(by_identifier(node.inputs, identifier), like, stack), like, node, identifier
        )

    def uniform(self, node, identifier: str, stack: Stack) -> float:
        """A constant input, or the mean of a varying one."""
        value = self.reader.read(by_identifier(node.inputs, identifier), 0.0, stack)
        return self._number(value, 0.0, node, identifier, uniform=True)

    def _number(self, value, like, node, name: str, uniform: bool = False):
        """The node's value of this name, as a float or three, or as formulas unless it must be ``uniform``."""
        number = like if value is None else numbers_of(self.reader.parameters, value)
        if number is None:
            formulas = value if isinstance(value, Vector) else (value,)
            if not uniform and varies(formulas):
                return tuple(value) if isinstance(value, Vector) else value
            means = mean_inside(formulas, self.reader.parameters)
            number = tuple(means) if len(means) == 3 else means[0]
            if varies(formulas):
                self._warn(
                    f"{self._owner}: node '{node.name}': {name} of its phase function varies in space, which is not "
                    f"supported: its mean, {_text(number)}, is used everywhere; mix two nodes with constant values by "
                    "a factor that varies."
                )
        if not np.all(np.isfinite(number)):
            self.reader.report(node, f"{name} is not a finite number and is read as 0")
            return like
        return number


def _least(value: float | Formula, least: float) -> float | Formula:
    """A value, but at least so much."""
    return max(value, least) if _is_number(value) else maximum(value, least)


def _positive(color: RGB) -> RGB:
    return _least(color[0], 0.0), _least(color[1], 0.0), _least(color[2], 0.0)


def _text(number) -> str:
    return f"{number:.3g}" if isinstance(number, float) else "({:.3g}, {:.3g}, {:.3g})".format(*number)


class _Sockets:
    """Inputs of a volume shader: numbers, or formulas where they vary."""

    def __init__(self, volume: _Volume, node: bpy.types.Node, stack: Stack):
        self._volume, self.node, self._stack = volume, node, stack

    def number(self, identifier: str) -> float | Formula:
        return self._volume.value(self.node, identifier, 0.0, self._stack)

    def uniform(self, identifier: str) -> float:
        return self._volume.uniform(self.node, identifier, self._stack)

    def positive(self, identifier: str) -> float | Formula:
        return _least(self.number(identifier), 0.0)

    def color(self, identifier: str) -> RGB:
        """With negative parts set to zero."""
        return _positive(self._volume.value(self.node, identifier, BLACK, self._stack))

    def shader(self, identifier: str, weight: float | Formula) -> Medium:
        return self._volume.read(by_identifier(self.node.inputs, identifier), self._stack, weight)

    def grid(self, identifier: str, by_chance: bool = False) -> tuple[Formula, ...] | None:
        """The grid with the name that is the value of an input, as ``lookups.GRID``; None if there is none.
        ``by_chance``: one of the voxels that would be interpolated linearly."""
        reader, name = self._volume.reader, by_identifier(self.node.inputs, identifier).default_value
        if name not in reader.grids:
            return None
        way = "BY_CHANCE" if by_chance and reader.volume_interpolation == "LINEAR" else reader.volume_interpolation
        return call(GRID[way], reader.parametric(Attribute("grid", name)), *POSITION)

    def report(self, what: str) -> None:
        self._volume.reader.report(self.node, what)


def _scaled(color: RGB, factor: float | Formula) -> RGB:
    return color[0] * factor, color[1] * factor, color[2] * factor


def _total(a: RGB, b: RGB) -> RGB:
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


def _scattering(inputs: _Sockets, coefficient: RGB) -> tuple[Scattering, ...]:
    """Scattering with the phase function of a node."""
    if not any(not _is_number(channel) or channel for channel in coefficient):
        return ()
    phase = getattr(inputs.node, "phase", "HENYEY_GREENSTEIN")
    if phase == "RAYLEIGH":
        return (Scattering(coefficient, 0.0, 1.0),)
    if phase == "MIE":
        return tuple(
            Scattering(_scaled(coefficient, share), g, alpha)
            for share, g, alpha in mie(inputs.uniform("Diameter"))
            if share > 0.0
        )
    if phase == "FOURNIER_FORAND":
        g = fournier_forand_mean(inputs.uniform("IOR"), inputs.uniform("Backscatter"))
        inputs.report(
            "the Fournier-Forand phase function is not supported, so it is Henyey-Greenstein with the same mean, an "
            f"anisotropy of {g:.2f}"
        )
        return (Scattering(coefficient, g),)
    alpha = max(inputs.uniform("Alpha"), 0.0) if phase == "DRAINE" else 0.0
    return (Scattering(coefficient, limited(inputs.uniform("Anisotropy")), alpha),)


def _absorption(inputs: _Sockets, weight: float | Formula) -> Medium:
    red, green, blue = inputs.color("Color")
    color = _positive((1.0 - red, 1.0 - green, 1.0 - blue))
    return Medium(_scaled(color, weight * inputs.positive("Density")))


def _scatter(inputs: _Sockets, weight: float | Formula) -> Medium:
    coefficient = _scaled(inputs.color("Color"), weight * inputs.positive("Density"))
    return Medium(scattering=_scattering(inputs, coefficient))


def _coefficients(inputs: _Sockets, weight: float | Formula) -> Medium:
    absorption, scatter, emission = (
        _scaled(inputs.color(f"{name} Coefficients"), weight) for name in ("Absorption", "Scatter", "Emission")
    )
    return Medium(absorption, _scattering(inputs, scatter), emission)


def _principled(inputs: _Sockets, weight: float | Formula) -> Medium:
    density = weight * inputs.positive("Density")
    color, tint = inputs.color("Color"), inputs.color("Absorption Color")
    grid = inputs.grid("Density Attribute")
    if grid is not None:
        density = density * maximum(grid[4], 0.0)
    grid = inputs.grid("Color Attribute")
    if grid is not None:
        color = _positive((color[0] * grid[0], color[1] * grid[1], color[2] * grid[2]))
    roots = (math.sqrt(channel) if _is_number(channel) else sqrt(channel) for channel in tint)
    absorption = tuple(density * _least(1.0 - c, 0.0) * _least(1.0 - root, 0.0) for c, root in zip(color, roots))
    emission = _scaled(inputs.color("Emission Color"), weight * inputs.positive("Emission Strength"))
    share = inputs.number("Blackbody Intensity")
    if not _is_number(share) or share > 0.0:
        temperature, grid = inputs.positive("Temperature"), inputs.grid("Temperature Attribute", TEMPERATURE_BY_CHANCE)
        if grid is not None:
            temperature = temperature * maximum(grid[4], 0.0)
        squared = temperature * temperature
        intensity = weight * STEFAN_BOLTZMANN * (1.0 + share * (squared * squared - 1.0))
        if not _is_number(share):
            intensity = select(share <= 0.0, 0.0, intensity)
        # Negative out of gamut, as in Cycles' volumes.
        glow = blackbody_in(working_space(), formula_of(temperature))
        if _is_number(temperature):
            glow = tuple(channel.value for channel in glow)
        emission = _total(
            emission, tuple(intensity * tint * channel for tint, channel in zip(inputs.color("Blackbody Tint"), glow))
        )
    return Medium(absorption, _scattering(inputs, _scaled(color, density)), emission)


def _emission(inputs: _Sockets, weight: float | Formula) -> Medium:
    return Medium(emission=_scaled(inputs.color("Color"), weight * inputs.positive("Strength")))


def _sum(a: Medium, b: Medium) -> Medium:
    parts: dict[tuple[float, float], RGB] = {}
    for part in a.scattering + b.scattering:
        key = part.g, part.alpha
        parts[key] = _total(parts.get(key, BLACK), part.coefficient)
    scattering = tuple(Scattering(coefficient, *key) for key, coefficient in parts.items())
    return Medium(_total(a.absorption, b.absorption), scattering, _total(a.emission, b.emission))


def _add(inputs: _Sockets, weight: float | Formula) -> Medium:
    return _sum(inputs.shader("Shader", weight), inputs.shader("Shader_001", weight))


def _mix(inputs: _Sockets, weight: float | Formula) -> Medium:
    factor = inputs.number("Fac")
    factor = min(max(factor, 0.0), 1.0) if _is_number(factor) else clamp(factor, 0.0, 1.0)
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
