# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Node trees of materials, worlds and lights: whether they are used depends on the version of Blender.

Blender 5.0 removed the switch for materials and worlds. Blender 6.0 removes it for lights, and warns before.
"""

from __future__ import annotations

import contextlib
import warnings

import bpy

Owner = bpy.types.Material | bpy.types.World | bpy.types.Light


def has_switch(owner: Owner) -> bool:
    """Whether this Blender can switch its nodes off."""
    return bpy.app.version < ((6, 0, 0) if isinstance(owner, bpy.types.Light) else (5, 0, 0))


def node_tree_of(owner: Owner) -> bpy.types.NodeTree | None:
    """Its node tree; None if it uses no nodes."""
    if has_switch(owner):
        with _without_deprecation():
            if not owner.use_nodes:
                return None
    return owner.node_tree


def use_nodes(owner: Owner) -> bpy.types.NodeTree:
    """Its node tree, which is switched on."""
    if has_switch(owner):
        with _without_deprecation():
            owner.use_nodes = True
    return owner.node_tree


@contextlib.contextmanager
def _without_deprecation():
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        yield
