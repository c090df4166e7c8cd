# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Rays through Embree against brute force in float64, for meshes in the world and by reference, under any transform."""

import dataclasses
import subprocess
import sys

import numpy as np
import pytest

from sdf_lights import jit
from sdf_lights.jit import block_dtype, fill_table, kernel, new_tables
from sdf_lights.render.cpu.accelerator import accelerator_of
from sdf_lights.render.kernels import rays
from sdf_lights.render.scene import Camera, Instance, Ray, Scene
from support import scenes

pytestmark = pytest.mark.skipif(not jit.AVAILABLE, reason="Numba is not installed")

MIRRORED = scenes.translation(0.3, -0.2, 0.1) @ scenes.rotation("x", 40) @ scenes.scaling(-1.5, 0.7, 2.0)


class Probe:
    def __init__(self, instances, meshes, transparent=(False,), kept=None):
        scene = Scene(Camera(np.eye(4)), 1, 1, instances=instances, meshes=meshes, kept=kept)
        self.accelerator = accelerator_of(scene, np.array(transparent))
        self.block = np.zeros(1, block_dtype({}, rays.SCALARS))
        self.accelerator.fill(self.block)
        self.workspace = np.zeros(1, block_dtype({"ray": rays.RAY}))
        self._ray = new_tables({"ray": rays.RAY}, {"ray": 1})["ray"]
        fill_table(self.workspace, "ray", self._ray)

    def hits(self, origins, directions, mask=int(Ray.CAMERA)):
        out = np.zeros((len(origins), 4))
        _trace(self.block, self.workspace, origins, directions, mask, out)
        return out


@kernel
def _trace(blocks, workspaces, origins, directions, mask, out):
    block, workspace = blocks[0], workspaces[0]
    for i in range(len(origins)):
        o = (origins[i, 0], origins[i, 1], origins[i, 2])
        d = (directions[i, 0], directions[i, 1], directions[i, 2])
        out[i, 3] = rays.occluded(block, workspace, o, d, 0.0, np.inf, mask)
        out[i, 0] = -1.0
        if rays.intersect(block, workspace, o, d, 0.0, np.inf, mask):
            ray = rays.ray_table(workspace)[0]
            out[i, 0] = rays.hit_instance(ray)
            out[i, 1] = ray.primitive
            out[i, 2] = ray.t_far


def random_rays(count, seed=1):
    rng = np.random.default_rng(seed)
    origins = rng.normal(size=(count, 3))
    origins *= 5.0 / np.linalg.norm(origins, axis=1, keepdims=True)
    directions = rng.uniform(-1.5, 1.5, (count, 3)) - origins
    return origins, directions / np.linalg.norm(directions, axis=1, keepdims=True)


