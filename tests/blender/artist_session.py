# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What test_artist runs in a Blender with a window: an artist adds a lamp, edits it, builds a node tree,
mends a mistake."""

import pathlib
import sys

import bpy

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(REPOSITORY), str(REPOSITORY / "scripts")]

from window import ARGUMENTS, areas, inside, move, override, picture, press, region_of, report, run, typed  # noqa: E402

import sdf_lights.blender as addon  # noqa: E402  (found on the path set above)
from sdf_lights.blender.lamp import shape_of  # noqa: E402
from sdf_lights.blender.nodes import reading  # noqa: E402

PICTURES = ARGUMENTS[1] if len(ARGUMENTS) > 1 else None


def lamp():
    return bpy.context.object.data.sdf_lamp


def tree():
    return lamp().nodes


def steps():
    addon.register()
    for obj in list(bpy.data.objects):
        bpy.data.objects.remove(obj)
    bpy.context.scene.render.engine = "SDF_LIGHTS"
    bpy.ops.ed.undo_push(message="An empty scene")
    view = areas("VIEW_3D")[0]
    view.spaces.active.show_region_ui = True
    yield

    # Shift-A in the 3D view, and the name of a shape.
    place = move(inside(view, 0.4))
    press(place, "A", shift=True)
    yield
    picture(PICTURES, "add_menu")
    typed(place, "box frame")
    yield
    typed(place, "\n")
    yield
    yield
    report["added"] = [obj.name for obj in bpy.context.scene.objects]
    if not report["added"]:  # the search of menus differs between versions of Blender
        with override(view):
            bpy.ops.sdf_lights.lamp_add("INVOKE_DEFAULT", shape="BOX_FRAME")
    yield
    report["shape"] = lamp().shape

    # Undo and redo by keys.
    place = move(inside(view, 0.4))
    press(place, "Z", ctrl=True)
    yield
    yield
    report["undone"] = len(bpy.context.scene.objects)
    press(move(inside(view, 0.4)), "Z", ctrl=True, shift=True)
    yield
    yield
    report["redone"] = [obj.data.sdf_lamp.shape for obj in bpy.context.scene.objects]

    region_of(view, "UI").active_panel_category = "SDF Lights"
    bpy.context.object.data.sdf_lamp.box_frame.thickness = 0.08
    yield
    picture(PICTURES, "sidebar")
    yield

    # An expression with a mistake in it, mended.
    text = bpy.data.texts.new("Expression")
    text.write("size = slider(0.5, 0.1, 2)  # half of the size\nbox(size) - spere(1.3 * size)\n")
    lamp().source, lamp().text = "EXPRESSION", text
    areas("PROPERTIES")[0].type = "TEXT_EDITOR"
    yield
    with override(view):
        bpy.ops.sdf_lights.expression_show()
    report["line"] = text.current_line_index, text.current_character
    yield
    picture(PICTURES, "mistake")
    place = move(inside(areas("TEXT_EDITOR")[0], 0.4))
    text.cursor_set(1, character=14)
    typed(place, "h")
    yield
    yield
    report["mended"] = text.as_string()
    report["sliders"] = [key for key in bpy.context.object.data.keys() if key.startswith("sdf_size")]
    report["formula"] = type(shape_of(lamp())).__name__

    # To nodes, and one more node by Shift-A and search.
    with override(view):
        bpy.ops.screen.area_split(direction="HORIZONTAL", factor=0.55)
    yield
    editor = areas("VIEW_3D")[0]
    editor.ui_type = "SDFLIGHTS_NodeTree"
    editor.spaces.active.show_region_ui = False
    yield
    with override(areas("VIEW_3D")[0]):
        bpy.ops.sdf_lights.nodes_new()
    yield
    report["nodes"] = sorted(node.bl_label for node in tree().nodes)
    report["shown"] = editor.spaces.active.node_tree == tree()
    with override(editor):
        bpy.ops.node.view_all()
    yield
    yield
    picture(PICTURES, "nodes")
    place = move(inside(editor, 0.5, 0.2))
    press(place, "A", shift=True)
    yield
    picture(PICTURES, "nodes_add")
    typed(place, "torus knot")
    yield
    typed(place, "\n")
    yield
    press(place, "LEFTMOUSE")
    yield
    report["added node"] = [node.bl_label for node in tree().nodes if node.bl_label == "Torus Knot"]

    # A wrong link, and what the node says to it.
    ball = next(node for node in tree().nodes if node.bl_idname == "SDFLIGHTS_Node_sphere")
    vector = tree().nodes.new("SDFLIGHTS_Node_vector")
    vector.location = ball.location.x - 60.0, ball.location.y - 140.0
    tree().links.new(vector.outputs[0], ball.inputs[0])
    yield
    yield
    with override(editor):
        bpy.ops.node.view_all()
    report["mistake"] = [problem for _, problem in reading.problems_of(tree())]
    yield
    yield
    picture(PICTURES, "nodes_mistake")
    tree().nodes.remove(vector)
    yield
    report["groups"] = _grouped(editor)
    yield
    report["after"] = [problem for _, problem in reading.problems_of(tree())]
    addon.unregister()
    yield
    report["left"] = [name for name in dir(bpy.types) if name.startswith("SDFLIGHTS")]


def _grouped(editor):
    for node in tree().nodes:
        node.select = node.bl_idname in ("SDFLIGHTS_Node_sphere", "SDFLIGHTS_Node_box")
    with override(editor):
        bpy.ops.sdf_lights.group_make()
        made = tree().nodes.active
        bpy.ops.sdf_lights.group_edit()
        inside = editor.spaces.active.edit_tree == made.node_tree
        made.select = False
        bpy.ops.sdf_lights.group_edit()
        outside = editor.spaces.active.edit_tree == tree()
    return [made.bl_idname, len(made.outputs), inside, outside]


if __name__ == "__main__":
    run(steps())
