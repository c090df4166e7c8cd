# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What moves while the shutter is open is as blurred as in Cycles."""

import math

import bpy
import numpy as np
import pytest

from tests.blender.animated import animate, form, glowing_square, instances, lens

pytest.importorskip("_cycles")


@pytest.fixture
def shot(file, add, quad, material):
    """A glowing square before a dim sky, of which a quarter is darker, and its blur on; the square's object."""
    square = glowing_square(file, add, quad, material, (1.0, 0.5, 1.0), 1024)
    world = bpy.data.worlds.new("Sky")
    world.use_nodes = True
    world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.2, 0.3, 0.4, 1.0)
    file.scene.world = world
    file.scene.render.use_motion_blur = True
    file.scene.render.motion_blur_shutter = 1.5
    file.scene.frame_set(5)
    return square


def moves(shot, **_):
    animate(shot, "location", (-1.0, 0.0, 1.0), (0.0, 0.0, 1.2), (1.0, 1.0, 0.6))


def from_the_frame(shot, scene, **_):
    moves(shot)
    scene.render.motion_blur_position = "START"


def to_the_frame(shot, scene, **_):
    moves(shot)
    scene.render.motion_blur_position = "END"


def turns(shot, **_):
    half = math.pi / 2
    animate(shot, "rotation_euler", (half, -1.0, 0.0), (half, 0.4, 0.3), (half, 2.0, 0.0))


def turns_in_steps(shot, **_):
    shot.cycles.motion_steps = 3
    turns(shot)


def grows(shot, **_):
    animate(shot, "scale", (0.2, 0.2, 1.0), (1.0, 0.7, 1.0), (1.5, 1.5, 1.0))


def curve(shot, scene, **_):
    moves(shot)
    points = scene.render.motion_blur_shutter_curve.curves[0].points
    points[0].location, points[-1].location = (0.0, 1.0), (1.0, 0.0)
    scene.render.motion_blur_shutter_curve.update()


def camera(camera, **_):
    half = math.pi / 2
    animate(camera, "rotation_euler", (half, 0.0, -0.15), (half, 0.1, 0.05), (half + 0.1, 0.0, 0.1))


def rolling(camera, scene, **_):
    animate(camera, "location", (-1.0, -5.0, 1.0), (0.0, -5.0, 1.0), (1.0, -5.0, 1.0))
    scene.cycles.rolling_shutter_type, scene.cycles.rolling_shutter_duration = "TOP", 0.2


def form_off(shot, **_):
    form(shot)
    shot.cycles.use_deform_motion = False


def form_of_what_moves(shot, **_):
    form(shot)
    moves(shot)


def small_instances(shot, **rest):
    shot.scale = (0.4, 0.3, 1.0)
    instances(shot, **rest)


def off(shot, **_):
    moves(shot)
    shot.cycles.use_motion_blur = False


def off_to_the_frame(shot, scene, camera, **_):
    to_the_frame(shot, scene)
    animate(camera, "location", (-0.6, -5.0, 1.0), (0.0, -5.0, 1.0), (0.4, -5.0, 1.2))
    shot.cycles.use_motion_blur = camera.cycles.use_motion_blur = False


def form_off_from_the_frame(shot, scene, **_):
    form_off(shot)
    scene.render.motion_blur_position = "START"


QUICK = [from_the_frame, turns, curve, lens, rolling, form_of_what_moves, small_instances, off_to_the_frame]
SLOW = [moves, to_the_frame, turns_in_steps, grows, camera, form, form_off, form_off_from_the_frame, off]
CASES = [*QUICK, *(pytest.param(build, marks=pytest.mark.slow) for build in SLOW)]


