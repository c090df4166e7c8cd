# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A link that is dropped into empty space asks which node to add there, as in Blender's own trees.

Blender does this in C, and for no tree of an add-on (``should_create_drag_link_search_menu``). Here a modal operator
that lets every event through stands above Blender's ``node.link`` and sees where the button is let go. Python does not
know where sockets are, but ``node.select`` finds them: afterwards it is asked for the one that the drag began at.
"""

from __future__ import annotations

from typing import NamedTuple

import bpy

from . import sockets
from .add_menu import node_classes
from .groups import editor_of
from .tree import GROUP, trees, within

_REST = 0.01  # seconds until the drag has surely ended


class _Choice(NamedTuple):
    """A node to add, and the socket of it to link, of type ``carries``. ``group`` is the name of a group of nodes."""

    node: str
    label: str
    identifier: str
    carries: str
    group: str = ""

    @property
    def key(self) -> str:
        return f"{self.node}/{self.group}/{self.identifier}"


def choices(socket: bpy.types.NodeSocket) -> list[_Choice]:
    """What a link from a socket can lead to: inputs that take what it carries, or outputs that carry what it takes.

    Those of the very same kind are first.
    """
    wanted, found = sockets.kind_of(socket), []
    if not wanted:
        return []

    def label(node: str, name: str) -> str:
        return f"{node} \N{BLACK RIGHT-POINTING SMALL TRIANGLE} {name}"

    def fits(kind: str) -> bool:
        if socket.is_output:
            return sockets.kind_takes(kind, sockets.carried_by(wanted))
        return sockets.kind_takes(wanted, sockets.carried_by(kind))

    for node in node_classes():
        for identifier, name, kind in node.takes if socket.is_output else node.gives:
            if fits(kind):
                found.append(_Choice(node.bl_idname, label(node.bl_label, name), identifier, kind))
    for group in trees():
        if socket.id_data not in within(group):
            for item in group.interface.items_tree:
                side = "INPUT" if socket.is_output else "OUTPUT"
                kind = sockets.kind_in_group(item.socket_type) if item.item_type == "SOCKET" else ""
                if kind and item.in_out == side and fits(kind):
                    found.append(_Choice(GROUP, label(group.name, item.name), item.identifier, kind, group.name))
    found.sort(key=lambda choice: (choice.carries != wanted, choice.label))
    return found


def add_linked(socket: bpy.types.NodeSocket, choice: _Choice, location: tuple[float, float]) -> bpy.types.Node:
    """Adds a node, and links it to the socket."""
    tree = socket.id_data
    node = tree.nodes.new(choice.node)
    if choice.group:
        node.node_tree = bpy.data.node_groups[choice.group]
        node.match_interface()
    node.location = location if socket.is_output else (location[0] - node.width, location[1])
    other = next(s for s in (node.inputs if socket.is_output else node.outputs) if s.identifier == choice.identifier)
    tree.links.new(*((socket, other) if socket.is_output else (other, socket)))
    for found in tree.nodes:
        found.select = False
    node.select, tree.nodes.active = True, node
    return node


_shown: list[tuple[str, str, str]] = []  # Blender keeps no reference to the strings of a list of choices


def _items(self, context) -> list[tuple[str, str, str]]:
    return _shown


class SDFLIGHTS_OT_link_search(bpy.types.Operator):
    """Add a node that is linked to a socket: by default, to the first output of the active node"""

    bl_idname = "sdf_lights.link_search"
    bl_label = "Add Linked Node"
    bl_options = {"REGISTER", "UNDO"}
    bl_property = "choice"

    node: bpy.props.StringProperty(name="Node", description="Node that the link is from", options={"SKIP_SAVE"})
    socket: bpy.props.StringProperty(name="Socket", description="Identifier of its socket", options={"SKIP_SAVE"})
    from_input: bpy.props.BoolProperty(name="From Input", description="The socket is an input", options={"SKIP_SAVE"})
    location: bpy.props.FloatVectorProperty(
        name="Location", description="Place of the new node", size=2, options={"SKIP_SAVE"}
    )
    choice: bpy.props.EnumProperty(name="Choice", description="Node and socket to link to", items=_items)

    @classmethod
    def poll(cls, context):
        space = editor_of(context)
        return space is not None and space.edit_tree.is_editable

    def _found(self, context) -> bpy.types.NodeSocket | None:
        nodes = editor_of(context).edit_tree.nodes
        node = nodes.get(self.node) if self.node else nodes.active
        if node is None:
            return None
        there = [s for s in (node.inputs if self.from_input else node.outputs) if s.enabled and not s.hide]
        return next((s for s in there if s.identifier == self.socket), None) if self.socket else next(iter(there), None)

    def invoke(self, context, event):
        socket = self._found(context)
        if socket is None:
            self.report({"WARNING"}, "The active node has no output to link: select another one.")
            return {"CANCELLED"}
        if not self.properties.is_property_set("location"):
            self.location = socket.node.location.x + socket.node.width + 40.0, socket.node.location.y
        _shown[:] = [(choice.key, choice.label, "") for choice in choices(socket)]
        if not _shown:
            self.report({"INFO"}, "No node takes this link.")
            return {"CANCELLED"}
        context.window_manager.invoke_search_popup(self)
        return {"RUNNING_MODAL"}

    def execute(self, context):
        socket = self._found(context)
        chosen = next((c for c in choices(socket) if c.key == self.choice), None) if socket is not None else None
        if chosen is None:
            return {"CANCELLED"}
        add_linked(socket, chosen, tuple(self.location))
        if context.region is not None and context.region.type == "WINDOW":
            bpy.ops.node.translate_attach_remove_on_cancel("INVOKE_DEFAULT")
        return {"FINISHED"}


def socket_at(tree: bpy.types.NodeTree, place: tuple[int, int]) -> bpy.types.NodeSocket | None:
    """The socket at a place of the region, where there is one."""
    found = [(socket, socket.select) for node in tree.nodes for socket in (*node.inputs, *node.outputs)]
    bpy.ops.node.select(location=place, socket_select=True, toggle=True)
    hit = next((socket for socket, before in found if socket.select != before), None)
    if hit is not None:
        bpy.ops.node.select(location=place, socket_select=True, toggle=True)
    return hit


def _links(tree: bpy.types.NodeTree) -> set[tuple]:
    return {
        (link.from_node.name, link.from_socket.identifier, link.to_node.name, link.to_socket.identifier)
        for link in tree.links
    }


class SDFLIGHTS_OT_link_drag(bpy.types.Operator):
    """Watch whether a link is dragged"""

    bl_idname = "sdf_lights.link_drag"
    bl_label = "Drag Link"
    bl_options = {"INTERNAL"}

    @classmethod
    def poll(cls, context):
        return SDFLIGHTS_OT_link_search.poll(context)

    def invoke(self, context, event):
        before = _links(editor_of(context).edit_tree)
        place = dict(window=context.window, area=context.area, region=context.region)

        def watch():
            with bpy.context.temp_override(**place):
                if _drag_of(bpy.context) is not None and SDFLIGHTS_OT_link_watch.poll(bpy.context):
                    SDFLIGHTS_OT_link_watch.before = before
                    bpy.ops.sdf_lights.link_watch("INVOKE_DEFAULT")

        # Not before Blender's own operator has begun, for which this one leaves the event: who comes last stands above.
        bpy.app.timers.register(watch, first_interval=0.0)
        return {"PASS_THROUGH"}


def _drag_of(context) -> bpy.types.Operator | None:
    """The drag of a link that is going on."""
    return next((operator for operator in context.window.modal_operators if operator.bl_idname == "NODE_OT_link"), None)


class SDFLIGHTS_OT_link_watch(bpy.types.Operator):
    """Ask for the node to add where a link is dropped"""

    bl_idname = "sdf_lights.link_watch"
    bl_label = "Watch Link"
    bl_options = {"INTERNAL"}

    before: set[tuple] = set()  # links that there were

    @classmethod
    def poll(cls, context):
        return SDFLIGHTS_OT_link_search.poll(context)

    def invoke(self, context, event):
        self._start = tuple(_drag_of(context).properties.drag_start)  # in the view
        self._drop = self._timer = None
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        if self._drop is None:
            if event.type in {"ESC", "RIGHTMOUSE"}:
                return {"FINISHED", "PASS_THROUGH"}
            if event.type == "LEFTMOUSE" and event.value == "RELEASE":
                self._drop = context.region.view2d.region_to_view(event.mouse_region_x, event.mouse_region_y)
                self._timer = context.window_manager.event_timer_add(_REST, window=context.window)
            return {"PASS_THROUGH"}
        context.window_manager.event_timer_remove(self._timer)
        tree = editor_of(context).edit_tree
        if _links(tree) == self.before:
            socket = socket_at(tree, context.region.view2d.view_to_region(*self._start, clip=False))
            if socket is not None:
                bpy.ops.sdf_lights.link_search(
                    "INVOKE_DEFAULT",
                    node=socket.node.name,
                    socket=socket.identifier,
                    from_input=not socket.is_output,
                    location=self._drop,
                )
        return {"FINISHED"}


CLASSES = (SDFLIGHTS_OT_link_search, SDFLIGHTS_OT_link_drag, SDFLIGHTS_OT_link_watch)

_keymaps: list[tuple] = []


def register():
    keys = bpy.context.window_manager.keyconfigs.addon
    if keys is None:  # without a window
        return
    keymap = keys.keymaps.new(name="Node Editor", space_type="NODE_EDITOR")
    item = keymap.keymap_items.new(SDFLIGHTS_OT_link_drag.bl_idname, "LEFTMOUSE", "CLICK_DRAG")
    _keymaps.append((keymap, item))


def unregister():
    for keymap, item in _keymaps:
        keymap.keymap_items.remove(item)
    _keymaps.clear()
    _shown.clear()
