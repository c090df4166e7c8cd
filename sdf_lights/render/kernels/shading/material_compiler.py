# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials compiled to tables: formulas that fill registers, and a flat list of lobes with weights.

An *operand* is the index of a register if it is not negative, of a constant (``~operand``) if it is. ``NONE`` stands
for an input without a value. A vector or colour takes three slots. Constants cost no code. Of a material, only what
some lobe with a weight needs is compiled. Mix and Add Shader only leave weights: each closure gets the sum over all
paths that reach it.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Iterable, Iterator

import numpy as np

from ....graph.folding import Folding
from ....graph.formula import CONSTANT, Formula, Vector, clamp, constant, maximum, select
from ....graph.substitution import without_objects
from ....vec import ZERO
from ...images import MISSING, Texture, mean_color
from ...material import NODES, Attribute, Material, Node, Table
from ...passes import aov_names
from ..textures import pack_textures
from . import special_lobes
from .graphs import Graphs, needs, typical
from .material_records import (
    AOV,
    EMISSION,
    LOBE,
    LOBE_ALPHA,
    LOBE_DIFFUSE,
    LOBE_EMISSION,
    LOBE_GLASS,
    LOBE_GLOSSY,
    LOBE_HOLDOUT,
    LOBE_PRINCIPLED,
    LOBE_REFRACTION,
    LOBE_TRANSLUCENT,
    LOBE_TRANSPARENT,
    MATERIAL,
    MULTISCATTER,
    NO_GRAPH,
    NONE,
    PRINCIPLED,
    VOLUME,
    WITH_ALPHA,
    WITH_BASE,
    WITH_COAT,
    WITH_EMISSION,
    WITH_METAL,
    WITH_SHEEN,
    WITH_TRANSMISSION,
)
from .records import (
    BENDS_EXITS,
    CLOSURES,
    HAS_EMISSION,
    HAS_SURFACE,
    HAS_TRANSPARENCY,
    NEGLIGIBLE,
    REGISTERS,
    STOPS_LIGHT_RAYS,
    UNCORRECTED,
)

THIRDS = Vector(*[constant(1.0 / 3.0)] * 3)


_READ_BY = (
    (("metallic",), WITH_METAL),
    (("transmission_weight",), WITH_TRANSMISSION),
    (("alpha",), WITH_ALPHA),
    (("diffuse_roughness", "specular_ior_level"), WITH_BASE),
    (("ior",), WITH_TRANSMISSION | WITH_BASE),
    *special_lobes.READ_BY,
)


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
    **special_lobes.SIMPLE,
}
_CLOSURES = {*_SIMPLE, "mix_closure", "add_closure"}


class _TooComplex(Exception):
    pass


def pack_materials(scene) -> tuple[dict[str, np.ndarray], Graphs]:
    """Tables of the materials and images of ``scene``, and the graphs of their formulas, which are not compiled yet.

    There is always at least one material, so that geometry without a material can refer to index 0.
    """
    compiler = _SceneCompiler(scene)
    materials = scene.materials or [Material("Default", Node("diffuse"))]
    records = np.zeros(len(materials), MATERIAL)
    for record, material in zip(records, materials):
        compiler.compile(material, record)
    emissions = np.zeros(1 + len(scene.lights), EMISSION)
    for record, source in zip(emissions, (scene.world, *scene.lights)):
        compiler.compile_emission(source.emission, record)
    if scene.world.aovs is not None:
        compiler.compile_world_aovs(scene.world.aovs, emissions[0])
    volumes = np.zeros(1 + len(materials), VOLUME)
    for record, owner in zip(volumes, (scene.world, *materials)):
        compiler.compile_volume(owner, owner is scene.world, record)
    return {
        "emissions": emissions,
        "volumes": volumes,
        "materials": records,
        "lobes": np.array(compiler.lobes or [(0, 0, 0, (0,) * len(PRINCIPLED))], LOBE),
        "aovs": np.array(compiler.aovs, AOV),
        "constants": np.array(compiler.constants, dtype=np.float64),
        **pack_textures(scene, compiler.textures),
    }, compiler.graphs


