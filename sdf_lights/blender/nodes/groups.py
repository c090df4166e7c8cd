# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Node groups. Blender leaves to a tree of one's own to match a group's sockets, and to make and edit groups."""

from __future__ import annotations

import bpy

from ..naming import NODE_TREE
from . import sockets
from .lines import DEEPEST_GROUP, Broken, group_output
from .tree import GROUP, OUTPUT, LampNode, within


class SDFLIGHTS_NodeGroup(LampNode, bpy.types.NodeCustomGroup):
    """Nodes that are used as one"""

    bl_idname = GROUP
    bl_label = "Group"
    bl_width_default = 180.0

    @classmethod
    def poll(cls, tree):
        return tree.bl_idname == NODE_TREE

    def draw_settings(self, layout):
        layout.template_ID(self, "node_tree", new=SDFLIGHTS_OT_group_new.bl_idname)

    def draw_label(self):
        return self.node_tree.name if self.node_tree is not None else self.bl_label

    def match_interface(self):
        """Gives the node the sockets of the group's interface; links and values of those that stay are kept."""
        items = (
            [item for item in self.node_tree.interface.items_tree if item.item_type == "SOCKET"]
            if self.node_tree is not None
            else []
        )
        for found, side in ((self.inputs, "INPUT"), (self.outputs, "OUTPUT")):
            wanted = [item for item in items if item.in_out == side]
            kinds = {item.identifier: item.socket_type for item in wanted}
            for socket in list(found):
                if kinds.get(socket.identifier) != socket.bl_idname.removesuffix("Interface"):
                    found.remove(socket)
            for index, item in enumerate(wanted):
                at = next((i for i, socket in enumerate(found) if socket.identifier == item.identifier), None)
                if at is None:
                    socket = found.new(item.socket_type, item.name, identifier=item.identifier)
                    if hasattr(item, "default_value") and hasattr(socket, "default_value"):
                        socket.default_value = item.default_value
                    at = len(found) - 1
                if found[at].name != item.name:
                    found[at].name = item.name
                if at != index:
                    found.move(at, index)

    def written(self, writer):
        if self.node_tree is None:
            raise Broken("No group is chosen: choose one")
        if self.id_data in within(self.node_tree):
            raise Broken("The group contains itself: choose another one")
        if not any(node.bl_idname == "NodeGroupOutput" for node in self.node_tree.nodes):
            raise Broken("The group has no Group Output: add one in it")
        raise Broken(f"Groups are nested too deeply: use at most {DEEPEST_GROUP}")


# -- operators ---------------------------------------------------------------------------------------------------------


def editor_of(context) -> bpy.types.SpaceNodeEditor | None:
    """The node editor of the context, if it shows a tree of this kind."""
    space = context.space_data
    if space is not None and space.type == "NODE_EDITOR" and space.tree_type == NODE_TREE and space.edit_tree:
        return space
    return None


class _GroupOperator:
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        return editor_of(context) is not None and editor_of(context).edit_tree.is_editable


def _active_group(context):
    node = editor_of(context).edit_tree.nodes.active
    return node if node is not None and node.bl_idname == GROUP and node.select else None


class SDFLIGHTS_OT_group_new(bpy.types.Operator):
    """Make a new group of nodes, for the active group node"""

    bl_idname = "sdf_lights.group_new"
    bl_label = "New Group"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        return editor_of(context) is not None

    def execute(self, context):
        node = getattr(context, "node", None) or _active_group(context)
        if node is None:
            return {"CANCELLED"}
        node.node_tree = empty_group("Group")
        node.match_interface()
        return {"FINISHED"}


def empty_group(name: str) -> bpy.types.NodeTree:
    """A group with a Shape output."""
    tree = bpy.data.node_groups.new(name, NODE_TREE)
    tree.interface.new_socket("Shape", in_out="OUTPUT", socket_type=sockets.SHAPE)
    tree.nodes.new("NodeGroupInput").location = (-200.0, 0.0)
    tree.nodes.new("NodeGroupOutput").location = (200.0, 0.0)
    return tree


