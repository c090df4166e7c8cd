# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Panoramas and pairs of eyes show what they show in Cycles: a ball of colours around the camera, looked at without
noise."""

import contextlib
import math

import bpy
import numpy as np
import pytest

from sdf_lights.blender.naming import ENGINE

openimageio = pytest.importorskip("OpenImageIO")
pytest.importorskip("_cycles")

POLYNOMIAL = {f"fisheye_polynomial_k{i}": value for i, value in enumerate((-0.02, -0.05, 0.0004, -3e-5, 1e-6))}

# Settings of the camera, and whether there is a picture everywhere.
CASES = {
    "equirectangular": (dict(panorama_type="EQUIRECTANGULAR", latitude_min=-0.9, longitude_max=2.0), True),
    "equirectangular, shifted": (dict(panorama_type="EQUIRECTANGULAR", shift_x=0.1, shift_y=-0.05), True),
    "equidistant": (dict(panorama_type="FISHEYE_EQUIDISTANT", fisheye_fov=3.5), False),
    "equidistant, shifted": (dict(panorama_type="FISHEYE_EQUIDISTANT", fisheye_fov=3.0, shift_x=0.2), False),
    "equisolid": (dict(panorama_type="FISHEYE_EQUISOLID", fisheye_fov=2.6, fisheye_lens=9.0), False),
    "equisolid, upright": (
        dict(panorama_type="FISHEYE_EQUISOLID", fisheye_fov=3.1, fisheye_lens=12.0, sensor_fit="VERTICAL"),
        False,
    ),
    "polynomial": (dict(panorama_type="FISHEYE_LENS_POLYNOMIAL", fisheye_fov=1.4, **POLYNOMIAL), False),
    "mirror ball": (dict(panorama_type="MIRRORBALL"), False),
    "face of a cube": (dict(panorama_type="EQUIANGULAR_CUBEMAP_FACE"), True),
    "cylinder": (
        dict(
            panorama_type="CENTRAL_CYLINDRICAL",
            central_cylindrical_range_u_min=-2.0,
            central_cylindrical_range_v_max=0.8,
            central_cylindrical_radius=1.3,
        ),
        True,
    ),
}


@pytest.fixture
def ball(file, add, material):
    """A ball of radius 3 whose emission is its position, around a camera that looks somewhere."""
    bpy.ops.preferences.addon_enable(module="cycles")
    made, tree, output = material("Colours")
    emission = tree.nodes.new("ShaderNodeEmission")
    attribute = tree.nodes.new("ShaderNodeUVMap")
    tree.links.new(attribute.outputs[0], emission.inputs["Color"])
    tree.links.new(emission.outputs[0], output)
    bpy.ops.mesh.primitive_uv_sphere_add(segments=96, ring_count=48, radius=3.0)
    obj = bpy.context.object
    # Where a vertex is, seen from the middle: a UV map that is continuous all around.
    corners = np.array([obj.data.vertices[loop.vertex_index].co for loop in obj.data.loops])
    uv = np.stack([0.5 + corners[:, 0] / 6.5, 0.5 + corners[:, 2] / 6.5], -1)
    obj.data.uv_layers.active.uv.foreach_set("vector", uv.ravel())
    obj.data.materials.append(made)
    scene = file.scene
    scene.cycles.samples, scene.cycles.use_denoising, scene.cycles.use_adaptive_sampling = 64, False, False
    scene.cycles.pixel_filter_type, scene.sdf_lights.filter, scene.sdf_lights.filter_width = "BOX", "BOX", 1.0
    scene.sdf_lights.samples, scene.sdf_lights.device = 64, "CPU"
    file.camera.location, file.camera.rotation_euler = (0.3, -0.2, 0.1), (1.3, 0.2, 0.5)
    file.camera.data.type = "PANO"
    return scene


def both(scene, pictures) -> list[np.ndarray]:
    """(height, width, RGBA) here and in Cycles."""
    found = []
    for scene.render.engine in (ENGINE, "CYCLES"):
        found.append(pictures()["ViewLayer"]["Combined"].astype(float))
    return found


@pytest.mark.parametrize(("name", "transparent"), [(name, False) for name in CASES] + [("mirror ball", True)])
def test_panoramas_are_those_of_cycles(ball, file, pictures, name, transparent):
    changes, whole = CASES[name]
    for key, value in changes.items():
        setattr(file.camera.data, key, value)
    ball.render.film_transparent = transparent
    ours, cycles = both(ball, pictures)
    empty = cycles[..., :3].max(axis=2) == 0.0
    assert whole == (not empty.any())
    # Samples of a pixel at the edge of the picture are counted by both, but drawn elsewhere.
    np.testing.assert_allclose(ours[..., 3], cycles[..., 3], atol=0.1)
    difference = np.abs(ours - cycles)[..., :3]
    assert difference.mean() < 0.002 and (difference.max(axis=2) > 0.02).mean() < (0.001 if whole else 0.1)
    assert difference[empty].max(initial=0.0) <= 0.03


# -- views -------------------------------------------------------------------------------------------------------------


@pytest.fixture
def views(file, tmp_path):
    """Function: render, and read back {view: (height, width, RGB)}."""

    def run() -> dict[str, np.ndarray]:
        render = file.scene.render
        with contextlib.suppress(AttributeError):  # new in 5.0
            render.image_settings.media_type = "IMAGE"
        render.image_settings.file_format, render.image_settings.color_depth = "OPEN_EXR", "32"
        render.image_settings.views_format = "INDIVIDUAL"
        folder = tmp_path / render.engine
        render.filepath = str(folder / "view")
        bpy.ops.render.render(write_still=True)
        found = {}
        for path in folder.iterdir():
            pixels = openimageio.ImageInput.open(str(path)).read_image(openimageio.FLOAT)
            found[path.stem.rpartition("_")[2]] = np.array(pixels)[..., :3].astype(float)
            path.unlink()
        return found

    return run


STEREO = {
    "off axis": dict(type="PERSP", convergence_mode="OFFAXIS"),
    "parallel": dict(type="PERSP", convergence_mode="PARALLEL", pivot="CENTER"),
    "toe in": dict(type="PERSP", convergence_mode="TOE", pivot="RIGHT"),
    "panorama": dict(type="PANO", use_spherical_stereo=True, convergence_mode="OFFAXIS"),
    "panorama, parallel": dict(type="PANO", use_spherical_stereo=True, convergence_mode="PARALLEL"),
    "panorama, poles": dict(
        type="PANO", use_spherical_stereo=True, use_pole_merge=True, pole_merge_angle_from=0.2, pole_merge_angle_to=0.7
    ),
    "panorama, not spherical": dict(type="PANO", convergence_mode="PARALLEL"),
}


@pytest.mark.parametrize("name", STEREO)
def test_both_eyes_are_those_of_cycles(ball, file, views, name):
    ball.render.use_multiview = True
    data, stereo = file.camera.data, file.camera.data.stereo
    stereo.interocular_distance, stereo.convergence_distance = 0.8, 1.2
    data.panorama_type = "EQUIRECTANGULAR"
    for key, value in STEREO[name].items():
        setattr(data if key == "type" else stereo, key, value)
    found = {}
    for ball.render.engine in (ENGINE, "CYCLES"):
        found[ball.render.engine] = views()
    ours, cycles = found.values()
    assert set(ours) == set(cycles) == {"L", "R"}
    assert np.abs(ours["L"] - ours["R"]).mean() > 0.01
    for view in ours:
        assert ours[view].mean() > 0.1
        assert np.abs(ours[view] - cycles[view]).mean() < 0.002, view


def test_the_eyes_of_a_mirror_ball_are_not_exchanged(ball, file, views):
    """Cycles gives the left eye's picture to the right view, and that of the right eye to the left one."""
    ball.render.use_multiview = True
    data, stereo = file.camera.data, file.camera.data.stereo
    data.type, data.panorama_type = "PANO", "MIRRORBALL"
    stereo.use_spherical_stereo, stereo.convergence_mode, stereo.interocular_distance = True, "PARALLEL", 0.8
    found = {}
    for ball.render.engine in (ENGINE, "CYCLES"):
        found[ball.render.engine] = views()
    ours, cycles = found.values()
    for view, other in ("LR", "RL"):
        assert np.abs(ours[view] - cycles[other]).mean() < 0.002, view
        assert np.abs(ours[view] - cycles[view]).mean() > 0.005, view


