# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Tangents of triangles are those of Blender's MikkTSpace, of which Cycles has its own for triangles, too."""

import bmesh
import bpy
import numpy as np
import pytest

from sdf_lights.blender.sync.attributes import read
from sdf_lights.render.tangents import on_sphere, tangents

SHAPES = {
    "ball": lambda work: bmesh.ops.create_uvsphere(work, u_segments=24, v_segments=12, radius=1.0, calc_uvs=True),
    "icosphere": lambda work: bmesh.ops.create_icosphere(work, subdivisions=3, radius=1.0, calc_uvs=True),
    "cube": lambda work: bmesh.ops.create_cube(work, size=1.0, calc_uvs=True),
    "fin": lambda work: [
        bmesh.ops.create_grid(work, x_segments=3, y_segments=2, size=1.0, calc_uvs=True, matrix=matrix)
        for matrix in POSES
    ],
}
TEXTURES = {
    "as it is": lambda uv: uv,
    "turned": lambda uv: np.stack([1.7 * uv[:, 1], 0.3 - uv[:, 0]], axis=1),
    "mirrored in the middle": lambda uv: np.stack([np.abs(uv[:, 0] - 0.4), uv[:, 1]], axis=1),
}


def _poses():
    import mathutils

    return [mathutils.Matrix.Rotation(angle, 4, "X") for angle in (0.0, 1.0, 2.0)]


POSES = _poses()


@pytest.fixture
def triangles(registered):
    """Function: a mesh of triangles of a shape, with a texture."""

    def make(shape: str, texture: str, smooth: bool) -> bpy.types.Mesh:
        work = bmesh.new()
        work.loops.layers.uv.new("UVMap")
        SHAPES[shape](work)
        bmesh.ops.remove_doubles(work, verts=work.verts, dist=1e-5)
        bmesh.ops.triangulate(work, faces=work.faces)
        for face in work.faces:
            face.smooth = smooth
        mesh = bpy.data.meshes.new("Mesh")
        work.to_mesh(mesh)
        work.free()
        layer = mesh.uv_layers[0].uv
        layer.foreach_set("vector", TEXTURES[texture](read(layer, "vector", np.float32, 2)).astype(np.float32).ravel())
        return mesh

    return make


@pytest.mark.parametrize("smooth", [True, False])
@pytest.mark.parametrize("texture", TEXTURES)
@pytest.mark.parametrize("shape", SHAPES)
def test_tangents_of_triangles(triangles, shape, texture, smooth):
    mesh = triangles(shape, texture, smooth)
    mesh.calc_tangents(uvmap="UVMap")
    theirs = np.column_stack(
        [read(mesh.loops, "tangent", np.float32, 3), read(mesh.loops, "bitangent_sign", np.float32)]
    )
    corners = read(mesh.loops, "vertex_index", np.int32).reshape(-1, 3)
    normals = read(mesh.corner_normals, "vector", np.float32, 3).reshape(-1, 3, 3)
    uvs = read(mesh.uv_layers[0].uv, "vector", np.float32, 2).reshape(-1, 3, 2)
    ours = tangents(read(mesh.vertices, "co", np.float32, 3), corners, normals, uvs)
    np.testing.assert_allclose(ours.reshape(-1, 4), theirs, atol=1e-4)


def test_what_has_no_texture_gets_the_tangent_of_a_neighbour():
    positions = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], np.float32)
    corners = np.array([(0, 1, 2), (0, 2, 3)])
    uvs = np.array([[(0, 0), (0, 1), (-1, 1)], [(0, 0), (-1, 1), (0, 0)]], np.float32)
    found = tangents(positions, corners, None, uvs)
    np.testing.assert_allclose(found[:, 0], [(0, -1, 0, 1)] * 2, atol=1e-6)
    np.testing.assert_allclose(found[1, 2], (1, 0, 0, -1))
    assert tangents(positions, corners[:0], None, uvs[:0]).shape == (0, 3, 4)


def test_without_uvs_tangents_go_round_the_axis():
    angle = np.linspace(0.3, 0.9, 3)
    positions = np.stack([np.cos(angle), np.sin(angle), [0.1, 0.2, -0.3]], axis=1).astype(np.float32)
    places = on_sphere(positions)
    np.testing.assert_allclose(places[:, 0], 0.25 + angle / (2.0 * np.pi), atol=1e-6)
    np.testing.assert_allclose(places[:, 1], 0.5 + np.arctan([0.1, 0.2, -0.3]) / np.pi, atol=1e-6)
    assert (on_sphere(np.zeros((1, 3))) == 0.0).all()
