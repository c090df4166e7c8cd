# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Rays of the reference: the hierarchy against brute force, Embree against the hierarchy, and surfaces at hits."""

import numpy as np
import pytest

from sdf_lights.render.reference.geometry import Geometry, moller_trumbore
from sdf_lights.render.scene import Camera, Instance, Ray, Scene
from support import scenes


def rays(count, seed=0):
    rng = np.random.default_rng(seed)
    directions = rng.normal(size=(count, 3))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    return np.array([0.0, 0.0, 1.5]) + rng.uniform(-1, 1, (count, 3)), directions


def test_hierarchy_finds_what_brute_force_finds():
    geometry = Geometry(scenes.instances(), use_embree=False)
    origins, directions = rays(100)
    corners = geometry._hierarchy.corners
    t, _, _ = moller_trumbore(
        np.repeat(origins, len(corners), 0), np.repeat(directions, len(corners), 0), np.tile(corners, (100, 1, 1))
    )
    brute = np.where(t > 0.0, t, np.inf).reshape(100, -1).min(1)
    hits = geometry.intersect(origins, directions, np.full(100, np.inf), np.full(100, int(Ray.ALL)))
    np.testing.assert_array_equal(hits.distance, brute)
    assert 0.5 < hits.found.mean() < 1.0


@pytest.mark.parametrize("name", ["instances", "depth_of_field"])
def test_embree_agrees_with_the_hierarchy(name):
    scene = scenes.SCENES[name]()
    slow, fast = Geometry(scene, use_embree=False), Geometry(scene, use_embree=True)
    assert fast.rays is not None, scene.warnings
    origins, directions = rays(3000)
    far, masks = np.full(3000, 3.0), np.full(3000, int(Ray.CAMERA))
    a, b = (geometry.intersect(origins, directions, far, masks) for geometry in (slow, fast))
    same = (a.instance == b.instance) & (a.triangle == b.triangle)
    assert same.mean() > 0.999  # in float32 a ray through an edge may meet the neighbour
    found = same & a.found
    # Some roundings of coordinates of up to 4 metres in float32.
    np.testing.assert_allclose(b.distance[found], a.distance[found], rtol=0.0, atol=4e-6)
    np.testing.assert_allclose(b.u[found], a.u[found], atol=1e-4)


@pytest.mark.parametrize("use_embree", [False, True])
def test_objects_are_hidden_from_rays_they_are_not_visible_to(use_embree):
    scene = Scene(
        Camera(np.eye(4)),
        1,
        1,
        meshes=[scenes.quad()],
        materials=[scenes.diffuse((1, 1, 1))],
        instances=[
            Instance(0, scenes.translation(0, 0, 1), (0,), visibility=Ray.DIFFUSE),
            Instance(0, np.eye(4), (0,)),
        ],
    )
    geometry = Geometry(scene, use_embree)
    origins, directions = np.array([[0.1, 0.2, 2.0]] * 2), np.array([[0.0, 0.0, -1.0]] * 2)
    hits = geometry.intersect(origins, directions, np.full(2, np.inf), np.array([int(Ray.CAMERA), int(Ray.DIFFUSE)]))
    np.testing.assert_allclose(hits.distance, [2.0, 1.0], rtol=1e-6)
    assert hits.instance.tolist() == [1, 0]


def test_no_geometry():
    geometry = Geometry(Scene(Camera(np.eye(4)), 1, 1))
    hits = geometry.intersect(np.zeros((2, 3)), np.eye(3)[:2], np.full(2, np.inf), np.full(2, 31))
    assert not hits.found.any()


def test_normals_point_outwards_and_positions_lie_on_the_surface_whatever_the_matrix():
    """Boxes and balls stretched, sheared and mirrored: from outside, no hit is on the back."""
    scene = scenes.instances()
    geometry = Geometry(scene, use_embree=False)
    origins, directions = rays(4000, 1)
    origins[:, 1] = -1.9
    hits = geometry.intersect(origins, directions, np.full(4000, np.inf), np.full(4000, 31))
    keep = hits.instance >= 5  # not the walls
    hits = type(hits)(*(value[keep] for value in vars(hits).values()))
    surface = geometry.surface(hits, directions[keep])
    assert keep.sum() > 100 and not surface.backfacing.any()
    on_ray = origins[keep] + hits.distance[:, None] * directions[keep]
    np.testing.assert_allclose(surface.position, on_ray, atol=1e-12)
    np.testing.assert_allclose(np.linalg.norm(surface.ns, axis=1), 1.0)
    # Of a ball, a quadric under its matrix, the interpolated normal is near that of the ellipsoid.
    ball = surface.smooth
    for index in np.unique(surface.instance[ball]):
        rows = ball & (surface.instance == index)
        inverse = np.linalg.inv(scene.instances[index].matrix)
        local = surface.position[rows] @ inverse[:3, :3].T + inverse[:3, 3]
        exact = local @ inverse[:3, :3]
        exact /= np.linalg.norm(exact, axis=1)[:, None]
        assert (np.sum(exact * surface.ns[rows], 1) > 0.99).all()
