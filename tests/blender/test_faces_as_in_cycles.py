# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes as artists leave them: scaled, with faces in the same place, smooth with few faces. They look as in Cycles."""

import math

import bpy
import numpy as np
import pytest

pytest.importorskip("_cycles")


@pytest.fixture
def lit(file, add, material):
    """Function: a mesh of a plain material, under a sun."""

    def run(mesh, angles, **place):
        if not mesh.materials:
            made, tree, output = material()
            tree.links.new(tree.nodes.new("ShaderNodeBsdfDiffuse").outputs[0], output)
            mesh.materials.append(made)
        sun = bpy.data.lights.new("Sun", "SUN")
        sun.energy, sun.angle = 3.0, 0.1
        add("Sun", sun, rotation=angles)
        return add("Thing", mesh, **place)

    return run


def assert_means_agree(ours: np.ndarray, theirs: np.ndarray, most: float = 0.01) -> None:
    """The means of the pictures, and of blocks of 4 × 4 pixels, agree."""
    ours, theirs = ours[..., :3].mean(-1), theirs[..., :3].mean(-1)
    assert theirs.mean() > 0.0
    assert ours.mean() == pytest.approx(theirs.mean(), rel=most)
    blocks = [picture.reshape(4, 4, 6, 4).mean((1, 3)) for picture in (ours, theirs)]
    assert np.abs(blocks[0] - blocks[1]).mean() < 2.0 * most * theirs.mean()


@pytest.mark.parametrize("instances", [1, 2])
def test_normal_maps_of_scaled_flat_faces(render, lit, add, quad, material, instances):
    made, tree, output = material()
    bsdf, mapped = tree.nodes.new("ShaderNodeBsdfDiffuse"), tree.nodes.new("ShaderNodeNormalMap")
    mapped.inputs["Color"].default_value = (0.9, 0.3, 0.8, 1.0)
    tree.links.new(mapped.outputs[0], bsdf.inputs["Normal"])
    tree.links.new(bsdf.outputs[0], output)
    mesh = quad()
    mesh.materials.append(made)
    lit(mesh, (0.3, 0.9, 0.0), scale=(4.0, 2.5, 1.0), location=(0.0, 0.0, -0.5))
    if instances > 1:
        add("Other", mesh, (0.0, 4.0, 1.0), (1.2, 0.3, 0.0), (5.0, 1.5, 1.0))
    assert_means_agree(*render(64))


@pytest.mark.parametrize("together", [True, False])
@pytest.mark.parametrize("tilt", [0.0, 0.4])
def test_faces_in_the_same_place_hide_light_from_each_other(render, lit, add, together, tilt):
    """Left two faces, right one. Of level faces no light comes to any of two; of tilted ones that is left to
    rounding."""
    left = [(-3, -2, 0), (0, -2, 0), (0, 2, 0), (-3, 2, 0)]
    right = [(0, -2, 0), (3, -2, 0), (3, 2, 0), (0, 2, 0)]
    mesh, other = bpy.data.meshes.new("Floor"), bpy.data.meshes.new("Other")
    mesh.from_pydata(left + right + left * together, [], [(0, 1, 2, 3), (4, 5, 6, 7)] + [(11, 10, 9, 8)] * together)
    other.from_pydata(left, [], [(3, 2, 1, 0)])
    lit(mesh, (0.3, 0.2, 0.0), rotation=(tilt, 0.0, 0.0))
    if not together:
        other.materials.append(mesh.materials[0])
        add("Other", other, rotation=(tilt, 0.0, 0.0))
    ours, theirs = render(64)
    if tilt == 0.0:
        assert_means_agree(ours, theirs)
        lit_side, dark_side = ours[:7, 14:22, 0].mean(), ours[:7, 2:10, 0].mean()
        assert dark_side < 0.02 * lit_side
    else:
        assert_means_agree(ours[:, 13:].repeat(24, 1)[:, :24], theirs[:, 13:].repeat(24, 1)[:, :24])


@pytest.mark.parametrize("instances", [1, 2])
def test_light_ends_smoothly_on_smooth_faces(file, render, lit, add, instances):
    bpy.ops.mesh.primitive_uv_sphere_add(segments=8, ring_count=5, radius=1.6)
    bpy.ops.object.shade_smooth()
    mesh = bpy.context.object.data
    bpy.data.objects.remove(bpy.context.object)
    objects = [lit(mesh, (math.pi / 2, 0.0, -2.0), location=(0.0, 0.0, 1.0), scale=(1.0, 1.2, 0.8))]
    objects += [add("Other", mesh, (9.0, 30.0, 1.0)) for _ in range(instances - 1)]
    ours, theirs = render(512)
    assert_means_agree(ours, theirs)
    for each in objects:
        each.shadow_terminator_geometry_offset = 0.0
    plain = render(512)
    assert_means_agree(*plain)
    assert theirs[..., 0].mean() > 1.05 * plain[1][..., 0].mean()  # it makes a difference
