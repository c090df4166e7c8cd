# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Node trees: what they say is what the expression language says, both ways."""

import math

import bpy
import numpy as np
import pytest

from sdf_lights.blender import parameters
from sdf_lights.blender.lamp import shape_of
from sdf_lights.blender.naming import NODE_TREE
from sdf_lights.blender.nodes import add_menu, editor, function_nodes, groups, reading, tree, tree_text, writing
from sdf_lights.blender.properties import PRIMITIVES
from sdf_lights.render.errors import RenderError
from sdf_lights.sdf.examples import examples
from sdf_lights.sdf.expression import evaluate
from sdf_lights.sdf.functions import FUNCTIONS
from sdf_lights.sdf.shapes import SHAPES, Sphere, Torus

POINTS = np.random.default_rng(5).uniform(-1.0, 1.0, (200, 3))


def alike(one, other, scale=1.0):
    """Whether two shapes have the same field, to the seven digits that Blender's properties have."""
    np.testing.assert_allclose(one.distance(POINTS * scale), other.distance(POINTS * scale), atol=2e-5, rtol=2e-5)


def link(made, source, node, identifier="shape", output=0):
    made.links.new(source.outputs[output], next(s for s in node.inputs if s.identifier == identifier))


def node(made, name, **values):
    """A node of a word, with values of its inputs."""
    new = made.nodes.new(f"SDFLIGHTS_Node_{name}")
    for key, value in values.items():
        setattr(new, f"value_{key}", value)
    return new


@pytest.fixture
def made(file):
    """A tree with an output."""
    return writing.new_tree("Tree")[0]


def end(made):
    return tree.output_of(made)


def problems(made):
    return {name: problem for (_, name), problem in reading.problems_of(made)}


def said(made, owner=None, **values):
    return reading.shape_of(made, values, owner)


@pytest.mark.parametrize("name", examples())
def test_examples_become_nodes_and_text_again(file, name):
    text = examples()[name].text
    made = writing.tree_of(name, text)
    assert problems(made) == {}
    shape = said(made)
    alike(shape, evaluate(text))
    alike(evaluate(tree_text.text_of(made, {}, None)), shape)


def test_only_loops_and_blocks_have_no_nodes_of_their_own(file):
    whole = {
        name
        for name, example in examples().items()
        if any(n.bl_idname == "SDFLIGHTS_Node_expression" for n in writing.tree_of(name, example.text).nodes)
    }
    assert whole == {
        name
        for name, example in examples().items()
        if any(line.lstrip().startswith(("for ", "if ")) for line in example.text.splitlines())
    }


@pytest.mark.parametrize("name", PRIMITIVES)
def test_every_primitive_as_node_says_the_shape(made, name):
    new = node(made, name)
    link(made, new, end(made))
    alike(said(made), PRIMITIVES[name]())
    for about in PRIMITIVES[name].fields():
        prop = new.bl_rna.properties[f"value_{about.name}"]
        assert prop.name == about.label and prop.description == about.description
        assert any(s.identifier == about.name and s.name == about.label for s in new.inputs)


def test_every_word_has_a_node_in_a_menu(registered):
    listed = [kind for kinds in add_menu.nodes_by_menu().values() for kind in kinds]
    assert len(listed) == len(set(listed))
    assert set(function_nodes.FUNCTION_NODES.values()) <= set(listed)
    assert set(SHAPES) <= {kind.function.name for kind in function_nodes.FUNCTION_NODES.values()}
    titles = {name.partition("/")[0] for name in add_menu.nodes_by_menu()}
    assert titles <= set(editor._ORDER)


SPHERES = "sphere(0.5), translate(sphere(0.4), (0.3, 0.1, 0.2)), translate(box(0.3), (0, 0.4, 0))"


@pytest.mark.parametrize("name", [n for n, f in FUNCTIONS.items() if f.group in ("Combinations", "Operators")])
def test_every_operator_as_node(file, name):
    arguments = FUNCTIONS[name].arguments
    parts = (
        SPHERES
        if FUNCTIONS[name].variadic
        else ", ".join(SPHERES.split(", t")[:1] * sum(a.kind == "shape" for a in arguments))
    )
    text = f"{name}({parts}) & box(1.5)"
    alike(said(writing.tree_of("Tree", text)), evaluate(text))


