# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What test_artist_nodes runs in a Blender with a window: an artist in the node editor."""

import pathlib
import sys

import bpy
import numpy as np

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(REPOSITORY), str(REPOSITORY / "scripts")]

from window import ARGUMENTS, areas, drag, event, inside, move, override, picture, press, region_of, report, run, typed  # noqa: E402

import sdf_lights.blender as addon  # noqa: E402  (found on the path set above)
from sdf_lights.blender.lamp import pattern_of, shape_of  # noqa: E402
from sdf_lights.blender.nodes import link_search, reading  # noqa: E402

PICTURES = ARGUMENTS[1] if len(ARGUMENTS) > 1 else None


def lamp():
    return bpy.data.objects["SDF Lamp"].data.sdf_lamp


def problems(tree):
    return [problem for _, problem in reading.problems_of(tree)]


def radius():
    """How far the shape of the lamp reaches along x."""
    return round(float(shape_of(lamp()).bounds()[1][0]), 4)


def socket_place(area, socket):
    """Where a socket of a node is in the window; found as Blender does, because Python does not know."""
    node, region = socket.node, region_of(area)
    scale = bpy.context.preferences.system.ui_scale
    x = node.location.x + (node.width if socket.is_output else 0.0)
    for down in range(-10, 600, 4):
        place = region.view2d.view_to_region(x * scale, (node.location.y - down) * scale, clip=False)
        with override(area):
            hit = link_search.socket_at(socket.id_data, place)
        if hit == socket:
            return region.x + place[0], region.y + place[1] - 6
    raise LookupError(f"{node.name} {socket.name}")


def select(tree, *nodes):
    for node in tree.nodes:
        node.select = node in nodes
    tree.nodes.active = nodes[-1]


def input_of(node, identifier):
    return next(s for s in node.inputs if s.identifier == identifier)