class _SceneCompiler:
    """Data shared by the materials of one scene: constants, graphs, lobes and images."""

    def __init__(self, scene):
        self.scene = scene
        self.attributes = {attribute: index for index, attribute in enumerate(scene.looked_up())}
        self.constants = [0.0, 0.0, 0.0]
        self.places = {}
        self.tables: dict[int, int] = {}
        self.graphs = Graphs()
        self.lobes: list[tuple] = []
        self.aovs: list[tuple] = []
        self.textures: dict[Texture, int] = {}
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

    def block(self, values: Iterable[float]) -> int:
        """Index of numbers among the constants, which are read in a row."""
        place = len(self.constants)
        self.constants.extend(values)
        return place

    def numbers(self, material: Material) -> list[float]:
        """Values of the parameters of a material's formulas."""
        return [self._number(material, value) for value in material.parameters]

    def _number(self, material: Material, value) -> float:
        if isinstance(value, Attribute):
            return float(self.attributes[value])
        if isinstance(value, Table):
            if id(value) not in self.tables:
                self.tables[id(value)] = self.block(np.asarray(value.values, np.float64).ravel().tolist())
            return float(self.tables[id(value)])
        if isinstance(value, Texture):
            return float(self.textures.setdefault(value, len(self.textures)))
        if not math.isfinite(value):
            self.warn(f"Material {material.name!r}: a value of a node is not a finite number: 0 is used; set it again.")
            return 0.0
        return float(value)

    def image_mean(self, place: int) -> tuple[float, float, float]:
        """Approximate mean of a texture's colours."""
        if place < 0:
            return 0.0, 0.0, 0.0
        if place not in self.means:
            texture, images = list(self.textures)[place], self.scene.images
            found = [index for _, index in texture.tiles] or [texture.image]
            means = [mean_color(images[index]) if _is_index(index, images) else MISSING[:3] for index in found]
            self.means[place] = tuple(np.mean(means, axis=0).tolist())
        return self.means[place]

    def compile(self, material: Material, record) -> None:
        start = len(self.lobes)
        record["sample_emission"], record["index"] = material.sample_emission, material.index
        try:
            self._compile(material, record)
        except (_TooComplex, RecursionError):
            del self.lobes[start:]
            self.warn(f"Material {material.name!r} has too many nodes to be compiled and is shown grey; simplify it.")
            self._compile(Material(material.name, Node("diffuse")), record)

    def _compile(self, material: Material, record) -> None:
        emission, flags = np.zeros(3), 0
        values = Folding(self.numbers(material))
        for shadow in (False, True):
            program = _Program(self, material.name, values, shadow)
            program.compile(material.surface)
            if not shadow:
                record["aovs"] = self._compile_aovs(material, program)
                record["normal"] = NONE if material.normal is None else program.operand(*material.normal)
            prefix = "shadow_" if shadow else ""
            graph, numbers = self.graphs.add(program.roots)
            record[prefix + "graph"], record[prefix + "slots"] = graph, self.block(numbers)
            record[prefix + "lobes"] = len(self.lobes), len(self.lobes) + len(program.lobes)
            self.lobes += program.lobes
            flags |= program.flags | needs(program.roots, shadow)
            flags |= BENDS_EXITS if material.normal is not None else 0
            emission = np.maximum(emission, program.emission)
        if flags & HAS_TRANSPARENCY and not material.transparent_shadows:
            flags ^= HAS_TRANSPARENCY | STOPS_LIGHT_RAYS
        flags |= 0 if material.bump_correction else UNCORRECTED
        record["flags"], record["emission"] = flags, emission

    def _compile_aovs(
        self, material: Material, program: _Program, prepared=lambda formulas: formulas
    ) -> tuple[int, int]:
        """The range of the AOVs of a material."""
        first = len(self.aovs)
        for number, name in enumerate(aov_names(self.scene.passes)):
            value = material.aovs.get(name)
            if value is not None:
                formulas = prepared(tuple(value) if isinstance(value, Vector) else (value,))
                self.aovs.append((number, len(formulas), program.operand(*formulas)))
        return first, len(self.aovs)

    def compile_world_aovs(self, material: Material, record) -> None:
        """A graph of the AOVs of the world's nodes."""
        program = _Program(self, material.name, Folding(self.numbers(material)), False)
        first = len(self.aovs)
        try:
            record["aovs"] = self._compile_aovs(material, program, without_objects)
        except (_TooComplex, RecursionError):
            del self.aovs[first:]
            self.warn(f"{material.name} has too many nodes for its AOVs, which are 0; simplify it.")
            return
        record["aov_graph"], numbers = self.graphs.add(program.roots)
        record["aov_slots"] = self.block(numbers)

    def compile_emission(self, material: Material | None, record) -> None:
        """A graph of the emission of a world's or a light's closures; none without nodes."""
        record["graph"], record["mean"] = NO_GRAPH, 1.0
        if material is None:
            return
        values = Folding(self.numbers(material))
        program = _Program(self, material.name, values, False)
        try:
            # There is no object for look-ups, and no table of objects when a map of a world is made.
            emitted = without_objects(tuple(program.emitted(material.surface)))
            radiance = [values.fold(channel) for channel in emitted]
        except RecursionError:
            self.warn(f"{material.name} has too many nodes to be compiled and is black; simplify it.")
            radiance = [constant(0.0)] * 3
        record["mean"] = typical(radiance, self.image_mean)
        graph, numbers = self.graphs.add(radiance)
        record["graph"], record["slots"] = graph, self.block(numbers)

    def compile_volume(self, owner, is_world: bool, record) -> None:
        """A graph of the coefficients of a medium that varies in space; none if it does not."""
        record["graph"] = NO_GRAPH
        varying = owner.medium and owner.medium.varying
        if not varying:
            return
        name = "World" if is_world else owner.name
        values = Folding(self.numbers(Material(name, None, parameters=varying.parameters)))
        roots = varying.roots()
        try:
            # The world is no object, of which formulas could read anything.
            found = [values.fold(root) for root in (without_objects(tuple(roots)) if is_world else roots)]
        except RecursionError:
            self.warn(f"The volume of {name!r} has too many nodes to be compiled and is left out; simplify it.")
            found = [constant(0.0)] * len(roots)
        graph, numbers = self.graphs.add(found)
        record["graph"], record["slots"] = graph, self.block(numbers)