FIELDS = (
    "box(0.5)(p) + 0.02 * sin(40 * p.x) * cos(7 * p.z)",
    "sphere(0.5)(repeat(p, (1, 0, 0.7))) & box(0.8)",
    "max(length(p.xy) - 0.5, abs(p.z) - 0.2, -p.x)",
    "a = angle(30, 0, 90)\nrotate_z(box(0.5, 0.2, 0.1), a)",
    "a = angle(30)\nturn = 2 * a\ntwist(box(0.2, 0.2, 0.5), turn)",
    "big = toggle(False)\nselect(big, sphere(0.9), sphere(0.4))",
    "s = 0.3 if p.x > 0 and not p.y < 0 else 0.5\nlength(p) - s",
    "extrusion(polygon((0, 0), (0.5, 0), (0.2, 0.6)), 0.4)",
    "revolution(moon(0.5, 0.4, 0.25), 0.6)",
    "field(length(p) - 0.5, bounds=0.3)",
    "displace(sphere(0.5), 0.05 * noise(6 * p, 3))",
    "mirror(translate(sphere(0.3), (0.4, 0, 0))) | rotate(torus(0.5, 0.1), 40, (1, 1, 0))",
    "q = polar(p, 6) - (0.5, 0, 0)\nlength(q) - 0.2",
    "v = vector((0.1, 0.2, 0.3), -1, 1)\ntranslate(sphere(0.3), v.zxy * 2) | translate(sphere(v.y), -v)",
    "n = integer(5, 3, 9)\nprism(n, 0.5, 0.3)",
    "transform(box(0.3), (1, 0, 0), (0.5, 1, 0), (0, 0, -2), (0.1, 0, 0))",
    "q = rotate_y(p, 90 * p.z)\nq.x * q.x + q.y ** 2 + mod(q.z, 2) - 0.3 & box(0.6)",
    "vec3(p.xy, 2 * p.z).x * 0 + length(vec3(p.xy, 2 * p.z)) - 0.4",
)


@pytest.mark.parametrize("text", FIELDS)
def test_expressions_become_nodes_and_text_again(file, text):
    made = writing.tree_of("Tree", text)
    assert not any(n.bl_idname == "SDFLIGHTS_Node_expression" for n in made.nodes)
    alike(said(made), evaluate(text))
    alike(evaluate(tree_text.text_of(made, {}, None)), evaluate(text))


def test_a_slider_of_a_node_changes_no_formula(made):
    ball = node(made, "sphere", radius=0.5)
    waves = node(made, "displace")
    sine, product = node(made, "sin"), made.nodes.new("SDFLIGHTS_Node_math")
    separate, position = made.nodes.new("SDFLIGHTS_Node_separate"), made.nodes.new("SDFLIGHTS_Node_position")
    product.operation, product.value_b = "MULTIPLY", 0.3
    link(made, position, separate, "vector")
    link(made, separate, sine, "angle")
    link(made, sine, product, "a")
    link(made, ball, waves)
    link(made, product, waves, "amount")
    link(made, waves, end(made))
    before = said(made)
    product.value_b, ball.value_radius = 0.2, 0.6
    after = said(made)
    assert before.formula() is after.formula() and before != after


def test_parts_of_a_combination_are_taken_from_the_top(made):
    both, one, other = node(made, "difference"), node(made, "box"), node(made, "sphere")
    link(made, one, both, "first")
    link(made, other, both)
    link(made, both, end(made))
    alike(said(made), evaluate("difference(box(), sphere())"))
    many, balls = node(made, "polygon"), []
    for x, y in ((0, 0), (1, 0), (0, 1), (0.2, 0.2)):
        corner = made.nodes.new("SDFLIGHTS_Node_combine")
        corner.plane, corner.value_x, corner.value_y = True, x, y
        balls.append(corner)
    for corner in reversed(balls):
        link(made, corner, many, "point")
    bar = node(made, "extrusion")
    link(made, many, bar, "profile")
    link(made, bar, end(made))
    alike(said(made), evaluate("extrusion(polygon((0, 0), (1, 0), (0, 1), (0.2, 0.2)))"))


