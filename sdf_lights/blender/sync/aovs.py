# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Shader AOVs of materials and worlds."""

from __future__ import annotations

import bpy

from ...render.passes import Pass
from .nodes import Reader
from .zones import DEEPEST, Frame, Stack

_MOST_GROUPS = 4096  # nodes of one material, among which AOV Output nodes are searched


def aovs_of(tree: bpy.types.NodeTree, reader: Reader, passes: list[Pass]) -> dict:
    """The inputs of AOV Output nodes, also those in groups, if there is one of the ``passes`` of that name."""
    found: dict = {}
    values = {item.name: len(item.channels) == 1 for item in passes}
    waiting: list[tuple[bpy.types.NodeTree, Stack]] = [(tree, ())] if values else []
    for inner, stack in waiting:
        for node in inner.nodes:
            if node.mute:
                continue
            if node.bl_idname == "ShaderNodeOutputAOV" and node.aov_name in values:
                name, like = ("Value", 0.0) if values[node.aov_name] else ("Color", (0.0, 0.0, 0.0))
                found[node.aov_name] = reader.read(node.inputs[name], like, stack)
            elif node.bl_idname == "ShaderNodeGroup" and node.node_tree is not None:
                if len(stack) <= DEEPEST and len(waiting) < _MOST_GROUPS:
                    waiting.append((node.node_tree, (*stack, Frame(node))))
    return found