def test_views_have_cameras_of_their_own(ball, file, views, add):
    """Of any number of views, each is seen by the camera whose name has the view's suffix."""
    ball.render.use_multiview, ball.render.views_format = True, "MULTIVIEW"
    file.camera.data.type = "PERSP"
    file.camera.name = "Eye_L"
    ball.render.views["left"].camera_suffix, ball.render.views["right"].camera_suffix = "_L", "_R"
    other = add("Eye_R", file.camera.data, (0.0, 0.0, 0.0), (1.3, 0.2, 0.5 + math.pi))
    bpy.context.view_layer.update()
    found = {}
    for ball.render.engine in (ENGINE, "CYCLES"):
        found[ball.render.engine] = views()
    ours, cycles = found.values()
    assert set(ours) == set(cycles) and len(ours) == 2 and other.name == "Eye_R"
    for view in ours:
        assert np.abs(ours[view] - cycles[view]).mean() < 0.002, view
    first, second = ours.values()
    assert np.abs(first - second).mean() > 0.05


def test_one_view_of_several(ball, file, views):
    """A view that is switched off has no picture."""
    ball.render.use_multiview, ball.render.views_format = True, "MULTIVIEW"
    ball.render.views["right"].use = False
    file.camera.data.type = "PERSP"
    ball.render.engine = ENGINE
    found = views()
    assert len(found) == 1 and next(iter(found.values())).mean() > 0.1
