# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The pass Vector is that of Cycles, and Blender's Vector Blur makes the same of it."""

import math

import bpy
import numpy as np
import pytest

from sdf_lights.blender.naming import ENGINE
from tests.blender.animated import animate, form, glowing_square, instances, lens

pytest.importorskip("_cycles")
HALF = math.pi / 2


@pytest.fixture
def shot(file, add, quad, material):
    """A glowing square, of which the pass Vector is rendered; its object."""
    file.layer.use_pass_vector = file.layer.use_pass_z = True
    return glowing_square(file, add, quad, material, (1.2, 0.8, 1.0), 64)


def moves(shot, **_):
    animate(shot, "location", (-1.0, 0.0, 1.0), (0.0, 0.0, 1.2), (1.0, 1.0, 0.6))
    shot.cycles.use_motion_blur = False  # is not asked


def turns(shot, **_):
    animate(shot, "rotation_euler", (HALF, -0.6, 0.0), (HALF, 0.4, 0.3), (HALF, 1.2, 0.0))


def camera(camera, **_):
    animate(camera, "rotation_euler", (HALF, 0.0, -0.15), (HALF, 0.1, 0.05), (HALF + 0.1, 0.0, 0.1))
    animate(camera, "location", (0.0, -5.0, 1.0), (0.3, -4.8, 1.0), (0.4, -4.0, 1.1))


def parallel(camera, shot, **_):
    camera.data.type, camera.data.ortho_scale = "ORTHO", 4.0
    moves(shot)
    if bpy.app.version >= (5, 1, 0):  # before, Cycles takes the camera that moves for one with a perspective
        camera_and_object(camera, shot)


def panorama(camera, shot, scene, **_):
    camera.data.type = "PANO"
    owner = camera.data if hasattr(camera.data, "panorama_type") else camera.data.cycles
    owner.panorama_type = "EQUIRECTANGULAR"
    camera.location.y, shot.scale = -2.0, (3.0, 2.0, 1.0)
    moves(shot)
    animate(camera, "rotation_euler", (HALF, 0.0, -0.1), (HALF, 0.1, 0.05), (HALF, 0.0, 0.1))


def camera_and_object(camera, shot, **_):
    moves(shot)
    animate(camera, "rotation_euler", (HALF, 0.0, -0.15), (HALF, 0.1, 0.05), (HALF + 0.1, 0.0, 0.1))


def form_of_what_moves(shot, **_):
    form(shot)
    moves(shot)


def small_instances(shot, **rest):
    shot.scale = (0.6, 0.5, 1.0)
    instances(shot, **rest)


def curves(shot, add, **_):
    """Thick hair that moves and bends."""
    data = bpy.data.hair_curves.new("Hair")
    data.add_curves([5] * 8)
    for index, point in enumerate(data.points):
        curve, place = divmod(index, 5)
        point.position = (0.3 * curve - 1.0 + 0.02 * place * place, 0.0, 0.3 * place)
        point.radius = 0.2  # no holes between them
    data.materials.append(shot.data.materials[0])
    shot.location.z = -3.0
    hair = add("Hair", data)
    animate(hair, "location", (-0.4, 0.0, 0.2), (0.0, 0.0, 0.2), (0.0, -0.5, 0.6))


def part_of_the_frame(scene, shot, **_):
    camera_and_object(scene.camera, shot)
    scene.render.use_border = True
    scene.render.border_min_x, scene.render.border_max_y = 0.25, 0.75


CASES = [
    moves,
    turns,
    camera,
    lens,
    parallel,
    panorama,
    form,
    form_of_what_moves,
    small_instances,
    curves,
    part_of_the_frame,
]


@pytest.fixture
def both(shot, file, pictures):
    """Function: the pictures of Cycles and of this engine at frame 5."""

    def run():
        file.scene.frame_set(5)
        found = []
        for file.scene.render.engine in ("CYCLES", ENGINE):
            bpy.ops.sdf_lights.cycles_settings_copy()
            file.scene.sdf_lights.device = "CPU"
            found.append(pictures())
        assert file.scene.frame_current == 5 and file.scene.frame_subframe == 0.0
        return found

    return run


@pytest.mark.parametrize("build", CASES, ids=[build.__name__ for build in CASES])
def test_vectors_are_those_of_cycles(shot, file, add, both, build):
    build(shot=shot, scene=file.scene, camera=file.camera, add=add, file=file)
    theirs, ours = (found["ViewLayer"] for found in both())
    seen = theirs["Depth"][..., 0] < 1e9
    # Where several things meet in a pixel, samples decide how much each of them counts.
    inside = seen.copy()
    for axis in (0, 1):
        for way in (-1, 1):
            inside &= np.roll(seen, way, axis)
    theirs, ours = theirs["Vector"].astype(float), ours["Vector"].astype(float)
    assert theirs.shape == ours.shape and theirs.shape[-1] == 4
    size = np.abs(theirs[inside]).max()
    difference = np.abs(ours - theirs).max(-1)[inside]
    print(build.__name__, size, difference.max() / size, inside.sum())
    assert size > 0.5 and inside.sum() > 10
    # A pixel has the mean over its samples, which are at other places.
    assert difference.max() < 0.02 * size
    assert (ours[inside].mean(0) - theirs[inside].mean(0)) == pytest.approx(0.0, abs=0.005 * size)