def steps():
    addon.register()
    for name in ("Cube", "Light"):
        bpy.data.objects.remove(bpy.data.objects[name])
    bpy.context.scene.render.engine = "SDF_LIGHTS"
    view = areas("VIEW_3D")[0]
    with override(view):
        bpy.ops.screen.area_split(direction="HORIZONTAL", factor=0.68)
    yield
    editor = areas("VIEW_3D")[0]
    editor.ui_type = "SDFLIGHTS_NodeTree"
    editor.spaces.active.show_region_ui = False
    view = areas("VIEW_3D")[0]
    yield
    with override(view):
        bpy.ops.sdf_lights.lamp_add(source="NODES")
    view.type = "INFO"  # nothing is drawn there that takes time
    tree = lamp().nodes
    end, ball = tree.nodes["Lamp Output"], tree.nodes["Sphere"]
    end.location, ball.location = (200.0, 0.0), (-400.0, 0.0)
    yield
    with override(editor):
        bpy.ops.node.view_all()
    yield 1.0
    report["shown"] = editor.spaces.active.node_tree == tree

    # A link from an input, dropped into empty space: a search of what fits, and the new node is linked.
    emission = input_of(end, "emission")
    start, empty = socket_place(editor, emission), inside(editor, 0.45, 0.2)
    yield from drag(start, empty)
    yield
    picture(PICTURES, "link_search")
    typed(empty, "color ramp")
    yield
    typed(empty, "\n")
    yield
    press(empty, "LEFTMOUSE")  # leaves the node where it is
    yield
    ramp = emission.links[0].from_node if emission.is_linked else None
    report["linked from an input"] = ramp.bl_label if ramp else None

    # From an output; Escape while dragging, or a link from one socket to another, asks for nothing.
    nodes = len(tree.nodes)
    move(socket_place(editor, ball.outputs[0]))
    yield
    start, aside = socket_place(editor, ball.outputs[0]), inside(editor, 0.5, 0.9)
    event("LEFTMOUSE", "PRESS", start)
    for step in range(1, 4):
        move([a + step * 0.3 * (b - a) for a, b in zip(start, aside)])
        yield
    event("ESC", "PRESS", aside)
    event("ESC", "RELEASE", aside)
    event("LEFTMOUSE", "RELEASE", aside)
    yield
    typed(aside, "\n")
    yield
    report["after escape"] = len(tree.nodes) - nodes, ball.outputs[0].is_linked
    yield from drag(socket_place(editor, ball.outputs[0]), aside)
    yield
    typed(aside, "scale")
    yield
    typed(aside, "\n")
    yield
    press(aside, "LEFTMOUSE")
    yield
    report["linked from an output"] = sorted(link.to_node.bl_label for link in ball.outputs[0].links)
    with override(editor):
        bpy.ops.node.view_all()
    yield 1.0

    # Shift A and a name.
    place = inside(editor, 0.2, 0.25)
    press(place, "A", shift=True)
    yield
    typed(place, "interior")
    yield
    typed(place, "\n")
    yield
    press(place, "LEFTMOUSE")
    yield
    interior = next((node for node in tree.nodes if node.bl_label == "Interior"), None)
    report["added by keys"] = interior is not None
    yield from drag(socket_place(editor, interior.outputs["Height"]), socket_place(editor, input_of(ramp, "value")))
    ramp.value_color_1, ramp.value_color_2 = (1.0, 0.15, 0.03), (0.2, 0.4, 1.0)
    yield
    report["colours"] = np.round(
        pattern_of(lamp()).placed(shape_of(lamp())).evaluate(np.array([[0.0, 0.0, -0.5], [0.0, 0.0, 0.5]])), 3
    ).tolist()
    report["problems"] = problems(tree)

    # A muted node passes its shape on; M again brings it back. The lamp is twice as large by a Scale node.
    scale = next(node for node in tree.nodes if node.bl_label == "Scale")
    scale.value_factor = (2.0, 2.0, 2.0)
    tree.links.new(scale.outputs[0], input_of(end, "shape"))
    yield
    picture(PICTURES, "node_emission", editor)
    report["radius"] = [radius()]
    for _ in range(2):
        select(tree, scale)
        press(aside, "M")
        yield
        report["radius"].append(radius())

    reroute = tree.nodes.new("NodeReroute")
    reroute.location = 100.0, -60.0
    tree.links.new(ball.outputs[0], reroute.inputs[0])
    tree.links.new(reroute.outputs[0], input_of(scale, "shape"))
    yield
    report["radius"].append(radius())

    # A frame; Ctrl G makes a group of nodes, Tab enters and leaves it, Ctrl Alt G dissolves it.
    select(tree, ball, scale)
    with override(editor):
        bpy.ops.node.join()
    yield
    report["frames"] = [node.bl_idname for node in tree.nodes if node.bl_idname == "NodeFrame"], radius()
    select(tree, ramp)
    press(aside, "G", ctrl=True)
    yield
    group = tree.nodes.active
    report["group"] = group.bl_idname, [s.bl_idname for s in group.outputs], problems(tree)
    press(aside, "TAB")
    yield
    report["inside the group"] = editor.spaces.active.edit_tree == group.node_tree
    for node in group.node_tree.nodes:
        node.select = False
    press(aside, "TAB")
    yield
    report["outside again"] = editor.spaces.active.edit_tree == tree
    select(tree, group)
    press(aside, "G", ctrl=True, alt=True)
    yield
    report["dissolved"] = sorted(node.bl_label for node in tree.nodes if node.bl_idname.startswith("SDFLIGHTS"))

    # An Object node says in words what it lacks; with an object, the part follows it.
    part = tree.nodes.new("SDFLIGHTS_Node_object")
    part.location = 150.0, 160.0
    tree.links.new(scale.outputs[0], input_of(part, "shape"))
    tree.links.new(part.outputs[0], input_of(end, "shape"))
    vector = tree.nodes.new("SDFLIGHTS_Node_vector")
    vector.location = ball.location.x - 190.0, ball.location.y + 90.0
    tree.links.new(vector.outputs[0], input_of(ball, "radius"))
    with override(editor):
        bpy.ops.node.view_all()
    yield 1.0
    picture(PICTURES, "node_mistakes", editor)
    report["mistakes"] = sorted(problems(tree))
    tree.nodes.remove(vector)
    empty_object = bpy.data.objects.new("Empty", None)
    bpy.context.scene.collection.objects.link(empty_object)
    part.object = empty_object
    yield
    report["follows"] = [radius()]
    empty_object.location.x = 3.0
    yield
    matrix = np.array(bpy.data.objects["SDF Lamp"].matrix_world)
    report["follows"].append(round(float(shape_of(lamp(), matrix).bounds()[1][0]), 4))
    report["left problems"] = problems(tree)

    # Undo takes it back, a step at a time. What a script has done since the last step must not be left out of one:
    # Blender would keep pointers to what is gone.
    bpy.ops.ed.undo_push(message="The session")
    for _ in range(6):
        press(aside, "Z", ctrl=True)
        yield
    report["after undo"] = problems(lamp().nodes), radius()


if __name__ == "__main__":
    run(steps())