def test_reroutes_and_muted_nodes_pass_values_on(made):
    ball, grown, reroute = node(made, "sphere"), node(made, "offset", offset=0.2), made.nodes.new("NodeReroute")
    link(made, ball, grown)
    made.links.new(grown.outputs[0], reroute.inputs[0])
    made.links.new(reroute.outputs[0], end(made).inputs[0])
    alike(said(made), Sphere(0.7))
    grown.mute = True
    alike(said(made), Sphere(0.5))
    made.links.remove(reroute.inputs[0].links[0])
    assert "Nothing is connected" in problems(made)[end(made).name]


def test_mistakes_are_said_on_the_node(made):
    assert problems(made) == {end(made).name: "Nothing is connected to Shape: connect a shape."}
    union, ball = node(made, "union"), node(made, "sphere")
    link(made, union, end(made))
    assert problems(made) == {union.name: "Nothing is connected to Shapes: connect a shape."}
    link(made, ball, union)
    assert problems(made) == {}
    vector = made.nodes.new("SDFLIGHTS_Node_vector")
    link(made, vector, ball, "radius")
    assert "gets a vector, but takes a number" in problems(made)[ball.name]
    assert set(problems(made)) == {ball.name}  # not also of all that depends on it
    position, separate = made.nodes.new("SDFLIGHTS_Node_position"), made.nodes.new("SDFLIGHTS_Node_separate")
    link(made, position, separate, "vector")
    link(made, separate, ball, "radius")
    assert "differs from point to point" in problems(made)[ball.name]
    with pytest.raises(RenderError, match=ball.name):
        said(made)
    tree.forget()
    assert "differs from point to point" in tree.problem_of(ball)


def test_values_that_do_not_go_together_name_the_node(made):
    ring = node(made, "rounded_box", radius=2.0)
    link(made, ring, end(made))
    assert list(problems(made)) == [ring.name]
    with pytest.raises(RenderError, match="Rounded Box"):
        said(made)


def test_circles_are_reported(made):
    one, other = node(made, "offset"), node(made, "offset")
    link(made, one, other)
    link(made, other, one)
    link(made, other, end(made))
    assert any("depends on its own result" in problem for problem in problems(made).values())
    with pytest.raises(RenderError, match="circle"):
        said(made)


def test_long_chains(made):
    last = node(made, "sphere")
    for _ in range(60):
        grown = node(made, "offset", offset=0.01)
        link(made, last, grown)
        last = grown
    link(made, last, end(made))
    alike(said(made), Sphere(1.1))


def test_shapes_that_double_are_refused_at_once(made):
    last = node(made, "sphere")
    for _ in range(30):
        both = node(made, "smooth_union")
        link(made, last, both)
        moved = made.nodes.new("SDFLIGHTS_Node_place")
        moved.value_translation = (1.0, 0.0, 0.0)
        link(made, last, moved)
        link(made, moved, both)
        last = both
    link(made, last, end(made))
    assert any("too many" in problem for problem in problems(made).values())


def test_object_transform_is_relative_to_the_lamp(made, add, lamp, file, synced):
    part = add("Part", None, location=(1.0, 2.0, 3.0), rotation=(0.3, 0.2, 0.1), scale=(1.0, 2.0, 0.5))
    where, ball = made.nodes.new("SDFLIGHTS_Node_object"), node(made, "box")
    link(made, ball, where)
    link(made, where, end(made))
    assert "No object" in problems(made)[where.name]
    where.object = part
    data = lamp()
    data.sdf_lamp.nodes, data.sdf_lamp.source = made, "NODES"
    holder = add("Lamp", data, location=(1.0, 0.0, 0.0), rotation=(0.0, 0.0, 1.0), scale=(2.0, 1.0, 1.0))
    bpy.context.view_layer.update()
    got = synced().lamps[0]
    world = got.shape.bounds(np.array(got.matrix))
    from sdf_lights.sdf.shapes import Box

    wanted = Box().bounds(np.array([tuple(row) for row in part.matrix_world]))
    np.testing.assert_allclose(world, wanted, atol=1e-5)
    part.location.x += 1.0
    holder.location.y += 5.0
    moved = synced().lamps[0]
    np.testing.assert_allclose(
        moved.shape.bounds(np.array(moved.matrix)), np.array(wanted) + (1.0, 0.0, 0.0), atol=1e-5
    )


