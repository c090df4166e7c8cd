# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Emission from nodes: what they say is what the language of emissions says, both ways."""

import bpy
import numpy as np
import pytest

from sdf_lights.blender import parameters
from sdf_lights.blender.lamp import pattern_of, shape_of
from sdf_lights.blender.nodes import editor, groups, reading, tree, tree_text, writing
from sdf_lights.render.errors import RenderError
from sdf_lights.sdf.emission import EmissionExpression
from sdf_lights.sdf.emission_presets import presets
from sdf_lights.sdf.expression import evaluate
from sdf_lights.sdf.shapes import Sphere

POINTS = np.random.default_rng(3).uniform(-0.28, 0.28, (200, 3))
BALL = Sphere(0.5)


def colours(emission, shape=BALL):
    return emission.placed(shape).evaluate(POINTS)


def alike(one, other):
    """To the seven digits that Blender's properties have."""
    np.testing.assert_allclose(colours(one), colours(other), rtol=2e-5, atol=2e-6)


def emission(text):
    return EmissionExpression(text).emission()


def socket(node, identifier, side="inputs"):
    return next(s for s in getattr(node, side) if s.identifier == identifier)


def problems(made):
    return {name: problem for (_, name), problem in reading.problems_of(made)}


@pytest.fixture
def made(file):
    """A tree of a ball of radius 0.5."""
    return writing.tree_of("Tree", "sphere(0.5)")


@pytest.fixture
def glow(made):
    """Function: link an output to the emission."""
    return lambda output: made.links.new(output, socket(tree.output_of(made), "emission"))


@pytest.fixture
def data(add, lamp, made):
    """The data of a lamp with the tree."""
    found = lamp()
    found.sdf_lamp.source, found.sdf_lamp.nodes = "NODES", made
    bpy.context.view_layer.objects.active = add("Lamp", found)
    return found


TEXTS = [preset.text for preset in presets().values()] + [
    "height * (1, 0.5, 0.25)",
    "ramp(depth, 0, 0.2, 0.1, (1, 0, 0), 0.3, (0, 0, 1))",
    "ramp_constant(height, 0, blackbody(1500), 0.5, blackbody(6000))",
    "ramp(p.x, -0.2, (p.y, 0, 0.5), 0.2, 1)",
    "0.5 + noise(4 * p) * select(height > 0.5, 1, 0.25)",
    "exp(-20 * depth) + exp(-50 * abs(torus(0.3, 0.05)(p)))",
    "(0.2, 0.4, 0.6)",
    "2",
    "glow = 0\nfor i in range(4):\n    glow += depth ** i\nglow",
]


@pytest.mark.parametrize("text", TEXTS)
def test_emissions_become_nodes_and_text_again(made, text):
    writing.add_emission(made, text)
    assert problems(made) == {}
    alike(reading.emission_of(made, {}, None), emission(text))
    alike(emission(tree_text.emission_text_of(made, {}, None)), emission(text))
    assert shape_of_tree(made) == BALL


def shape_of_tree(made):
    return reading.shape_of(made, {}, None)


def test_without_a_link_the_pattern_of_the_panel_counts(made, data, glow):
    assert pattern_of(data.sdf_lamp) is None
    data.sdf_lamp.emission.source = "SHELL"
    alike(pattern_of(data.sdf_lamp), emission(presets()["shell"].text))
    interior = made.nodes.new("SDFLIGHTS_Node_interior")
    link = glow(socket(interior, "height", "outputs"))
    alike(pattern_of(data.sdf_lamp), emission("height"))
    made.links.remove(link)
    alike(pattern_of(data.sdf_lamp), emission(presets()["shell"].text))


def test_a_link_from_nowhere_is_an_even_emission(made, data, glow):
    glow(made.nodes.new("NodeReroute").outputs[0])
    assert pattern_of(data.sdf_lamp) is None and problems(made) == {}


def test_the_render_has_the_emission(made, data, glow, synced):
    glow(socket(made.nodes.new("SDFLIGHTS_Node_interior"), "depth", "outputs"))
    alike(synced().lamps[0].emission, emission("depth"))