@pytest.mark.parametrize("build", CASES, ids=[build.__name__ for build in QUICK + SLOW])
def test_a_blur_is_that_of_cycles(shot, file, add, pictures, build):
    build(shot=shot, scene=file.scene, camera=file.camera, add=add, file=file)
    file.scene.frame_set(5)
    found = []
    for file.scene.render.engine in ("CYCLES", "SDF_LIGHTS"):
        bpy.ops.sdf_lights.cycles_settings_copy()
        file.scene.sdf_lights.device = "CPU"
        found.append(pictures()["ViewLayer"]["Combined"][..., :3].astype(float))
    theirs, ours = found
    blocks = [picture.reshape(4, 4, 6, 4, 3).mean((1, 3)) for picture in (ours, theirs)]
    print(build.__name__, ours.mean() / theirs.mean() - 1.0, np.abs(blocks[0] - blocks[1]).max() / theirs.mean())
    assert ours.mean() == pytest.approx(theirs.mean(), rel=0.01)
    assert np.abs(blocks[0] - blocks[1]).max() < 0.03 * theirs.mean()
    assert file.scene.frame_current == 5 and file.scene.frame_subframe == 0.0


@pytest.fixture
def blurred(file):
    """The scene, with blur over the whole of frame 4.5 to 5.5."""
    bpy.ops.preferences.addon_enable(module="cycles")
    file.scene.render.use_motion_blur, file.scene.render.motion_blur_shutter = True, 1.0
    file.scene.frame_set(5)
    return file.scene


def test_lamps_and_lights_move_and_change(blurred, add, lamp, synced):
    flying = add("Flying", lamp())
    animate(flying, "location", (-2.0, 0.0, 1.0), (0.0, 0.0, 1.0), (2.0, 0.0, 1.0))
    fading = add("Fading", bpy.data.lights.new("Fading", "POINT"), (0.0, 0.0, 3.0))
    animate(fading.data, "energy", 0.0, 10.0, 20.0)
    still = add("Still", lamp(), (0.0, 2.0, 1.0))
    blurred.frame_set(5)
    scene = synced()
    assert scene.warnings == [] and scene.shutter is not None
    lamps = {item.name: item for item in scene.lamps}
    assert [round(item.matrix[0, 3], 5) for item in lamps["Flying"].motion] == [-1.0, 0.0, 1.0]
    assert lamps["Still"].motion == () and still.location.y == 2.0
    assert [item.power for item in scene.lights[0].motion] == pytest.approx([5.0, 10.0, 15.0])
    assert flying.location.x == 0.0 and blurred.frame_current == 5


def shapes_of(scene, index: int = 0) -> list:
    return [state.shape for state in scene.lamps[index].motion]


def test_a_lamp_changes_its_shape(blurred, add, lamp, synced):
    growing = add("Growing", lamp(radius=0.5))
    animate(growing.data, "sdf_lamp.sphere.radius", 0.4, 0.5, 0.8)
    blurred.frame_set(5)
    scene = synced()
    assert scene.warnings == [] and scene.shutter is not None
    radii = [shape.radius for shape in shapes_of(scene)]
    # From 0.45 to 0.5 and to 0.65, each for the time around its own.
    assert len(radii) == 33
    np.testing.assert_allclose(radii[:32:31], (0.45 + 0.05 / 32, 0.65 - 0.15 / 32), atol=1e-6)
    assert np.all(np.diff(radii) >= 0.0) and scene.lamps[0].shape.radius == pytest.approx(0.5)
    growing.cycles.use_deform_motion = False
    assert synced().shutter is None


def ends(scene, name: str, value) -> list[float]:
    """A number of a lamp at the first and the last time of the shutter."""
    states = {lamp.name: lamp.motion for lamp in scene.lamps}[name]
    return [value(states[0]), value(states[-1])]


def test_expressions_and_emissions_change(blurred, add, lamp, synced):
    written = lamp("Written")
    written.sdf_lamp.source, written.sdf_lamp.expression = (
        "EXPRESSION",
        "size = slider(1, 0.5, 3)\nsphere(size) - box(size / 2)",
    )
    glowing = lamp("Glowing")
    glowing.sdf_lamp.emission.source = "SHELL"
    for data in (written, glowing):
        add(data.name, data)
    for data, name in ((written, "sdf_size"), (glowing, "sdf_emission.thickness")):
        for frame, value in ((4, 0.6), (6, 1.0)):
            data[name] = value
            data.keyframe_insert(f'["{name}"]', frame=frame)
    blurred.frame_set(5)
    scene = synced()
    assert scene.warnings == []
    ball = ends(scene, "Written", lambda state: state.shape.children[0].radius)
    thickness = ends(scene, "Glowing", lambda state: state.emission.numbers[0])
    for found in (ball, thickness):
        assert 0.6 < found[0] < 0.72 and 0.88 < found[1] < 1.0
    assert scene.lamps[0].motion[0].shape.formula() is scene.lamps[0].shape.formula()