def test_moving_an_object_of_the_tree_tags_the_lamp(made, add, lamp, file):
    part = add("Part", None)
    where, ball = made.nodes.new("SDFLIGHTS_Node_object"), node(made, "sphere")
    where.object = part
    link(made, ball, where)
    link(made, where, end(made))
    data = lamp()
    data.sdf_lamp.nodes, data.sdf_lamp.source = made, "NODES"
    add("Lamp", data)
    heard = []

    def listen(scene, depsgraph):
        heard.extend(update.id.original.name for update in depsgraph.updates)

    bpy.app.handlers.depsgraph_update_post.append(listen)
    try:
        for change in (lambda: setattr(part, "location", (1, 0, 0)), lambda: setattr(ball, "value_radius", 0.7)):
            bpy.context.view_layer.update()
            bpy.context.view_layer.update()
            heard.clear()
            change()
            bpy.context.view_layer.update()
            bpy.context.view_layer.update()
            assert data.name in heard
    finally:
        bpy.app.handlers.depsgraph_update_post.remove(listen)


def test_values_of_nodes_can_be_animated(made, add, lamp, synced, file):
    ball = node(made, "sphere")
    link(made, ball, end(made))
    for frame, radius in ((1, 0.5), (11, 1.5)):
        ball.value_radius = radius
        assert ball.keyframe_insert("value_radius", frame=frame)
    data = lamp()
    data.sdf_lamp.nodes, data.sdf_lamp.source = made, "NODES"
    add("Lamp", data)
    for frame, radius in ((1, 0.5), (11, 1.5)):
        file.scene.frame_set(frame)
        assert synced().lamps[0].shape.radius == pytest.approx(radius)


def test_parameters_are_properties_of_each_lamp(made, lamp):
    size, ball = made.nodes.new("SDFLIGHTS_Node_parameter"), node(made, "sphere")
    size.parameter, size.default, size.maximum, size.tooltip = "size", 0.4, 2.0, "of the ball"
    link(made, size, ball, "radius")
    link(made, ball, end(made))
    one, other = lamp("One"), lamp("Other")
    for data in (one, other):
        data.sdf_lamp.nodes, data.sdf_lamp.source = made, "NODES"
        parameters.update(data)
    one["sdf_size"] = 1.25
    assert shape_of(one.sdf_lamp).radius == 1.25 and shape_of(other.sdf_lamp).radius == pytest.approx(0.4)
    assert one.id_properties_ui("sdf_size").as_dict()["max"] == 2.0
    size.parameter = "sphere"
    assert "cannot be the name" in problems(made)[size.name]
    text = tree_text.text_of
    size.parameter = "size"
    assert "size = slider(1.25, 0, 2)  # of the ball" in text(made, {"size": 1.25}, None)


def test_expression_node_has_inputs_for_its_parameters(made):
    part = made.nodes.new("SDFLIGHTS_Node_expression")
    part.expression = "translate(sphere(0.3), (0.2, 0, 0))"
    link(made, part, end(made))
    assert [s.name for s in part.inputs] == []
    block = bpy.data.texts.new("Part")
    block.write(
        "p = 2 * p\nsize = slider(1, 0.1, 3)\nturn = angle(90)\nr = 2 * size\n"
        "twist(box(0.2, 0.1, 0.5), turn)(p) - r * 0.1\n"
    )
    part.text = block
    assert [s.identifier for s in part.inputs] == ["size", "turn"]
    alike(said(made), evaluate(block.as_string()))
    part.inputs["Size"].default_value = 2.0
    alike(said(made), evaluate(block.as_string(), {"size": 2.0}))
    alike(evaluate(tree_text.text_of(made, {}, None)), said(made))
    value = made.nodes.new("SDFLIGHTS_Node_number")
    value.value = 9.0  # held to the limits
    link(made, value, part, "size")
    alike(said(made), evaluate(block.as_string(), {"size": 3.0}))
    block.clear()
    block.write("a = 1\nspere(1)")
    assert "Line 2, column 1" in problems(made)[part.name]


