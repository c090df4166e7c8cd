# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Nodes that only pass values on: groups, and the repeat zones, closures, bundles and switches of Blender 5.

A *stack* is the position of a walk along links: the groups, the iterations of zones, and the callers. ``PASSES`` gives,
for each such node, the socket at which the walk continues.
"""

from __future__ import annotations

from typing import NamedTuple

import bpy

from .links import NOWHERE

DEEPEST = 64  # nested groups, iterations and closures
MOST_ROUNDS = 256


class Frame(NamedTuple):
    """A group node, an iteration of a repeat zone (its output node), or the node that evaluates a closure, whose inputs
    are those of ``caller``."""

    node: bpy.types.Node
    round: int = 0
    caller: "Stack" = ()


Stack = tuple[Frame, ...]  # outermost first


def key_of(stack: Stack) -> tuple:
    """Identifies a stack."""
    return tuple((frame.node.as_pointer(), frame.round, key_of(frame.caller)) for frame in stack)


def by_identifier(sockets, identifier: str):
    """The socket with this identifier; None if there is none."""
    return next((socket for socket in sockets if socket.identifier == identifier), None)


def _by_name(sockets, name: str):
    return next((socket for socket in sockets if socket.name == name), None)


CONVERSION = "NodeImplicitConversion"


def _group(reader, node, output, stack: Stack):
    if node.node_tree is None:
        return None
    if reader.links.circular(node.node_tree):
        return NOWHERE, stack
    inside = next(
        (inner for inner in node.node_tree.nodes if inner.bl_idname == "NodeGroupOutput" and inner.is_active_output),
        None,
    )
    return inside and by_identifier(inside.inputs, output.identifier), (*stack, Frame(node))


def _group_input(reader, node, output, stack: Stack):
    if not stack:
        return None
    return by_identifier(stack[-1].node.inputs, output.identifier), stack[:-1]


def _repeat_output(reader, node, output, stack: Stack):
    start = next(
        (
            other
            for other in node.id_data.nodes
            if other.bl_idname == "GeometryNodeRepeatInput" and other.paired_output == node
        ),
        None,
    )
    if start is None:
        return None
    rounds = reader.number_of(start.inputs["Iterations"], stack)
    if rounds is None or rounds > MOST_ROUNDS:
        reader.report(start, f"its number of iterations has to be a constant of at most {MOST_ROUNDS}, so it has none")
        rounds = 0
    if rounds < 1:
        return by_identifier(start.inputs, output.identifier), stack
    return by_identifier(node.inputs, output.identifier), (*stack, Frame(node, int(rounds) - 1))


def _repeat_input(reader, node, output, stack: Stack):
    if output.identifier == "Iteration" or not stack:
        return None
    round_ = stack[-1].round
    if round_ == 0:
        return by_identifier(node.inputs, output.identifier), stack[:-1]
    return by_identifier(node.paired_output.inputs, output.identifier), (
        *stack[:-1],
        stack[-1]._replace(round=round_ - 1),
    )


def _evaluate_closure(reader, node, output, stack: Stack):
    closure, _, inner = reader.resolve(node.inputs["Closure"], stack)
    if closure is None or closure.bl_idname != "NodeClosureOutput":
        return None
    return _by_name(closure.inputs, output.name), (*inner, Frame(node, 0, stack))


def _closure_input(reader, node, output, stack: Stack):
    if not stack:
        return None
    return _by_name(stack[-1].node.inputs, output.name), stack[-1].caller


def _separate_bundle(reader, node, output, stack: Stack):
    return _in_bundle(reader, node.inputs[0], output.name, stack)


def _in_bundle(reader, socket, name: str, stack: Stack):
    source, _, inner = reader.resolve(socket, stack)
    if source is None:
        return None
    if source.bl_idname == "NodeCombineBundle":
        found = _by_name(source.inputs, name)
        return None if found is None else (found, inner)
    if source.bl_idname == "NodeJoinBundle":
        # Every link into the socket is a bundle; the first that has the item counts.
        for link in source.id_data.links:
            if link.to_node == source and link.from_node.bl_idname == "NodeCombineBundle":
                found = _by_name(link.from_node.inputs, name)
                if found is not None:
                    return found, inner
    return None


def _menu_switch(reader, node, output, stack: Stack):
    if output.identifier != "Output":
        return None
    _, end, _ = reader.resolve(node.inputs["Menu"], stack)
    chosen = getattr(end, "default_value", "")
    item = next((item for item in node.enum_items if item.name == chosen), None)
    found = (
        None if item is None else _by_name([socket for socket in node.inputs if socket.identifier != "Menu"], item.name)
    )
    return found, stack


def _conversion(reader, node, output, stack: Stack):
    return node.inputs[0], stack


PASSES = {
    "ShaderNodeGroup": _group,
    "NodeGroupInput": _group_input,
    "GeometryNodeRepeatOutput": _repeat_output,
    "GeometryNodeRepeatInput": _repeat_input,
    "NodeEvaluateClosure": _evaluate_closure,
    "NodeClosureInput": _closure_input,
    "NodeSeparateBundle": _separate_bundle,
    "GeometryNodeMenuSwitch": _menu_switch,
    CONVERSION: _conversion,
}
"""bl_idname → the socket where a walk continues from an output of the node, and the stack there; None: the walk ends at
the node."""


def is_constant(node) -> bool:
    """Whether ``constant_of`` gives the values of a node."""
    return node.bl_idname in (
        "GeometryNodeRepeatInput",
        "FunctionNodeInputBool",
        "FunctionNodeInputInt",
        "FunctionNodeInputVector",
    )


def constant_of(node, output, stack: Stack):
    """The number or the triple that a node gives for all inputs; None for other nodes."""
    kind = node.bl_idname
    if kind == "GeometryNodeRepeatInput" and output.identifier == "Iteration" and stack:
        return float(stack[-1].round)
    if kind == "FunctionNodeInputBool":
        return float(node.boolean)
    if kind == "FunctionNodeInputInt":
        return float(node.integer)
    if kind == "FunctionNodeInputVector":
        return tuple(map(float, node.vector[:3]))
    return None