def test_stops_of_a_ramp_are_sorted_and_can_be_linked(made, glow):
    ramp = made.nodes.new("SDFLIGHTS_Node_ramp")
    interior = made.nodes.new("SDFLIGHTS_Node_interior")
    made.links.new(socket(interior, "height", "outputs"), socket(ramp, "value"))
    glow(ramp.outputs[0])
    alike(reading.emission_of(made, {}, None), emission("ramp(height, 0, 0, 1, 1)"))
    ramp.stops = 3
    assert [s.identifier for s in ramp.inputs][-1] == "color_3" and len(ramp.inputs) == 7
    ramp.value_position_3, ramp.value_color_3 = 0.25, (1.0, 0.0, 0.0)
    alike(reading.emission_of(made, {}, None), emission("ramp(height, 0, 0, 0.25, (1, 0, 0), 1, 1)"))
    body = made.nodes.new("SDFLIGHTS_Node_blackbody")
    body.value_temperature = 2000.0
    made.links.new(body.outputs[0], socket(ramp, "color_1"))
    alike(reading.emission_of(made, {}, None), emission("ramp(height, 0, blackbody(2000), 0.25, (1, 0, 0), 1, 1)"))
    ramp.interpolation, ramp.stops = "CONSTANT", 2
    assert len(ramp.inputs) == 5
    alike(reading.emission_of(made, {}, None), emission("ramp_constant(height, 0, blackbody(2000), 1, 1)"))


def test_a_slider_of_a_ramp_changes_no_formula(made, glow):
    """Nothing is compiled while a stop is moved or its colour is chosen."""
    ramp = made.nodes.new("SDFLIGHTS_Node_ramp")
    made.links.new(socket(made.nodes.new("SDFLIGHTS_Node_interior"), "height", "outputs"), socket(ramp, "value"))
    glow(ramp.outputs[0])
    ramp.value_color_1 = (0.1, 0.2, 0.3)
    ramp.value_position_1 = 0.1
    before = reading.emission_of(made, {}, None)
    ramp.value_position_1, ramp.value_color_1, ramp.value_color_2 = 0.2, (0.3, 0.2, 0.1), (0.5, 0.6, 0.7)
    after = reading.emission_of(made, {}, None)
    assert after.colour == before.colour and after.numbers != before.numbers


@pytest.mark.parametrize("name", sorted(set(presets()) - {"uniform"}))
def test_patterns_have_inputs_for_their_parameters(made, glow, name):
    pattern = made.nodes.new("SDFLIGHTS_Node_pattern")
    pattern.pattern = name.upper()
    glow(pattern.outputs[0])
    expression = EmissionExpression(presets()[name].text)
    assert [s.identifier for s in pattern.inputs] == [declared.name for declared in expression.parameters]
    alike(reading.emission_of(made, {}, None), expression.emission())
    alike(emission(tree_text.emission_text_of(made, {}, None)), expression.emission())


def test_a_pattern_of_ones_own(made, glow):
    pattern = made.nodes.new("SDFLIGHTS_Node_pattern")
    pattern.pattern, pattern.expression = "EXPRESSION", "exp(-dept)"
    glow(pattern.outputs[0])
    assert "dept is not a known name: did you mean depth?" in problems(made)[pattern.name]
    pattern.text = bpy.data.texts.new("Glow")
    pattern.text.write("depth = 0.1 + depth\nfall = slider(20, 1, 50)\nexp(-fall * depth)")
    pattern.match_interface()
    socket(pattern, "fall").default_value = 30.0
    alike(reading.emission_of(made, {}, None), emission("exp(-30 * (0.1 + depth))"))
    alike(emission(tree_text.emission_text_of(made, {}, None)), emission("exp(-30 * (0.1 + depth))"))


def test_mistakes_are_said_on_the_node(made, glow, data):
    end = tree.output_of(made)
    glow(made.nodes["Sphere"].outputs[0])
    assert problems(made)[end.name] == "Emission gets a shape, but takes a colour: connect another output."
    with pytest.raises(RenderError, match="In its nodes, Lamp Output: Emission gets a shape"):
        pattern_of(data.sdf_lamp)
    assert shape_of(data.sdf_lamp) == BALL
    interior = made.nodes.new("SDFLIGHTS_Node_interior")
    made.links.new(socket(interior, "depth", "outputs"), socket(end, "shape"))
    assert "before it is made" in problems(made)[interior.name]