def test_names_in_an_expression_node_stay_there(made):
    both = node(made, "union")
    for x in (-0.4, 0.4):
        part = made.nodes.new("SDFLIGHTS_Node_expression")
        block = bpy.data.texts.new("Part")
        block.write(f"p = p - ({x}, 0, 0)\nradius = 0.2\nlength(p) - radius\n")
        part.text = block
        link(made, part, both)
    link(made, both, end(made))
    wanted = evaluate("union(length(p - (0.4, 0, 0)) - 0.2, length(p + (0.4, 0, 0)) - 0.2)")
    alike(said(made), wanted)
    alike(evaluate(tree_text.text_of(made, {}, None)), wanted)


def test_groups(made):
    ball, grown, rest = node(made, "sphere", radius=0.3), node(made, "offset", offset=0.2), node(made, "shell")
    value = made.nodes.new("SDFLIGHTS_Node_number")
    value.value = 0.25
    link(made, value, grown, "offset")
    link(made, ball, grown)
    link(made, grown, rest)
    link(made, rest, end(made))
    wanted = said(made)
    group = groups.make_group(made, [ball, grown])
    alike(said(made), wanted)
    assert [s.bl_idname for s in group.inputs] == ["NodeSocketFloat"]
    assert [s.bl_idname for s in group.outputs] == ["SDFLIGHTS_NodeSocketShape"]
    made.links.remove(group.inputs[0].links[0])
    group.inputs[0].default_value = 0.5
    alike(said(made), evaluate("shell(offset(sphere(0.3), 0.5))"))
    alike(evaluate(tree_text.text_of(made, {}, None)), said(made))
    inner = group.node_tree
    item = inner.interface.new_socket("Extra", in_out="INPUT", socket_type="NodeSocketVector")
    tree._loaded()
    assert [s.name for s in group.inputs] == ["Offset", "Extra"] and group.inputs[0].default_value == 0.5
    inner.interface.remove(item)
    tree._loaded()
    assert [s.name for s in group.inputs] == ["Offset"]
    # A mistake inside is said on the node, and on the group.
    broken = next(n for n in inner.nodes if n.bl_idname == "SDFLIGHTS_Node_sphere")
    broken.value_radius = 0.3
    vector = inner.nodes.new("SDFLIGHTS_Node_vector")
    link(inner, vector, broken, "radius")
    assert set(problems(made)) == {broken.name, group.name}
    inner.nodes.remove(vector)
    groups.ungroup(group)
    alike(said(made), evaluate("shell(offset(sphere(0.3), 0.5))"))


def test_a_group_used_twice_and_one_in_another(made):
    inner = groups.empty_group("Inner")
    ball = node(inner, "sphere", radius=0.2)
    item = inner.interface.new_socket("Radius", in_out="INPUT", socket_type="NodeSocketFloat")
    start = next(n for n in inner.nodes if n.bl_idname == "NodeGroupInput")
    inner.links.new(start.outputs[0], ball.inputs[0])
    inner.links.new(ball.outputs[0], next(n for n in inner.nodes if n.bl_idname == "NodeGroupOutput").inputs[0])
    outer = groups.empty_group("Outer")
    within = outer.nodes.new("SDFLIGHTS_NodeGroup")
    within.node_tree = inner
    within.match_interface()
    within.inputs[0].default_value = 0.15
    outer.links.new(within.outputs[0], next(n for n in outer.nodes if n.bl_idname == "NodeGroupOutput").inputs[0])
    both = node(made, "union")
    for group, radius in ((inner, 0.4), (outer, None)):
        used = made.nodes.new("SDFLIGHTS_NodeGroup")
        used.node_tree = group
        used.match_interface()
        if radius:
            used.inputs[0].default_value = radius
        moved = made.nodes.new("SDFLIGHTS_Node_place")
        moved.value_translation = (0.0 if radius else 1.0, 0.0, 0.0)
        link(made, used, moved)
        link(made, moved, both)
    link(made, both, end(made))
    alike(said(made), evaluate("sphere(0.4) | translate(sphere(0.15), (1, 0, 0))"))
    assert item.identifier