def test_a_lamp_of_nodes_changes(blurred, add, lamp, synced):
    tree = bpy.data.node_groups.new("Shape", "SDFLIGHTS_NodeTree")
    ball, end = tree.nodes.new("SDFLIGHTS_Node_sphere"), tree.nodes.new("SDFLIGHTS_Node_output")
    tree.links.new(ball.outputs[0], end.inputs[0])
    for frame, radius in ((4, 0.5), (6, 0.9)):
        ball.value_radius = radius
        ball.keyframe_insert("value_radius", frame=frame)
    data = lamp()
    data.sdf_lamp.nodes, data.sdf_lamp.source = tree, "NODES"
    add("Nodes", data)
    blurred.frame_set(5)
    first, last = ends(synced(), "Nodes", lambda state: state.shape.radius)
    assert 0.5 < first < 0.65 < 0.75 < last < 0.9


def test_a_lamp_of_a_text_changes_in_the_steps_of_its_object(blurred, add, lamp, synced):
    text = add("Text", bpy.data.curves.new("Text", "FONT"))
    text.data.body = "O"
    for frame, (size, height) in ((4, (0.5, 0.1)), (6, (1.5, 0.3))):
        text.data.size, text.data.extrude = size, height
        text.data.keyframe_insert("size", frame=frame)
        text.data.keyframe_insert("extrude", frame=frame)
    data = lamp()
    data.sdf_lamp.source, data.sdf_lamp.object = "OBJECT", text
    add("Sign", data).cycles.motion_steps = 2
    blurred.frame_set(5)
    scene = synced()
    shapes = shapes_of(scene)[:-1]
    assert len({shape.profile for shape in shapes}) == 5  # the outline of the nearest of the times
    assert np.all(np.diff([shape.height for shape in shapes]) > 0.0) and scene.warnings == []


def test_nothing_moves_in_a_scene_that_stands_still(blurred, stage, synced):
    assert synced().shutter is None
    animate(stage, "location", (0.0, 0.0, 1.0), (0.0, 0.0, 2.0), (0.0, 0.0, 3.0))
    blurred.frame_set(5)
    assert synced().shutter is not None
    blurred.render.use_motion_blur = False
    assert synced().shutter is None


def test_what_is_not_blurred_is_seen_at_the_middle_of_the_shutter(blurred, add, lamp, synced):
    still, flying = add("Still", lamp()), add("Flying", lamp())
    lit = add("Lit", bpy.data.lights.new("Lit", "POINT"))
    for thing in (flying, lit):
        animate(thing, "location", (-2.0, 0.0, 1.0), (0.0, 0.0, 1.0), (2.0, 0.0, 1.0))
        thing.cycles.use_motion_blur = False
    blurred.render.motion_blur_position = "START"
    blurred.frame_set(5)
    scene = synced()
    assert scene.shutter is None and scene.warnings == []
    lamps = {item.name: item for item in scene.lamps}
    assert [round(lamps[thing.name].matrix[0, 3], 5) for thing in (still, flying)] == [0.0, 1.0]
    assert round(scene.lights[0].matrix[0, 3], 5) == 1.0
    assert flying.location.x == 0.0 and blurred.frame_current == 5


def test_an_object_that_comes_while_the_shutter_is_open_stands_still(blurred, add, quad, synced):
    square = add("Square", quad())
    animate(square, "location", (0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (2.0, 0.0, 0.0))
    animate(square, "hide_render", True, False, False)
    blurred.frame_set(5)
    assert all(instance.motion is None for instance in synced().instances)


def test_both_eyes_move(blurred, file, add, quad, pictures):
    add("Square", quad(), (0.0, 0.0, 1.0), (math.pi / 2, 0.0, 0.0))
    animate(file.camera, "location", (-1.0, -5.0, 1.0), (0.0, -5.0, 1.0), (1.0, -5.0, 1.0))
    blurred.render.use_multiview = True
    blurred.frame_set(5)
    assert bpy.ops.render.render() == {"FINISHED"}
    assert blurred.frame_current == 5