def pixels_far_away(file, ways: np.ndarray) -> np.ndarray:
    """Pixels (N, 2) at which Blender's camera shows directions (N, 3)."""
    graph = bpy.context.evaluated_depsgraph_get()
    camera, render = file.camera.evaluated_get(graph), file.scene.render
    shown = np.array(camera.calc_matrix_camera(graph, x=render.resolution_x, y=render.resolution_y))
    local = ways @ np.array(camera.matrix_world.to_3x3())
    clip = np.concatenate([local, np.zeros((len(local), 1))], 1) @ shown.T
    return (0.5 + 0.5 * clip[:, :2] / clip[:, 3:]) * (render.resolution_x, render.resolution_y)


@pytest.mark.parametrize("build", [camera, lens], ids=["camera", "lens"])
def test_the_background_is_infinitely_far(shot, file, add, pictures, build):
    """From Blender 5.1 on it has vectors, as in Cycles, which leaves out the division of the perspective there."""
    build(shot=shot, camera=file.camera)
    file.scene.frame_set(5)
    file.scene.sdf_lights.device, file.scene.sdf_lights.samples, file.scene.sdf_lights.filter = "CPU", 64, "BOX"
    found = pictures()["ViewLayer"]
    shown, empty = found["Vector"], found["Depth"][..., 0] > 1e9
    if bpy.app.version < (5, 1, 0):
        assert np.abs(shown[empty]).max() == 0.0
        return
    height, width = empty.shape
    y, x = np.nonzero(empty)
    graph = bpy.context.evaluated_depsgraph_get()
    shown_by = np.array(file.camera.calc_matrix_camera(graph, x=width, y=height))
    clip = np.stack([(x + 0.5) / width * 2.0 - 1.0, (y + 0.5) / height * 2.0 - 1.0, 0.0 * x, 0.0 * x + 1.0], 1)
    local = (clip @ np.linalg.inv(shown_by).T)[:, :3]
    ways = local @ np.array(file.camera.matrix_world.to_3x3()).T
    places = []
    for frame in (4, 5, 6):
        file.scene.frame_set(frame)
        places.append(pixels_far_away(file, ways))
    expected = np.concatenate([places[0] - places[1], places[1] - places[2]], 1)
    assert np.abs(expected).max() > 1.0
    assert np.abs(shown[empty] - expected).max() < 0.02 * np.abs(expected).max()


def test_the_pass_is_empty_where_motion_is_blurred(shot, file, both):
    moves(shot)
    file.scene.render.use_motion_blur = True
    for found in both():
        assert np.abs(found["ViewLayer"]["Vector"]).max() < 1e-9  # rounding


def test_nothing_else_of_the_picture_changes(shot, file, both):
    camera_and_object(file.camera, shot)
    plain = both()[1]["ViewLayer"]["Combined"]
    file.layer.use_pass_vector = False
    np.testing.assert_array_equal(both()[1]["ViewLayer"]["Combined"], plain)


def test_blenders_node_blurs_as_with_cycles(shot, file, both, compositor):
    """The Vector Blur node of the compositor makes the same picture of the passes of both engines."""
    camera_and_object(file.camera, shot)
    scene = file.scene
    tree, end = compositor
    layers, node = tree.nodes.new("CompositorNodeRLayers"), tree.nodes.new("CompositorNodeVecBlur")
    layers.scene = scene
    file.layer.update_render_passes()
    for name, socket in (("Image", "Image"), ("Vector", "Speed"), ("Depth", "Z")):
        into = next(item for item in node.inputs if item.identifier == socket)
        tree.links.new(layers.outputs[name], into)
    tree.links.new(node.outputs[0], end.inputs[0])
    theirs, ours = (found["Composite"]["Combined"][..., :3].astype(float) for found in both())
    plain = both()[1]["ViewLayer"]["Combined"][..., :3]
    changed = np.abs(theirs - plain).mean()
    print(changed, np.abs(ours - theirs).mean(), ours.mean() / theirs.mean())
    assert changed > 0.02
    assert ours.mean() == pytest.approx(theirs.mean(), rel=0.01)
    assert np.abs(ours - theirs).mean() < 0.1 * changed
