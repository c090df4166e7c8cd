# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's shader nodes as ``render.material``: closures as its nodes, values as formulas.

``closure_nodes`` maps closures and sockets to closures and inputs. Value nodes are defined in
``render.nodes``, which see a node through ``node_inputs``. Groups, reroutes and muted nodes are resolved. README.md one
folder up lists the replacements of unsupported nodes.
"""

from __future__ import annotations

import bpy
import numpy as np

from ...graph.formula import Formula, Vector, call, parameter
from ...render.images import Texture
from ...render.material import NODES, Attribute, Material, Node, Table
from ...render.nodes import DEFINITIONS
from ...render.nodes.geometry import strand_random
from ...render.nodes.lookups import ATTRIBUTE
from ...render.nodes.variables import BARYCENTRIC, as_vector
from . import zones
from .attributes import property_of
from .closure_nodes import CLOSURES
from .common import Warnings
from .images import Images
from .links import INLINED, NOWHERE, Links
from .node_inputs import BlenderInputs, is_field
from .node_values import (
    BLACK,
    EXAMPLES,
    FOLDED,
    MISSING,
    WHOLE,
    constant_of,
    converted,
    numbers_of,
    replaces_default,
    whole,
)
from .zones import Stack, by_identifier

_ONLY_EEVEE = " (only EEVEE has it: a path tracer cannot read a shader's result as a color)"


MOST_INPUTS = 20_000  # of a tree with all groups written out: a malicious file may double them at each level


class Reader:
    """Reads one node tree. ``owner`` names it in warnings: "Material 'Wood'". Time, view layer and world come from
    ``depsgraph``, because a window may show a different scene than the rendered one.

    ``parameters`` are the values of the slots of all formulas read so far. ``domain`` is "SURFACE", "VOLUME" (inside a
    mesh), "WORLD" (where the position is the direction of the ray, or a point of its volume) or "LIGHT". ``light`` has
    data for nodes of lights: "light_matrix" (3, 4) maps from the world to the light, without its scale; "light_normals"
    (3, 3) does so for normals, with the scale, as in Cycles; "light_shape": see ``projections.light_place``;
    "object_info": the result of ``lookups.OBJECT_INFO``; "owners": the data whose properties are its attributes.
    ``grids`` are the names of the grids of voxels that a volume has, ``volume_interpolation`` is a key of
    ``lookups.GRID``.
    """

    def __init__(
        self,
        tree: bpy.types.NodeTree,
        owner: str,
        depsgraph: bpy.types.Depsgraph,
        images: Images | None,
        warn: Warnings,
        domain: str = "SURFACE",
        material_index: int = 0,
        light: dict[str, object] | None = None,
        grids: frozenset[str] = frozenset(),
        volume_interpolation: str = "LINEAR",
    ):
        self.tree, self._owner, self.images, self._warn = tree, owner, images, warn
        self.scene, self._view_layer = depsgraph.scene_eval, depsgraph.view_layer_eval
        self.domain, self.material_index = domain, material_index
        self.light = light or {}
        self.grids, self.volume_interpolation = grids, volume_interpolation
        self.parameters: list[float | Attribute | Table | Texture] = []
        self._followed, self._reading = 0, False  # number of inputs read; whether one is being read
        self.links = Links()
        self._values: dict[tuple, object] = {}
        self._folds: dict[tuple, bool] = {}
        self._constants: dict[tuple, Formula | Vector] = {}

    # -- walking -------------------------------------------------------------------------------------------------------

    def output(self) -> bpy.types.Node | None:
        """The active output node: Blender's choice for engines that read Cycles' nodes. Warns with the reason if there
        is none."""
        if self.links.circular(self.tree):
            self._warn(f"{self._owner}: its links form a circle, so it is black: remove one of them.")
            return None
        found = self.tree.get_output_node("CYCLES")
        if found is None and self.domain == "SURFACE":
            self._warn(
                f"{self._owner} has no Material Output node, so it is black: add one and link a shader to its Surface."
            )
        return found

    def resolve(self, socket, stack: Stack = ()):
        """The source of an input socket, through groups, reroutes and muted nodes.

        Returns (node, output socket, stack), or (None, input socket, stack) with the socket whose own value is used, or
        ``NOWHERE``.
        """
        return self._walk(socket, stack)[:3]

    def _walk(self, socket, stack: Stack):
        """As ``resolve``, with the types of the sockets on the way, from the input on, and whether they convert only
        constants: if Blender resolves groups, varying values pass such sockets unchanged."""
        receiver, passing = socket, False  # whether reroutes or muted nodes came since the receiver
        types: list[tuple[str, bool]] = []  # whether it converts only constants
        known = 0  # number of types up to the receiver
        self._followed += 1
        if self._followed > MOST_INPUTS:
            if self._followed == MOST_INPUTS + 1:
                self._warn(
                    f"{self._owner}: its groups are nested so often that it has more than {MOST_INPUTS:,} inputs, so "
                    "parts of it are left out: nest fewer groups."
                )
            return None, receiver, stack, types
        while True:
            link, end = self.links.into(socket), NOWHERE if passing and not INLINED else receiver
            if link is None:
                return None, end, stack, types[:known]
            if len(stack) > zones.DEEPEST:
                self.report(link.from_node, "its groups or zones are nested too deeply, so it is left out")
                return None, receiver, stack, types[:known]
            node, output = link.from_node, link.from_socket
            if node.bl_idname == "NodeReroute":
                types += [(output.type, INLINED)]
                socket, passing = node.inputs[0], True
                continue
            if node.mute:
                socket = next((inner.from_socket for inner in node.internal_links if inner.to_socket == output), None)
                if socket is None:
                    return None, end, stack, types[:known]
                types += [(output.type, INLINED), (socket.type if INLINED else output.type, INLINED)]
                passing = True
                continue
            if node.bl_idname in zones.PASSES:
                found = zones.PASSES[node.bl_idname](self, node, output, stack)
                if found is None:
                    return node, output, stack, types
                socket, stack = found
            else:
                return node, output, stack, types
            if socket is None:
                return None, receiver, stack, types[:known]
            if socket is NOWHERE:
                return None, NOWHERE, stack, types
            kept = INLINED and node.bl_idname != zones.CONVERSION
            types += [(output.type, kept), (socket.type, kept)]
            receiver, passing, known = socket, False, len(types)

    # -- reading -------------------------------------------------------------------------------------------------------

    def read(self, socket, like, stack: Stack = ()):
        """Value of an input of a closure: a formula, a vector or a ``Node``, for an input with the default ``like``.

        None if ``like`` is None and nothing is linked: the input then has its default. A value at a shader input
        becomes an emission of that value.
        """
        outermost, self._reading = not self._reading, True
        try:
            value = self._read(socket, like, stack)
        except RecursionError:
            if not outermost:
                raise
            self._warn(
                f"{self._owner}: its chains of nodes are too long, so it is left out: link fewer nodes one after another."
            )
            return None
        finally:
            self._reading = self._reading and not outermost
        if socket.type == "SHADER" and isinstance(value, (Formula, Vector)):
            return Node("emission", {"color": converted(value, "VECTOR", BLACK)})
        return value

    def _read(self, socket, like, stack: Stack):
        node, end, inner, types = self._walk(socket, stack)
        if node is not None:
            value = self._value(node, end, inner)
            if value is not MISSING:
                return converted(*self._carried(value, end.type, types, node, inner), like)
            end, types = _without_source(socket, types), []
        if like is None and not replaces_default(end, socket):
            return None
        value = self._constant(end, inner)
        return None if value is None else converted(*self._carried(value, end.type, types), like)

    def _carried(self, value, socket_type: str, types: list[tuple[str, bool]], node=None, stack: Stack = ()):
        """Convert a value of a node, or of a socket, through sockets of these ``types``, the last one first. Returns it
        with its final type."""
        if isinstance(value, (Formula, Vector)):
            for passed, of_constants in reversed(types):
                if passed == socket_type or passed not in EXAMPLES and passed not in WHOLE:
                    continue
                if not of_constants or node is None or self.folds(node, stack):
                    if passed in WHOLE:
                        value = whole(value, socket_type, passed)
                    else:
                        value = converted(value, socket_type, EXAMPLES[passed])
                    socket_type = passed
        return value, socket_type

    def folds(self, node, stack: Stack, ignored: str = "") -> bool:
        """Whether Blender computes a node itself and gives Cycles only the result: since 5.0, if it is one of
        ``FOLDED`` and all its inputs, but for the ``ignored`` one, are constants."""
        if not INLINED:
            return False
        key = node.as_pointer(), zones.key_of(stack), ignored
        if key not in self._folds:
            self._folds[key] = False  # for a circle
            self._folds[key] = zones.is_constant(node) or (
                node.bl_idname in FOLDED
                and all(
                    self._is_constant(node, socket, stack)
                    for socket in node.inputs
                    if socket.enabled and socket.identifier != ignored
                )
            )
        return self._folds[key]

    def _is_constant(self, node, socket, stack: Stack) -> bool:
        source, end, inner, _ = self._walk(socket, stack)
        if source is not None:
            return self.folds(source, inner)
        return end not in (socket, NOWHERE) or not is_field(node, socket)

    def has_source(self, socket, stack: Stack) -> bool:
        """Whether an input is linked to a node that is known, or through a group of a version that gives it zero."""
        node, end, inner, types = self._walk(socket, stack)
        return node is not None and (
            self._value(node, end, inner) is not MISSING or _without_source(socket, types) is NOWHERE
        )

    def number_of(self, socket, stack: Stack) -> float | None:
        """The number at an input; None if it varies."""
        value, kind = self.value(socket, stack)
        return None if value is None else numbers_of(self.parameters, converted(value, kind, 0.0))

    def value(self, socket, stack: Stack) -> tuple[Formula | Vector | None, str]:
        """The value of an input of a value node, and the type of the last socket on its way; None if it is not a
        value."""
        node, end, inner, types = self._walk(socket, stack)
        if node is not None:
            value = self._value(node, end, inner)
            if value is not MISSING and isinstance(value, (Formula, Vector)):
                return self._carried(value, end.type, types, node, inner)
            end, types = _without_source(socket, types), []
        return self._carried(self._constant(end, inner), end.type, types)

    def _constant(self, socket, stack: Stack) -> Formula | Vector | None:
        """A socket's own value, as parameters."""
        key = socket.as_pointer(), zones.key_of(stack)
        if key not in self._constants:
            self._constants[key] = self.parametric(constant_of(socket))
        return self._constants[key]

    def parametric(self, value) -> Formula | Vector | None:
        """A number, a triple or a position, as parameters."""
        if value is None:
            return None
        if isinstance(value, tuple):
            return Vector(*map(self.parametric, value))
        if isinstance(value, float) and value != value:
            self._warn(f"{self._owner}: a value of a node is not a finite number: 0 is used; set it again.")
            value = 0.0
        self.parameters.append(value)
        return parameter(len(self.parameters) - 1)

    def _value(self, node, output, stack: Stack):
        """The value of a node's output. All outputs of a node are computed at once, unless it is a closure."""
        groups = zones.key_of(stack)
        key = (node.as_pointer(), output.identifier, groups)
        if key not in self._values:
            definition = DEFINITIONS.get(node.bl_idname)
            number = zones.constant_of(node, output, stack)
            if number is not None:
                self._values[key] = self.parametric(number)
            elif definition is None:
                self._values[key] = self._closure(node, output, stack)
            else:
                inputs = BlenderInputs(self, node, stack, output)
                for identifier, value in definition(inputs).items():
                    self._values[node.as_pointer(), identifier, groups] = value
                self._values.setdefault(key, MISSING)
        return self._values[key]

    def _closure(self, node, output, stack: Stack):
        entry = CLOSURES.get(node.bl_idname)
        if entry is None:
            return self._unsupported(node, output, stack)
        inputs = {}
        for name, identifier in entry.inputs.items():
            socket = by_identifier(node.inputs, identifier)
            value = None if socket is None else self.read(socket, NODES[entry.kind][name], stack)
            if value is not None:
                inputs[name] = value
        if entry.kind == "principled_hair" and self._varies(node, stack):
            place = self.parametric(Attribute("strand", "random"))
            inputs["random"] = strand_random(place, inputs["random"])
        if entry.kind == "principled_hair" and node.model == "HUANG":
            place = self.parametric(Attribute("strand", "normal"))
            inputs["axis"] = as_vector(call(ATTRIBUTE, place, *BARYCENTRIC))
        return Node(entry.kind, inputs, entry.settings(node))

    def _varies(self, node, stack: Stack) -> bool:
        """Whether Principled Hair varies from strand to strand by its random inputs."""
        sockets = {socket.identifier: socket for socket in node.inputs}
        if self.resolve(sockets["Random"], stack)[0] is not None:
            return False
        amounts = [sockets[name] for name in ("Random Roughness", "Random Color")]
        return any(self.resolve(each, stack)[0] is not None or each.default_value != 0.0 for each in amounts)

    def _unsupported(self, node, output, stack: Stack):
        if output.type != "SHADER":
            return self._passed_on(node, output, stack)
        socket = next((socket for socket in node.inputs if socket.name in {"Color", "Base Color"}), None)
        if socket is None:
            self.report(node, "not supported, so it is black")
            return None
        self.report(node, "not supported, so it is a Diffuse BSDF of the same color")
        return Node("diffuse", {"color": self.read(socket, BLACK, stack)})

    def _passed_on(self, node, output, stack: Stack):
        """The first input of the same kind, which a muted node passes on."""
        socket = next((socket for socket in node.inputs if socket.enabled and socket.type == output.type), None)
        value = None if socket is None else self.value(socket, stack)[0]
        if value is None:
            why = _ONLY_EEVEE if node.bl_idname == "ShaderNodeShaderToRGB" else ""
            self.report(node, f"not supported{why}, so the socket it is linked to uses its own value")
            return MISSING
        self.report(node, f"not supported, so its input {socket.name} is passed on, as if it was muted")
        return value

    def attribute_value(self, node) -> list[float] | None:
        """Components of the property named by an Attribute node, for a light or the view layer; None if there is
        none."""
        owners = self.light.get("owners", ())
        if node.attribute_type == "VIEW_LAYER":
            owners = self._view_layer, self.scene, self.scene.world
        elif node.attribute_type == "GEOMETRY":
            owners = ()
        found = next(
            (found for found in (property_of(owner, node.attribute_name) for owner in owners) if found is not None),
            None,
        )
        return None if found is None else found[0].tolist()

    def report(self, node, what: str) -> None:
        """Warn about a node, with the name that the node editor shows."""
        kind = node.bl_rna.name
        name = f"'{node.name}'" if node.name == kind else f"'{node.name}' ({kind})"
        self._warn(f"{self._owner}: node {name}: {what}.")


def _without_source(socket, types: list):
    """The socket whose own value counts at an input that is linked to an unknown node."""
    return NOWHERE if types and not INLINED else socket


def emission_of(reader: Reader, name: str) -> tuple[np.ndarray, Material | None]:
    """The emission of the node tree of a light or a world: RGB if it is constant, else white and the nodes."""
    output = reader.output()
    surface = None if output is None else reader.read(output.inputs["Surface"], None)
    if surface is None:
        return np.zeros(3), None
    if isinstance(surface, Node) and surface.kind == "emission":
        color, strength = (numbers_of(reader.parameters, surface[name]) for name in ("color", "strength"))
        if color is not None and strength is not None:
            return np.array(color) * strength, None
    return np.ones(3), Material(name, surface, parameters=reader.parameters)
