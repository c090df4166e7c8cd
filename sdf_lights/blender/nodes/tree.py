# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The node tree, what all its nodes have in common, and how lamps hear of changes."""

from __future__ import annotations

import textwrap
from collections.abc import Callable

import bpy

from ..naming import NODE_TREE
from . import sockets

OUTPUT = "SDFLIGHTS_Node_output"
OBJECT = "SDFLIGHTS_Node_object"
GROUP = "SDFLIGHTS_NodeGroup"

_LETTER = 6.6  # pixels of a node's width for a letter of a problem
_MARGIN = 3  # letters that the icon takes


class SDFLIGHTS_NodeTree(bpy.types.NodeTree):
    """Nodes that make the shape and the emission of a lamp"""

    bl_idname = NODE_TREE
    bl_label = "SDF Lamp"
    bl_icon = "LIGHT_POINT"

    @classmethod
    def valid_socket_type(cls, idname):
        return idname in sockets.OFFERED

    def update(self):
        """Blender calls this after a change of nodes, links or interfaces."""
        if not _registered:
            return
        forget()
        for node in self.nodes:
            if node.bl_idname == GROUP:
                node.match_interface()


# Whether all classes of the add-on are registered. While they come and go, Blender updates the trees that there are; to
# look at their nodes then would bring it down.
_registered = False


def set_registered(registered: bool) -> None:
    """Note whether the classes of nodes are registered."""
    global _registered
    _registered = registered


Sockets = tuple[tuple[str, str, str], ...]


class LampNode:
    """What all nodes have in common: they say in words what is wrong with them.

    ``takes`` and ``gives`` list (identifier, label, type) of the inputs and outputs of a new node. ``tint`` is its
    colour: Blender gives headers of add-ons' nodes no other than that of inputs, but lets nodes have a colour of their
    own.
    """

    # Without annotations: Blender evaluates those of all bases again for each of 200 nodes.
    takes = gives = Sockets()
    tint = None

    @classmethod
    def poll(cls, tree):
        return tree.bl_idname == NODE_TREE

    def init(self, context):
        """What a new node has."""
        if self.tint is not None:
            self.use_custom_color, self.color = True, self.tint
        self.match_interface()

    def match_interface(self):
        """Adds the sockets that a file of an older version lacks."""

    def draw_buttons(self, context, layout):
        self.draw_settings(layout)
        problem = problem_of(self)
        if problem:
            column = layout.column(align=True)
            column.scale_y = 0.8
            for i, line in enumerate(textwrap.wrap(problem, max(16, int(self.width / _LETTER) - _MARGIN))):
                column.label(text=line, icon="NONE" if i else "ERROR")

    def draw_settings(self, layout):
        """Properties of the node that are not sockets."""

    def names(self) -> frozenset[tuple[str, str]]:
        """Kinds and names of data that a text of the node names."""
        return frozenset()

    def things(self) -> list[bpy.types.ID]:
        """Objects and images that the node points at, whose shapes it is made of."""
        return []

    def written(self, writer):
        """Adds the statements of the node; returns values of its outputs by identifier, for ``lines.Writer``."""
        raise NotImplementedError


# -- problems, as the node editor shows them ---------------------------------------------------------------------------

_problems: dict[tuple[int, str], str] | None = None
_finders: list[Callable] = []


def finds_problems(function: Callable) -> Callable:
    """Decorator of a function that is given a tree, and gives ((uid of a tree, name of a node), sentence) for what is
    wrong.

    What reads trees knows this module, so this module is told of it and imports nothing.
    """
    _finders.append(function)
    return function


def forget() -> None:
    """Something has changed: problems are looked for again when they are asked for."""
    global _problems
    _problems = None


def problem_of(node: bpy.types.Node) -> str:
    """What is wrong with a node in one of the trees that use it; an empty string if nothing is."""
    global _problems
    if _problems is None:
        _problems = {}
        for tree in trees():
            if output_of(tree) is not None:
                for (uid, name), problem in (found for find in _finders for found in find(tree)):
                    _problems.setdefault((uid, name), problem)
    return _problems.get((node.id_data.session_uid, node.name), "")


def trees() -> list[bpy.types.NodeTree]:
    """All node trees of SDF lamps in the file."""
    return [tree for tree in bpy.data.node_groups if tree.bl_idname == NODE_TREE]


def output_of(tree: bpy.types.NodeTree) -> bpy.types.Node | None:
    """The first Lamp Output that is not muted."""
    return next((node for node in tree.nodes if node.bl_idname == OUTPUT and not node.mute), None)


# -- lamps that use a tree ---------------------------------------------------------------------------------------------


def within(tree: bpy.types.NodeTree) -> list[bpy.types.NodeTree]:
    """The tree and all groups in it, each once."""
    found, waiting = {}, [tree]
    while waiting:
        tree = waiting.pop()
        if tree is not None and tree.session_uid not in found:
            found[tree.session_uid] = tree
            waiting += [node.node_tree for node in tree.nodes if node.bl_idname == GROUP]
    return list(found.values())


def lamps_with_nodes() -> list[bpy.types.Light]:
    """Lights whose shape comes from a node tree."""
    return [
        light
        for light in bpy.data.lights
        if light.sdf_lamp.use and light.sdf_lamp.source == "NODES" and light.sdf_lamp.nodes is not None
    ]


@bpy.app.handlers.persistent
def _changed(scene, depsgraph):
    """Tells lamps of changes in their trees, and of objects there that moved: Blender only tags what it knows of."""
    changed, moved = set(), set()
    for update in depsgraph.updates:
        found = update.id.original
        if isinstance(found, bpy.types.NodeTree) and found.bl_idname == NODE_TREE:
            changed.add(found.session_uid)
        elif isinstance(found, bpy.types.Object) and update.is_updated_transform:
            moved.add(found.session_uid)
    if not changed and not moved:
        return
    if changed:
        forget()
    for light in lamps_with_nodes():
        used = within(light.sdf_lamp.nodes)
        if (
            changed & {tree.session_uid for tree in used}
            or moved
            and moved
            & {
                node.object.session_uid
                for tree in used
                for node in tree.nodes
                if node.bl_idname == OBJECT and node.object is not None and node.object.data != light
            }
        ):
            light.update_tag()


@bpy.app.handlers.persistent
def _loaded(*_):
    """After opening a file, and after undo: nothing known of the nodes before still holds."""
    forget()
    for tree in trees():
        for node in tree.nodes:
            if isinstance(node, LampNode):
                node.match_interface()


HANDLERS = (
    (bpy.app.handlers.depsgraph_update_post, _changed),
    (bpy.app.handlers.load_post, _loaded),
    (bpy.app.handlers.undo_post, _loaded),
    (bpy.app.handlers.redo_post, _loaded),
)

CLASSES = (SDFLIGHTS_NodeTree,)


def register():
    for handlers, function in HANDLERS:
        handlers.append(function)


def unregister():
    for handlers, function in HANDLERS:
        if function in handlers:
            handlers.remove(function)
    forget()
