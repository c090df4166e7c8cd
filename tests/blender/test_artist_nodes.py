# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""An artist in the node editor of Blender's window: see nodes_session.py. And, without a window, what links offer."""

import pathlib

import bpy
import pytest
from sessions import seen_by

from sdf_lights.blender.nodes import groups, link_search, reading, tree, writing

SESSION = pathlib.Path(__file__).with_name("nodes_session.py")


@pytest.fixture(scope="module")
def seen(blender_command, tmp_path_factory):
    return seen_by(blender_command, SESSION, tmp_path_factory.mktemp("nodes"))


@pytest.mark.gui
def test_a_link_dropped_into_empty_space_asks_what_to_add(seen):
    assert seen["shown"] and seen["linked from an input"] == "Color Ramp"
    assert "Scale" in seen["linked from an output"]
    assert seen["after escape"] == [0, True]


@pytest.mark.gui
def test_emission_is_built_by_keys_and_the_mouse(seen):
    assert seen["added by keys"] and seen["problems"] == []
    assert seen["colours"] == [pytest.approx((1.0, 0.15, 0.03), abs=1e-3), pytest.approx((0.2, 0.4, 1.0), abs=1e-3)]


@pytest.mark.gui
def test_muting_reroutes_frames_and_groups(seen):
    assert seen["radius"] == [1.0, 0.5, 1.0, 1.0]  # twice the ball; muted; again; by a reroute
    assert seen["frames"] == [["NodeFrame"], 1.0]
    assert seen["group"] == ["SDFLIGHTS_NodeGroup", ["NodeSocketColor"], []]
    assert seen["inside the group"] and seen["outside again"]
    assert "Color Ramp" in seen["dissolved"] and "Group" not in seen["dissolved"]


@pytest.mark.gui
def test_nodes_say_what_is_wrong_and_follow_objects(seen):
    assert seen["mistakes"] == [
        "No object is chosen: choose one, for instance an empty.",
        "Radius gets a vector, but takes a number: connect another output.",
    ]
    assert seen["follows"] == [1.0, 4.0] and seen["left problems"] == []
    assert seen["after undo"][0] == []


def offered(socket):
    return {(choice.node, choice.identifier) for choice in link_search.choices(socket)}


def test_a_dropped_link_is_offered_what_fits(file):
    made = writing.tree_of("Tree", "sphere(0.5)")
    end, ball = tree.output_of(made), made.nodes["Sphere"]
    shapes, colours = (offered(next(s for s in end.inputs if s.identifier == name)) for name in ("shape", "emission"))
    assert ("SDFLIGHTS_Node_torus", "result") in shapes and ("SDFLIGHTS_Node_blackbody", "result") not in shapes
    assert {("SDFLIGHTS_Node_ramp", "result"), ("SDFLIGHTS_Node_interior", "height")} <= colours
    assert ("SDFLIGHTS_Node_torus", "result") not in colours
    after = offered(ball.outputs[0])
    assert ("SDFLIGHTS_Node_distance", "shape") in after and ("SDFLIGHTS_Node_output", "shape") in after
    assert ("SDFLIGHTS_Node_ramp", "value") not in after
    first = link_search.choices(next(s for s in end.inputs if s.identifier == "emission"))[0]
    assert first.label.startswith("Blackbody")


@pytest.mark.parametrize("identifier", ["shape", "emission"])
def test_everything_that_is_offered_can_be_linked(file, identifier):
    made = writing.tree_of("Tree", "sphere(0.5)")
    groups.make_group(made, [made.nodes["Sphere"]]).node_tree.name = "Ball"
    other, end = writing.new_tree("Other")
    socket = next(s for s in end.inputs if s.identifier == identifier)
    choices = link_search.choices(socket)
    assert len({choice.key for choice in choices}) == len(choices) > 10
    assert any(choice.group == "Ball" for choice in choices) == (identifier == "shape")
    for choice in choices:
        node = link_search.add_linked(socket, choice, (-300.0, 0.0))
        assert socket.links[0].from_node == node and other.nodes.active == node
        other.nodes.remove(node)
    for choice in link_search.choices(other.nodes.new("SDFLIGHTS_Node_sphere").outputs[0]):
        node = link_search.add_linked(other.nodes["Sphere"].outputs[0], choice, (0.0, 0.0))
        assert next(s for s in node.inputs if s.identifier == choice.identifier).is_linked
        assert not [problem for _, problem in reading.problems_of(other) if "gets a shape" in problem]
        other.nodes.remove(node)
    assert bpy.ops.sdf_lights.link_search.poll() is False  # there is no node editor
