# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Places for nodes: columns from left to right, by how many nodes are between a node and the output."""

from __future__ import annotations

import bpy

_GAP = 60.0
_ROW, _HEAD = 22.0, 70.0  # about what a socket and the rest of a node take; Blender measures nodes when it draws them


def arrange(tree: bpy.types.NodeTree) -> None:
    """Puts every node in a column left of all that its outputs lead to, and next to those in height."""
    order = _sources_last(tree)
    column: dict[str, int] = {}
    for node in order:
        column[node.name] = max((column[link.to_node.name] + 1 for s in node.outputs for link in s.links), default=0)
    widest: dict[int, float] = {}
    for node in order:
        widest[column[node.name]] = max(widest.get(column[node.name], 0.0), node.width)
    left, x = {}, 0.0
    for index in sorted(widest):
        x -= widest[index] + _GAP
        left[index] = x
    floor: dict[int, float] = {}
    for node in order:
        targets = [link.to_node.location.y for s in node.outputs for link in s.links]
        wanted = max(targets, default=0.0)
        y = min(wanted, floor.get(column[node.name], wanted))
        node.location = (left[column[node.name]], y)
        floor[column[node.name]] = y - _height(node)


def _sources_last(tree: bpy.types.NodeTree) -> list[bpy.types.Node]:
    """Nodes without circles in between: each after all that it leads to."""
    waiting = {node.name: sum(len(s.links) for s in node.outputs) for node in tree.nodes}
    ready = [node for node in tree.nodes if not waiting[node.name]]
    order = []
    while ready:
        node = ready.pop(0)
        order.append(node)
        for socket in node.inputs:
            for link in sorted(socket.links, key=lambda link: -link.multi_input_sort_id):
                name = link.from_node.name
                waiting[name] -= 1
                if not waiting[name]:
                    ready.append(link.from_node)
    known = {node.name for node in order}
    return [*order, *(node for node in tree.nodes if node.name not in known)]


def _height(node: bpy.types.Node) -> float:
    rows = sum(3 if s.bl_idname.endswith("Vector") and not s.is_linked else 1 for s in node.inputs) + len(node.outputs)
    if node.bl_idname == "SDFLIGHTS_Node_parameter":
        rows += 6
    return _HEAD + _ROW * rows