def brute_force(origins, directions, corners):
    """Distance to the nearest of (T, 3, 3) triangles, ∞ for none (Möller and Trumbore 1997)."""
    e1, e2 = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    p = np.cross(directions[:, None], e2)
    determinant = (p * e1).sum(-1)
    s = origins[:, None] - corners[:, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        u = (p * s).sum(-1) / determinant
        q = np.cross(s, e1)
        v = (q * directions[:, None]).sum(-1) / determinant
        t = (q * e2).sum(-1) / determinant
    return np.where((u >= 0) & (v >= 0) & (u + v <= 1) & (t > 0), t, np.inf).min(1)


@pytest.mark.parametrize("copies", [1, 2], ids=["baked", "instanced"])
@pytest.mark.parametrize("matrix", [np.eye(4), MIRRORED], ids=["identity", "mirrored"])
def test_nearest_hit_is_that_of_brute_force(copies, matrix):
    mesh = scenes.sphere(columns=14, rows=8)
    far = scenes.translation(0, 0, 1000.0)
    probe = Probe([Instance(0, matrix, (0,)), Instance(0, far, (0,))][:copies], [mesh])
    origins, directions = random_rays(4000)
    corners = (mesh.positions.astype(float) @ matrix[:3, :3].T + matrix[:3, 3])[mesh.triangles]
    expected = brute_force(origins, directions, corners)
    found = probe.hits(origins, directions)
    hit = found[:, 0] == 0
    # Only rays within a few float32 roundings of a silhouette may differ.
    assert np.mean(hit != np.isfinite(expected)) < 2e-3
    both = hit & np.isfinite(expected)
    assert both.mean() > 0.2
    assert np.allclose(found[both, 2], expected[both], rtol=2e-5)
    assert np.array_equal(found[:, 3] != 0, found[:, 0] >= 0)


def test_rays_only_see_what_is_visible_to_their_kind():
    mesh = scenes.quad()
    above = scenes.translation(0, 0, 1)
    hidden = Instance(0, above, (0,), visibility=Ray.ALL & ~Ray.CAMERA)
    probe = Probe([hidden, Instance(1, np.eye(4), (0,))], [mesh, scenes.quad()])
    down = np.array([[0.1, 0.2, 3.0]]), np.array([[0.0, 0.0, -1.0]])
    assert probe.hits(*down, mask=int(Ray.CAMERA))[0, 0] == 1
    assert probe.hits(*down, mask=int(Ray.DIFFUSE))[0, 0] == 0


def test_shadow_rays_keep_opaque_and_transparent_apart():
    probe = Probe(
        [Instance(0, np.eye(4), (1,)), Instance(1, scenes.translation(0, 0, 5.0), (0,))],
        [scenes.quad(), scenes.quad()],
        transparent=(False, True),
    )
    up = np.array([[0.1, 0.2, 1.0]]), np.array([[0.0, 0.0, 1.0]])
    down = up[0], -up[1]
    assert probe.hits(*up, mask=rays.SHADOW_OPAQUE)[0, 0] == 1
    assert probe.hits(*down, mask=rays.SHADOW_OPAQUE)[0, 0] == -1
    assert probe.hits(*down, mask=rays.SHADOW_TRANSPARENT)[0, 0] == 0


def test_mesh_without_triangles_is_skipped():
    empty = scenes.quad()
    empty.triangles = empty.triangles[:0]
    probe = Probe([Instance(0, np.eye(4), (0,))], [empty])
    assert probe.hits(np.array([[0.0, 0, 3]]), np.array([[0.0, 0, -1]]))[0, 0] == -1


@pytest.mark.slow
def test_a_thousand_instances_of_a_hundred_thousand_triangles_fit_in_memory():
    """By reference: 10⁸ triangles would take gigabytes, one mesh and a thousand boxes take next to nothing."""
    mesh = scenes.sphere(columns=250, rows=201)
    assert len(mesh.triangles) >= 100_000
    rng = np.random.default_rng(0)
    places = [scenes.translation(*offset) for offset in rng.uniform(-50, 50, (1000, 3))]
    before = _resident()
    probe = Probe([Instance(0, place, (0,)) for place in places], [mesh])
    assert _resident() - before < 300e6
    origins, directions = random_rays(2000)
    assert (probe.hits(origins * 20.0, directions)[:, 0] >= 0).any()


def _resident() -> float:
    with open("/proc/self/statm", encoding="ascii") as file:
        return int(file.read().split()[1]) * 4096.0


def test_what_is_kept_gives_the_same_hits():
    """The next render of the same things has all of it; where something has moved, meshes that are shared keep
    theirs."""
    shared, alone, kept = scenes.sphere(columns=14, rows=8), scenes.sphere(columns=10, rows=6), {}
    origins, directions = random_rays(2000)

    def scene(shift):
        places = (scenes.translation(-1.0, 0.0, 0.0), MIRRORED, scenes.translation(0.0, 1.0 + shift, 0.0))
        return [Instance(mesh, matrix, (0,)) for mesh, matrix in zip((0, 0, 1), places)]

    first, again = (Probe(scene(0.0), [shared, alone], kept=kept) for _ in range(2))
    assert again.accelerator is first.accelerator
    moved = Probe(scene(0.3), [shared, alone], kept=kept)
    assert moved.accelerator is not first.accelerator
    assert [inner.handle for inner in moved.accelerator._inner.values()] == [
        inner.handle for inner in first.accelerator._inner.values()
    ]
    before = first.hits(origins, directions)
    del first, again  # its structures, of which the others use some
    expected = Probe(scene(0.3), [shared, alone]).hits(origins, directions)
    np.testing.assert_array_equal(moved.hits(origins, directions), expected)
    assert not np.array_equal(before, expected)
    other = dataclasses.replace(shared, positions=shared.positions * np.float32(0.5))
    changed = Probe(scene(0.3), [other, alone], kept=kept)
    expected = Probe(scene(0.3), [other, alone]).hits(origins, directions)
    np.testing.assert_array_equal(changed.hits(origins, directions), expected)
    clear = Probe(scene(0.3), [other, alone], (True,), kept=kept)  # light rays are told of what is transparent
    assert clear.accelerator is not changed.accelerator


GARBAGE = """
import faulthandler, gc
import numpy as np
from sdf_lights.render.cpu.accelerator import accelerator_of
from sdf_lights.render.scene import Camera, Instance, Scene
from support import scenes

faulthandler.enable()
gc.disable()
mesh = scenes.sphere(columns=200, rows=100)
for turn in range(20):
    far = [scenes.translation(turn, 3.0 * place, 0.0) for place in range(4)]
    placed = [Instance(0, matrix, (0,)) for matrix in far]
    scene = Scene(Camera(np.eye(4)), 1, 1, instances=placed, meshes=[mesh])
    made = accelerator_of(scene, np.array((False,)))
    made.itself = made
    del made
    gc.collect()
"""


def test_structures_in_a_cycle_of_references_are_released_in_any_order():
    run = subprocess.run([sys.executable, "-c", GARBAGE], capture_output=True, text=True)
    assert run.returncode == 0, run.stderr[-2000:]
