# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The Add menu of the node editor, and from lamps to trees and back."""

from __future__ import annotations

import ast

import bpy
import numpy as np

from ...render.errors import RenderError
from ...sdf.functions import DATA_WORDS
from ...sdf.syntax import ExpressionError
from .. import areas, parameters, sources
from .. import emission as lamp_emission
from ..context import LampOperator, light_of
from ..lamp import pattern_of, shape_of
from ..naming import NODE_TREE
from ..properties import OF_DATA, PRIMITIVES
from . import lines, tree_text, writing
from .add_menu import nodes_by_menu
from .groups import SDFLIGHTS_MT_group_add
from .link_search import SDFLIGHTS_OT_link_search

# -- Add menu ----------------------------------------------------------------------------------------------------------


def _menu_class(name: str, title: str, nodes: list[type], inner: list[tuple[str, str]] = ()) -> type:
    def draw(self, context):
        for idname, label in inner:
            self.layout.menu(idname, text=label)
        for node in nodes:
            operator = self.layout.operator("node.add_node", text=node.bl_label)
            operator.type, operator.use_transform = node.bl_idname, True

    return type(name, (bpy.types.Menu,), {"bl_label": title, "bl_idname": name, "draw": draw})


_ORDER = (
    "Input",
    "Output",
    "Shapes",
    DATA_WORDS,
    "Solids from Profiles",
    "Profiles",
    "Combine",
    "Operators",
    "Transforms",
    "Fields",
    "Points",
    "Math",
    "Emission",
)


def _menu_classes() -> tuple[list[type], list[type]]:
    """All menus, and those of the first level."""
    menus, made, top = nodes_by_menu(), [], []
    for title in _ORDER:
        inner = []
        for name in menus:
            if name.startswith(f"{title}/"):
                made.append(_menu_class(f"SDFLIGHTS_MT_node_{len(made)}", name.partition("/")[2], menus[name]))
                inner.append((made[-1].bl_idname, made[-1].bl_label))
        made.append(_menu_class(f"SDFLIGHTS_MT_node_{len(made)}", title, menus.get(title, []), inner))
        top.append(made[-1])
    return made, top


_MENUS, _TOP = _menu_classes()


def draw_menu(self, context):
    """Entries in Add of the node editor."""
    if context.space_data.tree_type != NODE_TREE or not context.space_data.edit_tree:
        return
    layout = self.layout
    for menu in _TOP:
        layout.menu(menu.bl_idname)
    layout.menu(SDFLIGHTS_MT_group_add.bl_idname)
    layout.separator()
    layout.operator_context = "INVOKE_REGION_WIN"
    layout.operator(SDFLIGHTS_OT_link_search.bl_idname, text="Linked to Active…")
    layout.separator()
    for kind, label in (("NodeFrame", "Frame"), ("NodeReroute", "Reroute")):
        operator = layout.operator("node.add_node", text=label)
        operator.type, operator.use_transform = kind, True


# -- lamps and trees ---------------------------------------------------------------------------------------------------


def expression_of(light: bpy.types.Light) -> str:
    """The lamp's shape as an expression, whatever its source. Raises RenderError."""
    lamp = light.sdf_lamp
    if lamp.source == "EXPRESSION":
        return parameters.text_of(lamp)
    if lamp.source == "NODES":
        return tree_text.text_of(lamp.nodes, parameters.values(lamp), None, lamp)
    if lamp.source in OF_DATA:
        shape_of(lamp)  # says what is wrong, if something is
        name, subject, settings = sources.builtin_call_of(lamp)
        shown = {key: ast.Constant(v) if isinstance(v, str) else tree_text.number(v) for key, v in settings.items()}
        return tree_text.text_of_call(lines.word(name, ast.Constant(subject), **shown))
    name = lamp.shape.lower()
    group, named = getattr(lamp, name), {}
    for about in PRIMITIVES[name].fields():
        value = getattr(group, about.name)
        shown = [
            tree_text.number(v if about.unit != "ANGLE" else np.degrees(v))
            for v in (value if about.size == 3 else (value,))
        ]
        named[about.name] = ast.Tuple(shown, ast.Load()) if about.size == 3 else shown[0]
    return tree_text.text_of_call(lines.word(name, **named))


