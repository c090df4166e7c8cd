# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Material graphs compiled to tables: instructions that compute values, and a flat list of lobes with weights.

An *operand* is the index of a register if it is not negative, of a constant (``~operand``) if it is; ``NONE`` stands
for an input that has no value. A vector or colour takes three places. Constants cost no instruction; of a graph,
only what some lobe with a weight needs is compiled. Mix and Add Shader only leave weights: each closure node gets the
sum over all ways in which it is reached.
"""

from __future__ import annotations

import math

import numpy as np

from ....vec import ZERO
from ...material import NODES, Material, Node
from ..textures import EXTENSIONS, INTERPOLATIONS, pack_images
from .records import (
    CLOSURES, HAS_EMISSION, HAS_SURFACE, HAS_TRANSPARENCY, NEEDS_DERIVATIVES, NEEDS_OBJECT, NEEDS_TANGENT, NEEDS_UV,
    REGISTERS, UV_LAYERS)

NONE = -(1 << 31)

# Instructions, with their arguments (operands unless said). A suffix of `out` tells its width.
(
    OP_UV,  # layer (int), shift (int: 0, or the barycentric coordinate by which to shift) -> 3
    OP_MATRIX,  # vector, matrix (operand of 12 constants), normalise (int) -> 3
    OP_MAPPING,  # vector, location, rotation, scale, type (int) -> 3
    OP_IMAGE,  # vector, image (int), interpolation (int), extension (int), projection (int), associated (int) -> 4
    OP_NORMAL_MAP,  # colour, strength, layer (int), space (int) -> 3
    OP_BUMP,  # height, height shifted by u, by v, strength, distance, normal, invert (int) -> 3
    OP_BROADCAST,  # number -> 3
    OP_LUMINANCE,  # colour -> 1
    OP_AVERAGE,  # vector -> 1
    OP_MULTIPLY,  # number, number -> 1
    OP_ADD,  # number, number -> 1
    OP_CLAMP,  # number -> 1
    OP_COMPLEMENT,  # number -> 1; one minus the number clamped
) = range(13)

# Lobes, with their arguments (operands).
(
    LOBE_DIFFUSE,  # color, roughness, normal
    LOBE_GLOSSY,  # color, roughness, normal
    LOBE_GLASS,  # color, roughness, ior, normal
    LOBE_REFRACTION,  # color, roughness, ior, normal
    LOBE_TRANSLUCENT,  # color, normal
    LOBE_TRANSPARENT,  # color
    LOBE_EMISSION,  # color, strength
    LOBE_HOLDOUT,
    LOBE_PRINCIPLED,  # PRINCIPLED, in that order
    LOBE_ALPHA,  # alpha: transparent as far as it is below 1; in lists for shadow rays only
) = range(10)

PRINCIPLED = (
    "base_color", "metallic", "roughness", "ior", "alpha", "normal", "diffuse_roughness", "specular_ior_level",
    "specular_tint", "transmission_weight", "coat_weight", "coat_roughness", "coat_ior", "coat_tint", "coat_normal",
    "sheen_weight", "sheen_roughness", "sheen_tint", "emission_color", "emission_strength")
(
    BASE_COLOR, METALLIC, ROUGHNESS, IOR, ALPHA, NORMAL, DIFFUSE_ROUGHNESS, SPECULAR_IOR_LEVEL, SPECULAR_TINT,
    TRANSMISSION_WEIGHT, COAT_WEIGHT, COAT_ROUGHNESS, COAT_IOR, COAT_TINT, COAT_NORMAL, SHEEN_WEIGHT, SHEEN_ROUGHNESS,
    SHEEN_TINT, EMISSION_COLOR, EMISSION_STRENGTH,
) = range(len(PRINCIPLED))

# Features of a lobe: the parts of Principled that can be other than absent, and energy compensation of GGX.
WITH_ALPHA, WITH_SHEEN, WITH_COAT, WITH_EMISSION, WITH_METAL, WITH_TRANSMISSION, WITH_BASE, MULTISCATTER = (
    1 << bit for bit in range(8))

FLAT, SPHERE, TUBE = range(3)
TANGENT, OBJECT, WORLD = range(3)
POINT, TEXTURE, VECTOR, NORMAL_VECTOR = range(4)
_PROJECTIONS = {"FLAT": FLAT, "SPHERE": SPHERE, "TUBE": TUBE}
_SPACES = {"TANGENT": TANGENT, "OBJECT": OBJECT, "WORLD": WORLD}
_MAPPINGS = {"POINT": POINT, "TEXTURE": TEXTURE, "VECTOR": VECTOR, "NORMAL": NORMAL_VECTOR}

_READ_BY = (
    (("metallic",), WITH_METAL), (("transmission_weight",), WITH_TRANSMISSION), (("alpha",), WITH_ALPHA),
    (("diffuse_roughness", "specular_ior_level"), WITH_BASE), (("ior",), WITH_TRANSMISSION | WITH_BASE))

INSTRUCTION = np.dtype([("op", "i4"), ("out", "i4"), ("args", "i4", 7)], align=True)
LOBE = np.dtype([("kind", "i4"), ("features", "i4"), ("weight", "i4"), ("args", "i4", len(PRINCIPLED))], align=True)
MATERIAL = np.dtype([
    ("flags", "i4"),
    ("sample_emission", "i4"),
    ("emission", "f8", 3),  # estimate of emitted radiance, for the importance of emissive meshes
    ("instructions", "i4", 2),  # first and end of the range
    ("lobes", "i4", 2),
    ("shadow_instructions", "i4", 2),  # what transparency() alone needs
    ("shadow_lobes", "i4", 2),
], align=True)

TABLES = {"materials": MATERIAL, "instructions": INSTRUCTION, "lobes": LOBE, "constants": np.dtype("f8")}

_CLOSURES = {
    "diffuse", "glossy", "glass", "refraction", "transparent", "translucent", "emission", "holdout", "principled",
    "mix_closure", "add_closure"}
_SIMPLE = {
    "diffuse": (LOBE_DIFFUSE, ("color", "roughness", "normal")),
    "glossy": (LOBE_GLOSSY, ("color", "roughness", "normal")),
    "glass": (LOBE_GLASS, ("color", "roughness", "ior", "normal")),
    "refraction": (LOBE_REFRACTION, ("color", "roughness", "ior", "normal")),
    "translucent": (LOBE_TRANSLUCENT, ("color", "normal")),
    "transparent": (LOBE_TRANSPARENT, ("color",)),
    "emission": (LOBE_EMISSION, ("color", "strength")),
    "holdout": (LOBE_HOLDOUT, ()),
    "principled": (LOBE_PRINCIPLED, PRINCIPLED),
}


class _TooComplex(Exception):
    pass


def uv_layers(scene) -> list[str]:
    """Names of the UV maps that the materials of ``scene`` read, the active one ("") first; at most ``UV_LAYERS``."""
    names = {""}
    for material in scene.materials:
        pending, seen = [material.surface], set()
        while pending:
            node = pending.pop()
            if isinstance(node, Node) and id(node) not in seen:
                seen.add(id(node))
                pending.extend(node.inputs.values())
                if node.kind in ("uv", "normal_map"):
                    names.add(str(node.settings.get("uv_map") or ""))
    return sorted(names)[:UV_LAYERS]


def pack_materials(scene) -> dict[str, np.ndarray]:
    """Tables of the materials and images of ``scene``; what could not be compiled is told in ``scene.warnings``.

    There is always at least one material, so that geometry without any has index 0 to point at.
    """
    compiler = _SceneCompiler(scene)
    materials = scene.materials or [Material("Default", Node("diffuse"))]
    records = np.zeros(len(materials), MATERIAL)
    for record, material in zip(records, materials):
        compiler.compile(material, record)
    return {
        "materials": records,
        "instructions": np.array(compiler.instructions or [(0, 0, (0,) * 7)], INSTRUCTION),
        "lobes": np.array(compiler.lobes or [(0, 0, 0, (0,) * len(PRINCIPLED))], LOBE),
        "constants": np.array(compiler.constants, dtype=np.float64),
        **pack_images(scene),
    }


class _SceneCompiler:
    """What the materials of one scene share: constants, instructions, lobes, UV layers and images."""

    def __init__(self, scene):
        self.scene = scene
        self.layers = {name: index for index, name in enumerate(uv_layers(scene))}
        self.constants = [0.0, 0.0, 0.0]
        self.places = {}
        self.instructions: list[tuple] = []
        self.lobes: list[tuple] = []
        self.means: dict[int, tuple] = {}

    def warn(self, text: str) -> None:
        if text not in self.scene.warnings:
            self.scene.warnings.append(text)

    def constant(self, *values: float) -> int:
        """Operand of consecutive constants."""
        if values not in self.places:
            self.places[values] = ~len(self.constants)
            self.constants.extend(values)
        return self.places[values]

    def image_mean(self, index: int | None) -> tuple[float, float, float]:
        if index not in self.means:
            pixels = self.scene.images[index].pixels if _is_index(index, self.scene.images) else np.zeros(0)
            known = pixels.ndim == 3 and pixels.shape[2] == 4 and pixels.size
            self.means[index] = tuple(map(float, pixels[..., :3].mean((0, 1)))) if known else (1.0, 0.0, 1.0)
        return self.means[index]

    def compile(self, material: Material, record) -> None:
        start = len(self.instructions), len(self.lobes)
        record["sample_emission"] = material.sample_emission
        try:
            self._compile(material, record)
        except (_TooComplex, RecursionError):
            del self.instructions[start[0]:], self.lobes[start[1]:]
            self.warn(f"Material {material.name!r} has too many nodes to be compiled and is shown grey; simplify it.")
            self._compile(Material(material.name, Node("diffuse")), record)

    def _compile(self, material: Material, record) -> None:
        emission, flags = np.zeros(3), 0
        for shadow in (False, True):
            program = _Program(self, material.name, shadow)
            program.compile(material.surface)
            prefix = "shadow_" if shadow else ""
            record[prefix + "instructions"] = len(self.instructions), len(self.instructions) + len(program.instructions)
            record[prefix + "lobes"] = len(self.lobes), len(self.lobes) + len(program.lobes)
            self.instructions += program.instructions
            self.lobes += program.lobes
            flags |= program.flags
            emission = np.maximum(emission, program.emission)
        record["flags"], record["emission"] = flags, emission


class _Program:
    """One list of instructions and lobes of a material: all of them, or those that transparency needs (``shadow``)."""

    def __init__(self, scene: _SceneCompiler, name: str, shadow: bool):
        self.scene, self.name, self.shadow = scene, name, shadow
        self.instructions: list[tuple] = []
        self.lobes: list[tuple] = []
        self.registers = 0
        self.flags = 0
        self.emission = np.zeros(3)
        self.values: dict[tuple, tuple[int, str]] = {}
        self.emitted: dict[tuple, int] = {}
        self.emitters: dict[int, Node] = {}

    # Closures

    def compile(self, surface) -> None:
        surface = self._closure(surface)
        if surface is None:
            return
        weights = {id(surface): 1.0}
        for node in self._topological(surface):
            weight = weights[id(node)]
            if weight == 0.0:
                continue
            if node.kind == "add_closure":
                shares = (("a", weight), ("b", weight))
            elif node.kind == "mix_closure":
                shares = self._mix(node, weight)
            else:
                self._lobe(node, weight)
                continue
            for name, share in shares:
                child = self._closure(node[name])
                if child is not None:
                    weights[id(child)] = self._sum(weights.get(id(child), 0.0), share)

    def _closure(self, value) -> Node | None:
        """The closure node that a closure input means: a value is emitted, as in Blender."""
        if not isinstance(value, Node) or value.kind in _CLOSURES:
            return value
        if id(value) not in self.emitters:
            self.emitters[id(value)] = Node("emission", {"color": value})
        return self.emitters[id(value)]

    def _topological(self, root: Node) -> list[Node]:
        """Closure nodes reached from ``root``, each before those it leads to."""
        order, seen, stack = [], set(), [(root, False)]
        while stack:
            node, done = stack.pop()
            if done:
                order.append(node)
            elif id(node) not in seen:
                seen.add(id(node))
                stack.append((node, True))
                if node.kind in ("mix_closure", "add_closure"):
                    children = map(self._closure, (node["a"], node["b"]))
                    stack += [(child, False) for child in children if child is not None]
        return order[::-1]

    def _mix(self, node: Node, weight):
        factor = self._constant(node, "factor")
        if factor is not None:
            factor = min(max(factor, 0.0), 1.0)
            return ("a", self._product(weight, 1.0 - factor)), ("b", self._product(weight, factor))
        operand = self.number(node, "factor")
        shares = {"a": OP_COMPLEMENT, "b": OP_CLAMP}
        return [
            (name, self._product(weight, _Weight(self._emit(op, (operand,), 1)))) for name, op in shares.items()]

    def _product(self, a, b):
        if not isinstance(a, _Weight) and not isinstance(b, _Weight):
            return a * b
        if 0.0 in (a, b):
            return 0.0
        if 1.0 in (a, b):
            return b if a == 1.0 else a
        return _Weight(self._emit(OP_MULTIPLY, (self._weight(a), self._weight(b)), 1))

    def _sum(self, a, b):
        if not isinstance(a, _Weight) and not isinstance(b, _Weight):
            return a + b
        if 0.0 in (a, b):
            return b if a == 0.0 else a
        return _Weight(self._emit(OP_ADD, (self._weight(a), self._weight(b)), 1))

    def _weight(self, weight) -> int:
        return weight.operand if isinstance(weight, _Weight) else self.scene.constant(float(weight))

    def _lobe(self, node: Node, weight) -> None:
        kind, inputs = _SIMPLE[node.kind]
        features = 0
        if node.settings.get("distribution", "MULTI_GGX") == "MULTI_GGX":
            features |= MULTISCATTER
        if kind == LOBE_PRINCIPLED:
            features |= self._principled_features(node)
        if kind == LOBE_TRANSPARENT or (kind == LOBE_PRINCIPLED and features & WITH_ALPHA):
            self.flags |= HAS_TRANSPARENCY
            if self.shadow and kind == LOBE_PRINCIPLED:
                kind, inputs = LOBE_ALPHA, ("alpha",)
        elif self.shadow:
            return
        if kind == LOBE_EMISSION:
            self._estimate_emission(node, weight, "color", "strength")
        elif kind == LOBE_PRINCIPLED and features & WITH_EMISSION:
            self._estimate_emission(node, weight, "emission_color", "emission_strength")
        if kind not in (LOBE_EMISSION, LOBE_TRANSPARENT, LOBE_HOLDOUT, LOBE_ALPHA):
            self.flags |= HAS_SURFACE
        if len(self.lobes) == CLOSURES:
            raise _TooComplex
        args = [self._input(node, name, kind, features) for name in inputs]
        self.lobes.append((kind, features, self._weight(weight), tuple(args + [NONE] * (len(PRINCIPLED) - len(args)))))

    def _principled_features(self, node: Node) -> int:
        def can_be(name, test):
            value = self._constant(node, name)
            return value is None or test(value)

        features = 0
        metal_only = not can_be("metallic", lambda value: value < 1.0)
        features |= WITH_ALPHA * can_be("alpha", lambda value: value < 1.0)
        features |= WITH_SHEEN * can_be("sheen_weight", lambda value: value > 0.0)
        features |= WITH_COAT * can_be("coat_weight", lambda value: value > 0.0)
        features |= WITH_METAL * can_be("metallic", lambda value: value > 0.0)
        features |= WITH_EMISSION * (
            can_be("emission_strength", lambda value: value != 0.0) and can_be("emission_color", any))
        if not metal_only:
            features |= WITH_TRANSMISSION * can_be("transmission_weight", lambda value: value > 0.0)
            features |= WITH_BASE * can_be("transmission_weight", lambda value: value < 1.0)
        return features

    def _input(self, node: Node, name: str, kind: int, features: int) -> int:
        """Operand of an input of a closure, NONE where no feature reads it."""
        if kind == LOBE_PRINCIPLED:
            for prefix, feature in (("sheen_", WITH_SHEEN), ("coat_", WITH_COAT), ("emission_", WITH_EMISSION)):
                # Sheen lies on the coat's normal, so it needs two of the coat's inputs.
                wanted = feature | (WITH_SHEEN if name in ("coat_normal",) else 0)
                if name.startswith(prefix) and not features & wanted and name != "coat_weight":
                    return NONE
            for names, feature in _READ_BY:
                if name in names and not features & feature:
                    return NONE
        default = NODES[node.kind][name]
        if default is None:
            return NONE if self._resolved(node, name) is None else self.vector(node, name)
        return self.vector(node, name) if isinstance(default, tuple) else self.number(node, name)

    def _estimate_emission(self, node: Node, weight, color: str, strength: str) -> None:
        self.flags |= HAS_EMISSION
        share = weight if not isinstance(weight, _Weight) else 1.0
        value = self._estimate(node, color) * self._estimate(node, strength) * share
        if np.all(np.isfinite(value)):
            self.emission = self.emission + np.maximum(value, 0.0)

    def _estimate(self, node: Node, name: str):
        """A typical value of an input: a constant itself, the mean of an image, 1 for all else."""
        constant = self._constant(node, name)
        if constant is not None:
            return np.array(constant)
        value = node[name]
        if value.kind == "image" and value.settings.get("output", "color") == "color":
            mean = np.array(self.scene.image_mean(value.settings.get("image")))
            return mean.mean() if isinstance(NODES[node.kind][name], float) else mean
        return np.array(1.0)

    # Values

    def _resolved(self, node: Node, name: str):
        """The value of an input; its default where a closure is linked to it."""
        value = node[name]
        if isinstance(value, Node) and value.kind in _CLOSURES:
            self.scene.warn(
                f"Material {self.name!r}: a shader is linked to {name!r} of {node.kind!r}; its default is used.")
            return NODES[node.kind][name]
        return value

    def _constant(self, node: Node, name: str):
        """The value of an input that is constant, a float or a 3-tuple as its default; None if there is no such."""
        value = self._resolved(node, name)
        if value is None or isinstance(value, Node):
            return None
        try:
            values = tuple(map(float, value)) if np.ndim(value) else (float(value),) * 3
        except (TypeError, ValueError):
            values = ()
        if len(values) < 3 or not all(map(math.isfinite, values)):
            self.scene.warn(f"Material {self.name!r}: {name!r} of {node.kind!r} is not a finite value; 0 is used.")
            values = ZERO
        if isinstance(NODES[node.kind][name], float):
            return sum(values[:3]) / 3.0 if np.ndim(value) else values[0]
        return values[:3]

    def number(self, node: Node, name: str, shift: int = 0) -> int:
        value = self._constant(node, name)
        if value is not None:
            return self.scene.constant(value)
        operand, type_ = self._value(node[name], shift)
        if type_ == "float":
            return operand
        return self._emit(OP_LUMINANCE if type_ == "color" else OP_AVERAGE, (operand,), 1)

    def vector(self, node: Node, name: str, shift: int = 0) -> int:
        value = self._constant(node, name)
        if value is not None:
            return self.scene.constant(*value)
        value = self._resolved(node, name)
        if value is None:
            return self._uv("", shift)
        operand, type_ = self._value(value, shift)
        return self._emit(OP_BROADCAST, (operand,), 3) if type_ == "float" else operand

    def _value(self, node: Node, shift: int) -> tuple[int, str]:
        key = id(node), shift
        if key not in self.values:
            self.values[key] = getattr(self, "_node_" + node.kind)(node, shift)
        return self.values[key]

    def _emit(self, op: int, args: tuple, width: int) -> int:
        """Append an instruction unless the same is there already; the first of its registers."""
        key = op, args
        if key not in self.emitted:
            if self.registers + width > REGISTERS:
                raise _TooComplex
            self.emitted[key] = self.registers
            self.instructions.append((op, self.registers, args + (0,) * (7 - len(args))))
            self.registers += width
        return self.emitted[key]

    def _layer(self, name) -> int:
        name = str(name or "")
        if name not in self.scene.layers:
            self.scene.warn(
                f"Material {self.name!r}: more than {UV_LAYERS} UV maps; {name!r} is replaced by the active one.")
        return self.scene.layers.get(name, 0)

    def _uv(self, name, shift: int) -> int:
        self.flags |= NEEDS_UV | (NEEDS_DERIVATIVES if shift else 0)
        return self._emit(OP_UV, (self._layer(name), shift), 3)

    def _node_uv(self, node, shift):
        return self._uv(node.settings.get("uv_map"), shift), "vector"

    def _node_mapping(self, node, shift):
        kind = _MAPPINGS.get(node.settings.get("type", "POINT"), POINT)
        vector = self.vector(node, "vector", shift)
        fixed = [self._constant(node, name) for name in ("location", "rotation", "scale")]
        if None not in fixed:
            matrix = self.scene.constant(*mapping_matrix(kind, *fixed).ravel().tolist())
            return self._emit(OP_MATRIX, (vector, matrix, int(kind == NORMAL_VECTOR)), 3), "vector"
        inputs = tuple(self.vector(node, name, shift) for name in ("location", "rotation", "scale"))
        return self._emit(OP_MAPPING, (vector, *inputs, kind), 3), "vector"

    def _node_image(self, node, shift):
        settings = node.settings
        index = settings.get("image")
        index = index if _is_index(index, self.scene.scene.images) else -1
        projection = settings.get("projection", "FLAT")
        if projection not in _PROJECTIONS:
            self.scene.warn(f"Material {self.name!r}: image projection {projection!r} is not supported; flat is used.")
        alpha = settings.get("output", "color") == "alpha"
        operand = self._emit(OP_IMAGE, (
            self.vector(node, "vector", shift), index,
            INTERPOLATIONS.get(settings.get("interpolation", "Linear"), 0),
            EXTENSIONS.get(settings.get("extension", "REPEAT"), 0),
            _PROJECTIONS.get(projection, FLAT), int(bool(settings.get("associated", False)) and not alpha)), 4)
        return (operand + 3, "float") if alpha else (operand, "color")

    def _node_normal_map(self, node, shift):
        space = _SPACES.get(node.settings.get("space", "TANGENT"), TANGENT)
        if space == TANGENT:
            self.flags |= NEEDS_TANGENT | NEEDS_OBJECT | NEEDS_UV
        elif space == OBJECT:
            self.flags |= NEEDS_OBJECT
        layer = self._layer(node.settings.get("uv_map")) if space == TANGENT else 0
        args = self.vector(node, "color", shift), self.number(node, "strength", shift), layer, space
        return self._emit(OP_NORMAL_MAP, args, 3), "vector"

    def _node_bump(self, node, shift):
        normal = NONE if self._resolved(node, "normal") is None else self.vector(node, "normal", shift)
        if self._constant(node, "height") is not None or self._constant(node, "strength") == 0.0:
            if normal != NONE:
                return normal, "vector"
            return self._emit(OP_BUMP, (*[self.scene.constant(0.0)] * 5, NONE, 0), 3), "vector"
        self.flags |= NEEDS_DERIVATIVES
        heights = tuple(self.number(node, "height", direction) for direction in range(3))
        rest = self.number(node, "strength", shift), self.number(node, "distance", shift), normal
        return self._emit(OP_BUMP, (*heights, *rest, int(bool(node.settings.get("invert", False)))), 3), "vector"


class _Weight:
    """A weight that is computed, not constant."""

    def __init__(self, operand: int):
        self.operand = operand


def _is_index(index, sequence) -> bool:
    return isinstance(index, (int, np.integer)) and not isinstance(index, bool) and 0 <= index < len(sequence)


def mapping_matrix(kind: int, location, rotation, scale) -> np.ndarray:
    """(3, 4) matrix of the Mapping node; Euler angles turn about x, then y, then z."""
    (cx, cy, cz), (sx, sy, sz) = np.cos(rotation), np.sin(rotation)
    turn = (
        np.array([[cz, -sz, 0.0], [sz, cz, 0.0], [0.0, 0.0, 1.0]])
        @ np.array([[cy, 0.0, sy], [0.0, 1.0, 0.0], [-sy, 0.0, cy]])
        @ np.array([[1.0, 0.0, 0.0], [0.0, cx, -sx], [0.0, sx, cx]]))
    location, scale = np.array(location), np.array(scale)
    inverse = np.divide(1.0, scale, out=np.zeros(3), where=scale != 0.0)
    if kind == TEXTURE:
        linear = np.diag(inverse) @ turn.T
        return np.column_stack([linear, -linear @ location])
    linear = turn @ np.diag(inverse if kind == NORMAL_VECTOR else scale)
    return np.column_stack([linear, location if kind == POINT else np.zeros(3)])