class _Program:
    """Formulas and lobes of a material: all of them, or those that transparency needs (``shadow``). ``roots`` are the
    formulas whose values the registers hold, in order."""

    def __init__(self, scene: _SceneCompiler, name: str, values: Folding, shadow: bool):
        self.scene, self.name, self.values, self.shadow = scene, name, values, shadow
        self.lobes: list[tuple] = []
        self.roots: list[Formula] = []
        self.flags = 0
        self.emission = np.zeros(3)
        self.registers: dict[tuple[Formula, ...], int] = {}
        self.emitters: dict[int, Node] = {}

    # Closures

    def emitted(self, surface) -> Vector:
        """RGB of all Emission closures, with their weights."""
        total = Vector(*[constant(0.0)] * 3)
        for node, weight in self._leaves(surface):
            if node.kind == "emission":
                total = total + self._vector(node, "color") * (self._scalar(node, "strength") * weight)
        return total

    def compile(self, surface) -> None:
        for node, weight in self._seen_by_light_rays(surface) if self.shadow else self._leaves(surface):
            self._lobe(node, weight)

    def _seen_by_light_rays(self, surface) -> Iterator[tuple[Node, Formula]]:
        """As ``_leaves``. As in Cycles, portals are opaque to light rays, but clear if something beside them is."""
        leaves = list(self._leaves(surface))
        clear = [self._clear(node, weight) for node, weight in leaves if node.kind in ("transparent", "principled")]
        for node, weight in leaves:
            if node.kind != "ray_portal":
                yield node, weight
            elif clear:
                part = select(functools.reduce(maximum, clear) < NEGLIGIBLE, 0.0, weight)
                yield Node("transparent", {"color": node["color"]}), part

    def _clear(self, node: Node, weight: Formula) -> Formula:
        """The transparency of a closure."""
        if node.kind == "transparent":
            return self._vector(node, "color").dot(THIRDS) * weight
        return (1.0 - self._scalar(node, "alpha")) * weight

    def _leaves(self, surface) -> Iterator[tuple[Node, Formula]]:
        """Closures other than Mix and Add, each with the sum of its weights."""
        surface = self._closure(surface)
        if surface is None:
            return
        weights = {id(surface): constant(1.0)}
        for node in self._topological(surface):
            weight = weights.get(id(node))  # None: every path to it has zero weight
            if weight is None or weight.kind == CONSTANT and weight.value == 0.0:
                continue
            if node.kind == "add_closure":
                shares = (("a", weight), ("b", weight))
            elif node.kind == "mix_closure":
                shares = self._mix(node, weight)
            else:
                yield node, weight
                continue
            for name, share in shares:
                child = self._closure(node[name])
                if child is not None:
                    weights[id(child)] = self.values.fold(weights.get(id(child), constant(0.0)) + share)

    def _closure(self, value) -> Node | None:
        """The closure node at a closure input; a value is emitted, as in Blender."""
        if value is None or isinstance(value, Node):
            return value
        if id(value) not in self.emitters:
            self.emitters[id(value)] = Node("emission", {"color": value})
        return self.emitters[id(value)]

    def _topological(self, root: Node) -> list[Node]:
        """Closure nodes reached from ``root``, each before its inputs."""
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

    def _mix(self, node: Node, weight: Formula):
        factor = clamp(self._scalar(node, "factor"), 0.0, 1.0)
        return ("a", weight * (1.0 - factor)), ("b", weight * factor)

    def _lobe(self, node: Node, weight: Formula) -> None:
        kind, inputs = _SIMPLE[node.kind]
        kind, inputs, features = special_lobes.variant(node, kind, inputs, functools.partial(self._can_be, node))
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
        self.flags |= special_lobes.needs(node, kind, features, functools.partial(self._can_be, node))
        if len(self.lobes) == CLOSURES:
            raise _TooComplex
        args = [self._input(node, name, kind, features) for name in inputs]
        self.lobes.append((kind, features, self.operand(weight), tuple(args + [NONE] * (len(PRINCIPLED) - len(args)))))

    def _can_be(self, node: Node, name: str, test) -> bool:
        """Whether an input may have a value that passes a test."""
        value = self._constant(node, name)
        return value is None or test(value)

    def _principled_features(self, node: Node) -> int:
        can_be = functools.partial(self._can_be, node)
        features = 0
        metal_only = not can_be("metallic", lambda value: value < 1.0)
        features |= WITH_ALPHA * can_be("alpha", lambda value: value < 1.0)
        features |= WITH_SHEEN * can_be("sheen_weight", lambda value: value > 0.0)
        features |= WITH_COAT * can_be("coat_weight", lambda value: value > 0.0)
        features |= WITH_METAL * can_be("metallic", lambda value: value > 0.0)
        features |= WITH_EMISSION * (
            can_be("emission_strength", lambda value: value != 0.0) and can_be("emission_color", any)
        )
        if not metal_only:
            features |= WITH_TRANSMISSION * can_be("transmission_weight", lambda value: value > 0.0)
            features |= WITH_BASE * can_be("transmission_weight", lambda value: value < 1.0)
        return features

    def _input(self, node: Node, name: str, kind: int, features: int) -> int:
        """Operand of an input of a closure, NONE if no feature reads it."""
        if kind == LOBE_PRINCIPLED:
            for prefix, feature in (("sheen_", WITH_SHEEN), ("coat_", WITH_COAT), ("emission_", WITH_EMISSION)):
                # Sheen uses the coat's normal, so it needs two of the coat's inputs.
                wanted = feature | (WITH_SHEEN if name in ("coat_normal",) else 0)
                if name.startswith(prefix) and not features & wanted and name != "coat_weight":
                    return NONE
            for names, feature in _READ_BY:
                if name in names and not features & feature:
                    return NONE
        default = NODES[node.kind][name]
        if default is None:
            return NONE if self._resolved(node, name) is None else self.operand(*self._vector(node, name))
        if isinstance(default, tuple):
            return self.operand(*self._vector(node, name))
        return self.operand(self._scalar(node, name))

    def _estimate_emission(self, node: Node, weight: Formula, color: str, strength: str) -> None:
        self.flags |= HAS_EMISSION
        amount = self._scalar(node, strength) * (weight if weight.kind == CONSTANT else 1.0)
        value = typical(
            [self.values.fold(amount * channel) for channel in self._vector(node, color)], self.scene.image_mean
        )
        if np.all(np.isfinite(value)):
            self.emission = self.emission + np.maximum(value, 0.0)

    # Values

    def operand(self, *formulas: Formula) -> int:
        """Operand of one formula, or of three in a row. Raises _TooComplex if there are no registers left."""
        folded = tuple(map(self.values.fold, formulas))
        if all(formula.kind == CONSTANT for formula in folded):
            return self.scene.constant(*(formula.value for formula in folded))
        if folded not in self.registers:
            if len(self.roots) + len(folded) > REGISTERS:
                raise _TooComplex
            self.registers[folded] = len(self.roots)
            self.roots += folded
        return self.registers[folded]

    def _resolved(self, node: Node, name: str):
        """The value of an input; its default if a closure is linked to it."""
        value = node[name]
        if isinstance(value, Node):
            self.scene.warn(
                f"Material {self.name!r}: a shader is linked to {name!r} of {node.kind!r}; its default is used."
            )
            return NODES[node.kind][name]
        return value

    def _constant(self, node: Node, name: str):
        """The value of a constant input, a float or a 3-tuple like its default; None if it varies."""
        value = self._resolved(node, name)
        if value is None:
            return None
        if isinstance(NODES[node.kind][name], float):
            folded = (self.values.fold(self._scalar(node, name)),)
        else:
            folded = tuple(map(self.values.fold, self._vector(node, name)))
        if any(formula.kind != CONSTANT for formula in folded):
            return None
        return folded[0].value if len(folded) == 1 else tuple(formula.value for formula in folded)

    def _scalar(self, node: Node, name: str) -> Formula:
        value = self._resolved(node, name)
        if isinstance(value, Formula):
            return value
        if isinstance(value, Vector):
            return (value.x + value.y + value.z) * (1.0 / 3.0)
        return constant(sum(self._finite(node, name, value)) / 3.0)

    def _vector(self, node: Node, name: str) -> Vector:
        value = self._resolved(node, name)
        if isinstance(value, Formula):
            return Vector(value, value, value)
        if isinstance(value, Vector):
            return value
        return Vector(*map(constant, self._finite(node, name, value)))

    def _finite(self, node: Node, name: str, value) -> tuple[float, ...]:
        """A constant as three numbers."""
        try:
            values = tuple(map(float, value))[:3] if np.ndim(value) else (float(value),) * 3
        except (TypeError, ValueError):
            values = ()
        if len(values) < 3 or not all(map(math.isfinite, values)):
            self.scene.warn(f"Material {self.name!r}: {name!r} of {node.kind!r} is not a finite value; 0 is used.")
            values = ZERO
        return values


def _is_index(index, sequence) -> bool:
    return isinstance(index, (int, np.integer)) and not isinstance(index, bool) and 0 <= index < len(sequence)