def copy_nodes(nodes, tree: bpy.types.NodeTree) -> dict[str, bpy.types.Node]:
    """Copies of nodes in another tree by the name of the original, with the links between them."""
    made = {}
    for node in nodes:
        copy = tree.nodes.new(node.bl_idname)
        made[node.name] = copy
        for prop in node.bl_rna.properties:
            if (
                not prop.is_readonly
                and prop.identifier not in {"parent", "select", "name"}
                and (hasattr(copy, prop.identifier))
            ):
                setattr(copy, prop.identifier, getattr(node, prop.identifier))
        if hasattr(copy, "match_interface"):
            copy.match_interface()
        for old, new in zip(node.inputs, copy.inputs):
            if hasattr(old, "default_value") and old.bl_idname == new.bl_idname:
                new.default_value = old.default_value
    for node in nodes:
        if node.parent is not None and node.parent.name in made:
            made[node.name].parent = made[node.parent.name]
        for socket in node.inputs:
            for link in ordered(socket):
                if link.from_node.name in made:
                    tree.links.new(
                        output(made[link.from_node.name], link.from_socket),
                        by_identifier(made[node.name].inputs, socket),
                    )
    return made


def ordered(socket) -> list:
    """Links of an input in the order in which they were made."""
    links = list(socket.links)
    return sorted(links, key=lambda link: link.multi_input_sort_id) if socket.is_multi_input else links


def by_identifier(found, socket):
    """The one of the sockets that has the identifier of ``socket``."""
    return next(other for other in found if other.identifier == socket.identifier)


def output(node, socket):
    """The output of a node that has the identifier of ``socket``."""
    return by_identifier(node.outputs, socket)


class SDFLIGHTS_OT_group_make(_GroupOperator, bpy.types.Operator):
    """Make a group of the selected nodes"""

    bl_idname = "sdf_lights.group_make"
    bl_label = "Make Group"

    def execute(self, context):
        tree = editor_of(context).edit_tree
        chosen = [
            node
            for node in tree.nodes
            if node.select and node.bl_idname not in (OUTPUT, "NodeGroupInput", "NodeGroupOutput")
        ]
        if not chosen:
            self.report({"WARNING"}, "No nodes are selected that can be in a group: select some.")
            return {"CANCELLED"}
        make_group(tree, chosen)
        return {"FINISHED"}


def make_group(tree: bpy.types.NodeTree, chosen: list) -> bpy.types.Node:
    """Puts nodes into a group of their own; returns the group node in their place."""
    group = bpy.data.node_groups.new("Group", NODE_TREE)
    names = {node.name for node in chosen}
    made = copy_nodes(chosen, group)
    low, high = (limit(node.location.x for node in chosen) for limit in (min, max))
    middle = sum(node.location.y for node in chosen) / len(chosen)
    start, end = group.nodes.new("NodeGroupInput"), group.nodes.new("NodeGroupOutput")
    start.location, end.location = (low - 220.0, middle), (high + 220.0, middle)

    joined = []  # of outer sockets with a group socket: (outer, identifier, whether it is an input of the group)
    known: dict[tuple, str] = {}
    for node in chosen:
        for socket in node.inputs:
            for link in ordered(socket):
                if link.from_node.name in names:
                    continue
                key = (link.from_node.name, link.from_socket.identifier)
                if key not in known:
                    item = group.interface.new_socket(socket.name, in_out="INPUT", socket_type=sockets.in_group(socket))
                    known[key] = item.identifier
                    joined.append((link.from_socket, item.identifier, True))
                inner = next(s for s in start.outputs if s.identifier == known[key])
                group.links.new(inner, by_identifier(made[node.name].inputs, socket))
    for node in chosen:
        for socket in node.outputs:
            outer = [link.to_socket for link in socket.links if link.to_node.name not in names]
            if outer:
                item = group.interface.new_socket(socket.name, in_out="OUTPUT", socket_type=sockets.in_group(socket))
                group.links.new(
                    output(made[node.name], socket), next(s for s in end.inputs if s.identifier == item.identifier)
                )
                joined += [(to, item.identifier, False) for to in outer]
    node = tree.nodes.new(GROUP)
    node.node_tree = group
    node.match_interface()
    node.location = ((low + high) / 2.0, middle)
    for outer, identifier, is_input in joined:
        if is_input:
            tree.links.new(outer, next(s for s in node.inputs if s.identifier == identifier))
        else:
            tree.links.new(next(s for s in node.outputs if s.identifier == identifier), outer)
    for other in chosen:
        tree.nodes.remove(other)
    for other in tree.nodes:
        other.select = False
    node.select, tree.nodes.active = True, node
    return node


class SDFLIGHTS_OT_group_ungroup(_GroupOperator, bpy.types.Operator):
    """Put the nodes of the active group into this tree, in place of the group node"""

    bl_idname = "sdf_lights.group_ungroup"
    bl_label = "Ungroup"

    def execute(self, context):
        node = _active_group(context)
        if node is None or node.node_tree is None:
            self.report({"WARNING"}, "The active node is not a group: select one.")
            return {"CANCELLED"}
        ungroup(node)
        return {"FINISHED"}


