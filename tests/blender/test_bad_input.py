# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Files with something wrong in them, at F12: it is named, nothing breaks, and the rest is rendered."""

import bpy
import numpy as np
import pytest

NAN = float("nan")


@pytest.fixture(params=["REFERENCE", "CPU"])
def render(request, file, pictures, capfd):
    """Function: the RGB of the picture, which is finite, and the warnings that Blender shows. For each back end."""
    file.scene.sdf_lights.device = request.param

    def run() -> tuple[np.ndarray, list[str]]:
        capfd.readouterr()
        picture = pictures()["ViewLayer"]["Combined"]
        assert np.isfinite(picture).all()
        output = capfd.readouterr()
        assert "Traceback" not in output.out + output.err
        return picture[..., :3], [line for line in output.out.splitlines() if line.startswith("Warning: ")]

    return run


def test_empty_scene_is_black(render):
    picture, told = render()
    assert (picture == 0.0).all() and told == []


def test_no_camera(file, stage):
    file.scene.camera = None
    with pytest.raises(RuntimeError, match="no camera"):
        bpy.ops.render.render()


@pytest.mark.parametrize("change", [dict(location=(NAN, 0.0, 0.0)), dict(scale=(0.0, 0.0, 0.0))])
def test_camera_that_is_nowhere(file, stage, change):
    for name, value in change.items():
        setattr(file.camera, name, value)
    with pytest.raises(RuntimeError, match="Camera 'Camera'") as caught:
        bpy.ops.render.render()
    assert "Traceback" not in str(caught.value)


@pytest.mark.parametrize(
    "place", [dict(scale=(0.0, 0.0, 0.0)), dict(scale=(1.0, 0.0, 1.0)), dict(location=(0.0, NAN, 0.0))]
)
@pytest.mark.parametrize("kind", ["lamp", "light"])
def test_lamp_without_extent_or_place(render, stage, add, lamp, kind, place):
    """Of Blender's lights only those with an area have an extent that a scale can take away."""
    whole, told = render()
    assert told == []
    if kind == "light" and "scale" in place:
        data = bpy.data.lights.new("Wrong", "AREA")
    else:
        data = lamp() if kind == "lamp" else bpy.data.lights.new("Wrong", "POINT")
    add("Wrong", data, **place)
    picture, told = render()
    assert (picture == whole).all()
    assert len(told) == 1 and "'Wrong'" in told[0]


def test_objects_without_place_or_faces(render, stage, add, quad):
    whole, told = render()
    add("Nowhere", quad(), location=(NAN, 0.0, 0.0))
    add("Hollow", bpy.data.meshes.new("Hollow"))
    loose = bpy.data.meshes.new("Loose")
    loose.from_pydata([(0, 0, 0), (1, 0, 0)], [(0, 1)], [])
    add("Loose", loose)
    picture, told = render()
    assert (picture == whole).all()
    assert len(told) == 1 and "Object 'Nowhere'" in told[0]


def test_parameters_that_make_no_shape(render, stage, add, lamp):
    whole, _ = render()
    add("Thick", lamp(shape="BOX_FRAME", thickness=3.0))
    wrong = lamp()
    wrong.sdf_lamp.source, wrong.sdf_lamp.expression = "EXPRESSION", "sphere(1"
    add("Wrong", wrong)
    picture, told = render()
    assert (picture == whole).all()
    assert len(told) == 2 and "'Thick'" in told[0] and "'Wrong'" in told[1]


@pytest.fixture
def textured(stage, material):
    """The image texture node of the floor's material; its image some tests delete."""
    made, tree, output = material()
    diffuse, texture = tree.nodes.new("ShaderNodeBsdfDiffuse"), tree.nodes.new("ShaderNodeTexImage")
    tree.links.new(texture.outputs["Color"], diffuse.inputs["Color"])
    tree.links.new(diffuse.outputs[0], output)
    bpy.data.objects["Floor"].data.materials.append(made)
    texture.image = bpy.data.images.new("Paint", 4, 4)
    return texture


def test_image_whose_file_is_gone_is_magenta(render, textured, tmp_path):
    textured.image.filepath_raw, textured.image.file_format = str(tmp_path / "paint.png"), "PNG"
    textured.image.save()
    textured.image = bpy.data.images.load(str(tmp_path / "paint.png"))
    (tmp_path / "paint.png").unlink()
    textured.image.reload()
    picture, told = render()
    assert (picture[0, :, [0, 2]] > 0.0).all() and (picture[0, :, 1] == 0.0).all()
    assert len(told) == 1 and "'paint.png'" in told[0]


def test_image_that_was_removed(render, textured):
    """As Cycles shows a node without an image: magenta too."""
    bpy.data.images.remove(textured.image)
    picture, told = render()
    assert (picture[0, :, [0, 2]] > 0.0).all() and (picture[0, :, 1] == 0.0).all()


def test_material_whose_nodes_are_gone_is_black(render, stage, material):
    made, tree, _ = material("Bare")
    bpy.data.objects["Floor"].data.materials.append(made)
    tree.nodes.clear()
    picture, told = render()
    assert (picture[0] == 0.0).all() and picture.max() > 0.0
    assert len(told) == 1 and "'Bare'" in told[0]


def test_material_that_does_not_use_nodes(render, stage):
    made = bpy.data.materials.new("Plain")
    made.use_nodes, made.diffuse_color = False, (0.8, 0.4, 0.0, 1.0)
    if made.use_nodes:
        pytest.skip("this Blender has no materials without nodes")
    bpy.data.objects["Floor"].data.materials.append(made)
    picture, told = render()
    assert told == []
    assert picture[0, :, 1] == pytest.approx(0.5 * picture[0, :, 0]) and (picture[0, :, 2] == 0.0).all()


def test_lamp_inside_a_wall_and_around_the_camera(file, render, add, lamp):
    bpy.ops.mesh.primitive_cube_add(location=(0.0, 0.0, 1.0))
    add("Inside", lamp(radius=0.25), location=(0.0, 0.0, 1.0))
    picture, _ = render()
    assert picture.max() == 0.0
    add("Around", lamp(radius=2.0), location=tuple(file.camera.location))
    picture, told = render()
    assert picture.min() > 0.0 and told == []


def test_lamp_half_in_a_wall(file, render, stage):
    """The floor cuts a ball: what is left is as bright as half a ball of half the power; lower down nothing is left.

    The tolerance is four standard deviations of the noisier back end, 0.63 % each, as found with twelve seeds.
    """
    file.scene.sdf_lights.samples = 64
    stage.location.z = 0.0
    cut, told = render()
    assert told == []
    stage.data.energy *= 0.5
    stage.data.sdf_lamp.source = "EXPRESSION"
    stage.data.sdf_lamp.expression = "intersection(sphere(0.4), translate(box((1, 1, 1)), (0, 0, 1)))"
    half, _ = render()
    assert cut.mean() == pytest.approx(half.mean(), rel=0.025)
    stage.data.sdf_lamp.source, stage.location.z = "PRIMITIVE", -0.5
    assert (render()[0] == 0.0).all()