def emission_text_of(light: bpy.types.Light) -> str:
    """The lamp's emission as text; empty where it is even. Raises RenderError."""
    lamp = light.sdf_lamp
    if pattern_of(lamp) is None:
        return ""
    if parameters.emission_is_in_nodes(lamp):
        return tree_text.emission_text_of(lamp.nodes, parameters.values(lamp), None, lamp)
    return lamp_emission.text_of(lamp.emission)


def to_nodes(light: bpy.types.Light) -> bpy.types.NodeTree:
    """Gives the lamp a node tree of the shape and emission it has; returns that. Raises RenderError."""
    lamp = light.sdf_lamp
    shape_of(lamp)  # says what is wrong, if something is
    emission_text = emission_text_of(light)
    try:
        tree = writing.tree_of(light.name, expression_of(light), lamp)
        renamed = writing.add_emission(tree, emission_text, lamp) if emission_text else {}
    except ExpressionError as error:
        raise RenderError(f"In its expression: {error}") from error
    values = {new: light.get(f"{parameters.PREFIX}{lamp_emission.PREFIX}{old}") for old, new in renamed.items()}
    lamp.nodes, lamp.source, lamp.emission.source = tree, "NODES", "UNIFORM"
    for name, value in values.items():
        if value is not None:
            light[parameters.PREFIX + name] = value
    return tree


class SDFLIGHTS_OT_nodes_new(LampOperator, bpy.types.Operator):
    """Make a node tree of the shape that the lamp has"""

    bl_idname = "sdf_lights.nodes_new"
    bl_label = "Convert to Nodes"

    def execute(self, context):
        light = light_of(context)
        try:
            if light.sdf_lamp.source == "NODES" and light.sdf_lamp.nodes is None:
                light.sdf_lamp.source = "PRIMITIVE"
            tree = to_nodes(light)
        except RenderError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        light.sdf_lamp.use = True
        show(context, tree)
        return {"FINISHED"}


class SDFLIGHTS_OT_nodes_to_expression(LampOperator, bpy.types.Operator):
    """Write the lamp's nodes, or its primitive, as an expression in a new text block, and its emission in another"""

    bl_idname = "sdf_lights.nodes_to_expression"
    bl_label = "Convert to Expression"

    def execute(self, context):
        light = light_of(context)
        try:
            written, glow = expression_of(light), emission_text_of(light)
            in_nodes = parameters.emission_is_in_nodes(light.sdf_lamp)
        except RenderError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        light.sdf_lamp.text = parameters.new_text(light.name, written)
        light.sdf_lamp.source = "EXPRESSION"
        if glow and in_nodes:
            settings = light.sdf_lamp.emission
            settings.text = parameters.new_text(f"{light.name} Emission", glow)
            settings.source = lamp_emission.EXPRESSION
        return {"FINISHED"}


class SDFLIGHTS_OT_nodes_show(LampOperator, bpy.types.Operator):
    """Show the lamp's node tree in a node editor. Opens an editor if none is open"""

    bl_idname = "sdf_lights.nodes_show"
    bl_label = "Edit Nodes"

    def execute(self, context):
        tree = light_of(context).sdf_lamp.nodes
        if tree is None:
            self.report({"INFO"}, "The lamp has no node tree: make one with New.")
            return {"CANCELLED"}
        if not show(context, tree):
            area = areas.opened(context, NODE_TREE)
            if area is None:
                self.report({"INFO"}, "There is no window for a node editor.")
            else:
                area.spaces.active.node_tree = tree
        return {"FINISHED"}


def show(context, tree: bpy.types.NodeTree) -> bool:
    """Shows the tree in a node editor that is open and has no pin, one of this type before others."""

    def fits(area) -> int:
        space = area.spaces.active
        return 0 if space.pin else 1 + (space.tree_type == NODE_TREE)

    area = areas.area_of(context, "NODE_EDITOR", fits)
    if area is None:
        return False
    area.spaces.active.tree_type = NODE_TREE
    area.spaces.active.node_tree = tree
    return True


CLASSES = (*_MENUS, SDFLIGHTS_OT_nodes_new, SDFLIGHTS_OT_nodes_to_expression, SDFLIGHTS_OT_nodes_show)


def register():
    bpy.types.NODE_MT_add.append(draw_menu)


def unregister():
    bpy.types.NODE_MT_add.remove(draw_menu)