def ungroup(node: bpy.types.Node) -> None:
    """Puts copies of the nodes of a group in the place of its node."""
    tree, group = node.id_data, node.node_tree
    inner = [n for n in group.nodes if n.bl_idname not in ("NodeGroupInput", "NodeGroupOutput")]
    made = copy_nodes(inner, tree)
    for copy in made.values():
        if copy.parent is None:
            copy.location = copy.location + node.location
    end = group_output(group)
    for link in list(group.links):
        if link.from_node.bl_idname == "NodeGroupInput" and link.to_node.name in made:
            outside = next((s for s in node.inputs if s.identifier == link.from_socket.identifier), None)
            target = by_identifier(made[link.to_node.name].inputs, link.to_socket)
            for before in ordered(outside) if outside is not None else ():
                tree.links.new(before.from_socket, target)
            if outside is not None and not outside.is_linked and hasattr(outside, "default_value"):
                _keep_value(target, outside.default_value)
    for socket in node.outputs:
        inside = next((s for s in end.inputs if s.identifier == socket.identifier), None) if end else None
        if inside is not None and inside.is_linked and inside.links[0].from_node.name in made:
            source = output(made[inside.links[0].from_node.name], inside.links[0].from_socket)
            for link in list(socket.links):
                tree.links.new(source, link.to_socket)
    tree.nodes.remove(node)


def _keep_value(socket, value) -> None:
    if sockets.held_by_node(socket):
        if socket.bl_idname == sockets.COLOR:
            value = value[:3]  # Blender's own have alpha
        setattr(socket.node, sockets.property_of(socket.identifier), value)
    elif hasattr(socket, "default_value"):
        socket.default_value = value


class SDFLIGHTS_OT_group_edit(bpy.types.Operator):
    """Go into the active group, or out of the one that is being edited"""

    bl_idname = "sdf_lights.group_edit"
    bl_label = "Edit Group"

    @classmethod
    def poll(cls, context):
        return editor_of(context) is not None

    def execute(self, context):
        space, node = editor_of(context), _active_group(context)
        if node is not None and node.node_tree is not None:
            space.path.append(node.node_tree, node=node)
        elif len(space.path) > 1:
            space.path.pop()
        else:
            return {"PASS_THROUGH"}
        return {"FINISHED"}


class SDFLIGHTS_MT_group_add(bpy.types.Menu):
    """Node groups of the file."""

    bl_label = "Group"
    bl_idname = "SDFLIGHTS_MT_group_add"

    def draw(self, context):
        layout, space = self.layout, editor_of(context)
        layout.operator(SDFLIGHTS_OT_group_make.bl_idname)
        layout.operator(SDFLIGHTS_OT_group_ungroup.bl_idname)
        if len(space.path) > 1:
            layout.separator()
            for label, kind in (("Group Input", "NodeGroupInput"), ("Group Output", "NodeGroupOutput")):
                _add(layout, kind, label)
        layout.separator()
        for tree in bpy.data.node_groups:
            if tree.bl_idname == NODE_TREE and len(tree.interface.items_tree) and (space.edit_tree not in within(tree)):
                operator = _add(layout, GROUP, tree.name)
                setting = operator.settings.add()
                setting.name, setting.value = "node_tree", f"bpy.data.node_groups[{tree.name!r}]"


def _add(layout, kind: str, label: str):
    operator = layout.operator("node.add_node", text=label)
    operator.type, operator.use_transform = kind, True
    return operator


_KEYS = (
    (SDFLIGHTS_OT_group_make, "G", dict(ctrl=True)),
    (SDFLIGHTS_OT_group_ungroup, "G", dict(ctrl=True, alt=True)),
    (SDFLIGHTS_OT_group_edit, "TAB", {}),
)
_keymaps: list[tuple] = []

CLASSES = (
    SDFLIGHTS_NodeGroup,
    SDFLIGHTS_OT_group_new,
    SDFLIGHTS_OT_group_make,
    SDFLIGHTS_OT_group_ungroup,
    SDFLIGHTS_OT_group_edit,
    SDFLIGHTS_MT_group_add,
)


def register():
    keys = bpy.context.window_manager.keyconfigs.addon
    if keys is None:  # without a window
        return
    keymap = keys.keymaps.new(name="Node Editor", space_type="NODE_EDITOR")
    for kind, key, modifiers in _KEYS:
        _keymaps.append((keymap, keymap.keymap_items.new(kind.bl_idname, key, "PRESS", **modifiers)))


def unregister():
    for keymap, item in _keymaps:
        keymap.keymap_items.remove(item)
    _keymaps.clear()