def test_parameters_of_shape_and_emission_are_one_set(made, data, glow):
    size = made.nodes.new("SDFLIGHTS_Node_parameter")
    size.parameter, size.default = "size", 0.4
    made.links.new(size.outputs[0], socket(made.nodes["Sphere"], "radius"))
    glow(size.outputs[0])
    other = made.nodes.new("SDFLIGHTS_Node_parameter")
    other.parameter, other.default = "glow", 3.0
    power = made.nodes.new("SDFLIGHTS_Node_math")
    made.links.new(size.outputs[0], socket(power, "a"))
    made.links.new(other.outputs[0], socket(power, "b"))
    glow(power.outputs[0])
    assert [declared.name for declared in parameters.declarations(data.sdf_lamp)] == ["size", "glow"]
    parameters.update(data)
    data["sdf_size"], data["sdf_glow"] = 0.25, 5.0
    assert shape_of(data.sdf_lamp) == Sphere(0.25) and colours(pattern_of(data.sdf_lamp))[0, 0] == 5.25
    other.parameter = "depth"
    assert "depth has a special meaning" in problems(made)[other.name]
    other.parameter, other.default = "size", 1.0
    assert "declares size differently" in problems(made)[other.name]


def test_colours_go_in_and_out_of_groups(made, glow):
    ramp = made.nodes.new("SDFLIGHTS_Node_ramp")
    color = made.nodes.new("SDFLIGHTS_Node_color")
    color.value = (0.25, 0.5, 1.0)
    interior = made.nodes.new("SDFLIGHTS_Node_interior")
    made.links.new(socket(interior, "height", "outputs"), socket(ramp, "value"))
    made.links.new(color.outputs[0], socket(ramp, "color_2"))
    glow(ramp.outputs[0])
    wanted = emission("ramp(height, 0, 0, 1, (0.25, 0.5, 1))")
    alike(reading.emission_of(made, {}, None), wanted)
    group = groups.make_group(made, [ramp])
    assert [s.bl_idname for s in group.inputs] == ["SDFLIGHTS_NodeSocketNumber", "NodeSocketColor"] or (
        [s.bl_idname for s in group.inputs] == ["NodeSocketFloat", "NodeSocketColor"]
    )
    alike(reading.emission_of(made, {}, None), wanted)
    made.nodes.remove(color)
    group.inputs[1].default_value = (0.25, 0.5, 1.0, 1.0)
    alike(reading.emission_of(made, {}, None), wanted)
    groups.ungroup(group)
    alike(reading.emission_of(made, {}, None), wanted)


def test_lamps_become_nodes_and_expressions_with_their_emission(data):
    data.sdf_lamp.source = "EXPRESSION"
    data.sdf_lamp.text = bpy.data.texts.new("Shape")
    data.sdf_lamp.text.write("size = slider(0.5, 0.1, 1)\nsphere(size)")
    data.sdf_lamp.emission.source = "CORE"
    parameters.update(data)
    data["sdf_emission.size"] = 0.1
    before = pattern_of(data.sdf_lamp)
    made = editor.to_nodes(data)
    assert reading.has_emission(made) and shape_of(data.sdf_lamp) == evaluate("sphere(0.5)")
    alike(pattern_of(data.sdf_lamp), before)
    assert bpy.ops.sdf_lights.nodes_to_expression() == {"FINISHED"}
    assert data.sdf_lamp.source == "EXPRESSION" and data.sdf_lamp.emission.source == "EXPRESSION"
    alike(pattern_of(data.sdf_lamp), before)
    assert shape_of(data.sdf_lamp) == evaluate("sphere(0.5)")


def test_objects_place_the_emission(made, add, data, glow):
    empty = add("Empty", None, location=(0.0, 0.0, 2.0))
    bpy.data.objects["Lamp"].location = (0.0, 0.0, 1.5)
    bpy.context.view_layer.update()
    place = made.nodes.new("SDFLIGHTS_Node_object")
    place.object = empty
    far = made.nodes.new("SDFLIGHTS_Node_math")
    made.links.new(socket(place, "location", "outputs"), socket(far, "a"))
    glow(far.outputs[0])
    owner = np.array(bpy.data.objects["Lamp"].matrix_world)
    np.testing.assert_allclose(colours(pattern_of(data.sdf_lamp, owner))[0], (0.0, 0.0, 0.5), atol=1e-6)