def test_a_group_without_a_tree_or_output_says_so(made):
    used = made.nodes.new("SDFLIGHTS_NodeGroup")
    used.node_tree = groups.empty_group("Empty")
    used.match_interface()
    link(made, used, end(made))
    assert "Nothing is connected" in problems(made)[end(made).name]
    used.node_tree.nodes.clear()
    assert "no Group Output" in problems(made)[used.name]


@pytest.mark.parametrize("shape", ["TORUS", "HELIX", "MANDELBULB", "CAPPED_TORUS", "KIFS"])
def test_a_primitive_becomes_nodes_and_an_expression(lamp, shape):
    data = lamp(shape=shape)
    before = shape_of(data.sdf_lamp)
    editor.to_nodes(data)
    assert data.sdf_lamp.source == "NODES"
    alike(shape_of(data.sdf_lamp), before)
    alike(evaluate(editor.expression_of(data)), before)


def test_operators_of_a_lamp(file, add, lamp):
    data = lamp(shape="TORUS", major_radius=0.8)
    obj = add("Lamp", data)
    bpy.context.view_layer.objects.active = obj
    assert bpy.ops.sdf_lights.nodes_new() == {"FINISHED"}
    alike(shape_of(data.sdf_lamp), Torus(0.8))
    assert bpy.ops.sdf_lights.nodes_to_expression() == {"FINISHED"}
    assert data.sdf_lamp.source == "EXPRESSION" and "torus(major_radius=0.8" in data.sdf_lamp.text.as_string()
    data.sdf_lamp.source, data.sdf_lamp.nodes = "NODES", None
    with pytest.raises(RenderError, match="no node tree"):
        shape_of(data.sdf_lamp)


def test_trees_are_kept_in_files_and_appended_with_lamps(file, add, lamp, tmp_path):
    data = lamp("Kept")
    add("Lamp", data)
    data.sdf_lamp.nodes = writing.tree_of("Tree", "smooth_union(sphere(0.3), torus(0.6, 0.1), radius=0.2)")
    data.sdf_lamp.source = "NODES"
    wanted = shape_of(data.sdf_lamp)
    path = str(tmp_path / "file.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.read_factory_settings(use_empty=True)
    with bpy.data.libraries.load(path) as (there, here):
        here.lights = ["Kept"]
    alike(shape_of(here.lights[0].sdf_lamp), wanted)
    bpy.ops.wm.open_mainfile(filepath=path)
    alike(shape_of(bpy.data.lights["Kept"].sdf_lamp), wanted)


def test_trees_outlive_disabling_and_enabling_the_add_on(registered, file):
    made = writing.tree_of("Tree", "box(1) - sphere(1.2)")
    groups.make_group(made, [made.nodes["Sphere"]])
    for _ in range(2):
        registered.unregister()
        registered.register()
    made = bpy.data.node_groups["Tree"]
    assert problems(made) == {}
    alike(said(made), evaluate("box(1) - sphere(1.2)"))


def test_sockets_of_other_versions_do_no_harm(made):
    ball = node(made, "torus")
    link(made, ball, end(made))
    ball.inputs.remove(ball.inputs[1])
    ball.inputs.new("NodeSocketFloat", "Later", identifier="later")
    alike(said(made), Torus())
    tree._loaded()
    assert {s.identifier for s in ball.inputs} == {"major_radius", "minor_radius", "later"}
    alike(said(made), Torus())


def test_angles_are_radians_in_nodes_and_degrees_in_text(made):
    bar, turned = node(made, "box"), node(made, "twist")
    turned.value_angle = math.radians(60.0)
    link(made, bar, turned)
    link(made, turned, end(made))
    alike(said(made), evaluate("twist(box(), 60)"))
    value = made.nodes.new("SDFLIGHTS_Node_number")
    value.value = math.radians(30.0)
    link(made, value, turned, "angle")
    alike(said(made), evaluate("twist(box(), 30)"))


def test_only_trees_of_this_kind_are_offered(file, lamp):
    data = lamp()
    other = bpy.data.node_groups.new("Other", "ShaderNodeTree")
    data.sdf_lamp.nodes, data.sdf_lamp.source = other, "NODES"
    with pytest.raises(RenderError, match="is not for SDF lamps"):
        shape_of(data.sdf_lamp)
    assert bpy.data.node_groups.new("Own", NODE_TREE).bl_idname == NODE_TREE
