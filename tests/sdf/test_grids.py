# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Signed distance grids of meshes: distances, signs of meshes with faults, bounds, crossings, cost."""

import threading
import time

import numpy as np
import pytest

from sdf_lights import interruption
from sdf_lights.emitter.tree import interior
from sdf_lights.graph import codegen_glsl
from sdf_lights.graph.functions import evaluate
from sdf_lights.jit import kernel
from sdf_lights.sdf.data import boxes, voxels
from sdf_lights.sdf.data.crossings import crossed, find_crossings
from sdf_lights.sdf.data.grid import BLOCK, CORNERS, GRID, SIDE
from sdf_lights.sdf.data.open_edges import open_edges
from sdf_lights.sdf.data.triangles import nearest, triangles, winding
from sdf_lights.sdf.data.voxels import GridError, mesh_grid
from sdf_lights.sdf.shapes import Difference, Sphere
from support import glsl, grids
from support.lamps.crossings import wrong_crossings
from support.lamps.rays import Traced

TORUS = grids.torus(0.7, 0.25, 64, 32)


@kernel
def _fill_windings(corners, moments, points, share, found):
    for row in range(len(points)):
        found[row] = winding(corners, moments, points[row, 0], points[row, 1], points[row, 2], share)


def windings(mesh, points, share=1.0):
    """Winding numbers around points (..., 3), from all triangles if the share is infinite."""
    found = np.empty(points.shape[:-1])
    moments = mesh.moments.copy()
    if share == np.inf:  # parts without triangles have a negative radius
        moments[:, 3], share = np.where(moments[:, 3] > 0.0, np.inf, moments[:, 3]), 1.0
    _fill_windings(mesh.corners, moments, np.ascontiguousarray(points.reshape(-1, 3)), share, found.reshape(-1))
    return found


@pytest.fixture(scope="module")
def ring():
    return mesh_grid(*TORUS, 2.0 / 48)


def _points(shape, count, seed=1, beyond=0.0):
    low, high = shape.bounds()
    return np.random.default_rng(seed).uniform(low - beyond, high + beyond, (count, 3))


def test_a_grid_has_the_distance_to_its_mesh_in_its_band(ring):
    points = _points(ring, 50_000)
    exact = np.hypot(np.hypot(points[:, 0], points[:, 1]) - 0.7, points[:, 2]) - 0.25
    found = ring.distance(points)
    near = np.abs(exact) < 2.0 * ring.voxel_size
    np.testing.assert_allclose(found[near], exact[near], atol=0.25 * ring.voxel_size)
    sure = np.abs(exact) > 0.25 * ring.voxel_size
    assert ((found < 0.0) == (exact < 0.0))[sure].all()


def test_bounds_of_a_grid_hold_for_values_and_slopes(ring):
    rng = np.random.default_rng(4)
    low = _points(ring, 4000, 2, 0.1)
    high = low + rng.uniform(1e-4, 0.3, (4000, 1)) * rng.random((4000, 3))
    address = float(ring.data.address), float(ring.values.address)
    bounds = evaluate(GRID.bounds, [*address, *(end for k in range(3) for end in (low[:, k], high[:, k]))])
    points = np.moveaxis(low + rng.random((30, 4000, 3)) * (high - low), -1, 0)
    values = evaluate(GRID, [*address, *points])[0]
    assert (bounds[0] <= values).all() and (values <= bounds[1]).all()
    slopes = evaluate(GRID.derivatives, [*address, *points])
    for k, slope in enumerate(slopes):
        assert (bounds[2 + 2 * k] <= slope + 1e-12).all() and (slope <= bounds[3 + 2 * k] + 1e-12).all()
    assert np.sqrt(sum(slope**2 for slope in slopes)).max() <= ring.lipschitz
    assert np.mean(bounds[1] - bounds[0] < 0.9 * ring.lipschitz * np.linalg.norm(high - low, axis=1)) > 0.1


def test_no_two_points_differ_by_more_than_the_bound(ring):
    a = _points(ring, 200_000, 5, 0.2)
    b = a + np.random.default_rng(6).normal(size=a.shape) * 10.0 ** np.random.default_rng(7).uniform(
        -6, -0.5, (len(a), 1)
    )
    difference = np.abs(ring.distance(a) - ring.distance(b))
    assert (difference <= ring.lipschitz * np.linalg.norm(a - b, axis=1) + 1e-12).all()


@pytest.mark.parametrize("faults", ["closed", "open"])
def test_blocks_agree_where_they_touch(faults):
    vertices, faces = TORUS
    if faults == "open":
        faces = faces[200:]
    grid = mesh_grid(vertices, faces, 2.0 / 40)
    numbers = grid.data.array
    counts = numbers[4:7].astype(int)
    places = numbers[int(numbers[8]) : int(numbers[9])].reshape(counts[::-1])
    band = numbers[10]

    def face(place, axis, side):
        if place < 0.0:
            return np.full((CORNERS, CORNERS), band if place == -1.0 else -band)
        block = grid.values.array[int(place) : int(place) + BLOCK].reshape(CORNERS, CORNERS, CORNERS)
        return np.take(block, SIDE * side, axis=axis)

    for axis in range(3):
        firsts, lasts = np.split(np.arange(places.shape[axis]), [-1])[0], np.arange(1, places.shape[axis])
        for first, last in zip(np.take(places, firsts, axis).ravel(), np.take(places, lasts, axis).ravel()):
            if first >= 0.0 or last >= 0.0:
                np.testing.assert_array_equal(face(first, axis, 1), face(last, axis, 0))


def test_winding_numbers_count_crossing_and_doubled_faces():
    vertices, faces = TORUS
    mesh = triangles(*grids.joined((vertices, faces), (vertices + (0.2, 0.0, 0.0), faces)))
    points = np.random.default_rng(1).uniform(-1.2, 1.2, (2000, 3))
    expected, near = 0, False
    for shift in (0.0, 0.2):
        exact = np.hypot(np.hypot(points[:, 0] - shift, points[:, 1]) - 0.7, points[:, 2]) - 0.25
        expected, near = expected + (exact < 0.0), near | (np.abs(exact) < 0.01)
    found = windings(mesh, points)
    np.testing.assert_allclose(found[~near], expected[~near], atol=0.05)


def test_moments_of_far_triangles_stand_for_them():
    vertices, faces = TORUS
    mesh = triangles(vertices, faces[300:])
    dipoles = mesh.moments.copy()
    dipoles[:, 7:] = 0.0
    points = np.random.default_rng(2).uniform(-1.2, 1.2, (1000, 3))
    exact = windings(mesh, points, np.inf)
    errors, without = (np.abs(windings(each, points) - exact) for each in (mesh, mesh._replace(moments=dipoles)))
    assert errors.max() < 0.05 and np.mean(errors) < 0.5 * np.mean(without)
    assert np.abs(windings(mesh, points, voxels.ROUGH_SHARE) - exact).max() < voxels.ROUGH


def _volume(shape):
    return (shape.distance(_points(shape, 200_000)) < 0.0).mean() * np.prod(np.diff(shape.bounds(), axis=0))


@pytest.mark.parametrize("fault", ["inside out", "doubled", "holes", "cracked", "through itself"])
def test_faulty_meshes_have_the_inside_that_is_meant(fault):
    vertices, faces = TORUS
    size = 2.0 * np.pi**2 * 0.7 * 0.25**2
    if fault == "inside out":
        faces = faces[:, ::-1]
    elif fault == "doubled":
        faces = np.concatenate([faces, faces[:700]])
    elif fault == "holes":
        faces = np.delete(faces, np.random.default_rng(3).choice(len(faces), 150, replace=False), axis=0)
    elif fault == "cracked":
        vertices, faces = vertices[faces.ravel()], np.arange(3 * len(faces)).reshape(-1, 3)
        vertices = vertices + np.random.default_rng(3).normal(size=vertices.shape) * 1e-3
    else:
        vertices, faces = grids.joined(TORUS, (vertices[:, [0, 2, 1]] * 1.0, faces[:, ::-1]))
        size *= 1.7
    grid = mesh_grid(vertices, faces, 2.0 / 40)
    assert grid.lipschitz < 2.0
    assert _volume(grid) == pytest.approx(size, rel=0.08)
    assert interior.tree(grid).certified


@pytest.mark.parametrize(
    "vertices, faces, sentence",
    [
        (np.zeros((3, 3)), np.zeros((0, 3), int), "no faces"),
        (np.zeros((3, 3)), [[0, 1, 2]], "no area"),
        ([[0.1, 0.3, 0.7], [0.9, 0.77, 0.31]], [[0, 1, 1], [1, 0, 0]], "no area"),
        ([[0, 0, 0], [1, 0, 0], [0, np.nan, 0]], [[0, 1, 2]], "not a finite number"),
        ([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]], "no inside"),
    ],
)
def test_meshes_without_an_inside_say_so_in_a_sentence(vertices, faces, sentence):
    with pytest.raises(GridError, match=sentence):
        mesh_grid(np.array(vertices), np.array(faces))


@pytest.mark.parametrize("size", [1e-4, 1e-9])
def test_too_small_voxels_are_refused_at_once(size):
    started = time.process_time()
    with pytest.raises(GridError, match="larger voxel size"):
        mesh_grid(*TORUS, size)
    assert time.process_time() - started < 5.0


def test_building_stops_when_nobody_wants_it():
    stopped = threading.Event()
    timer = threading.Timer(0.2, stopped.set)
    with interruption.watched(interruption.Watch(stopped.is_set)):
        timer.start()
        with pytest.raises(interruption.Interrupted):
            mesh_grid(*grids.torus(0.7, 0.25, 400, 200), 2.0 / 400)
    timer.join()


def test_grids_combine_with_other_shapes(ring):
    points = _points(ring, 2000)
    expected = np.maximum(ring.distance(points), -Sphere(0.6).distance(points))
    cut = Difference(ring, Sphere(0.6))
    np.testing.assert_allclose(cut.distance(points), expected, atol=1e-12)
    assert interior.tree(cut).certified


def test_glsl_of_a_grid_has_the_same_distances(ring):
    points = _points(ring, 2000, 3, 0.3).astype(np.float32)
    first = len(ring.parameters())
    numbers = np.concatenate([[0.0, len(ring.data.array)], ring.data.array, ring.values.array])
    source = f"#define table_number(i) k[{first} + (i)]\n" + codegen_glsl.function(
        ring.formula(), "read", written=set()
    )
    found = glsl.evaluate(source, "read", points, numbers)
    np.testing.assert_allclose(found, ring.distance(points.astype(float)), atol=2e-5)


def test_rays_find_all_crossings_of_a_grid(ring):
    assert wrong_crossings(ring, 5_000) == 0.0


@pytest.mark.slow
def test_no_ray_of_a_million_through_grids_has_a_wrong_number_of_crossings(ring):
    vertices, faces = TORUS
    for shape in (ring, mesh_grid(vertices, faces[200:], 0.04)):
        assert wrong_crossings(shape, 500_000) == 0.0


@pytest.mark.slow
def test_a_scan_of_300_thousand_triangles_is_a_lamp():
    vertices, faces = grids.scan(300_000)
    assert len(faces) > 280_000
    grid = mesh_grid(vertices, faces)
    assert grid.bytes < 64e6 and grid.lipschitz < 2.0 and interior.tree(grid).certified
    assert wrong_crossings(grid, 20_000) == 0.0


def test_a_ray_asks_a_grid_for_few_points():
    """The kinds benchmark measures the time, which depends on the machine."""
    grid = mesh_grid(*TORUS, 2.0 / 128)
    assert grid.voxels > 600_000 and grid.bytes < 8 * grid.voxels
    evaluations = Traced(grid).trace(*grids.rays_around(grid, 5_000, 6))[:, 3]
    assert evaluations.mean() < 16.0


def test_slopes_are_bounded_more_closely_where_the_grid_is_zero(ring):
    rng = np.random.default_rng(8)
    low = _points(ring, 6000, 9)
    high = low + rng.uniform(0.02, 0.15, (6000, 3))
    address = float(ring.data.address), float(ring.values.address)
    corners = [*address, *(end for k in range(3) for end in (low[:, k], high[:, k]))]
    everywhere, at_zeros = evaluate(GRID.bounds, corners), evaluate(GRID.zero_bounds, corners)
    np.testing.assert_array_equal(at_zeros[:2], everywhere[:2])
    points = low + rng.random((20, 6000, 3)) * (high - low)
    inside = ring.distance(points) < 0.0
    chosen = np.flatnonzero(inside.any(axis=0) & ~inside.all(axis=0))
    a, b = (points[np.argmax(side[:, chosen], axis=0), chosen] for side in (inside, ~inside))
    for _ in range(50):
        middle = 0.5 * (a + b)
        within = (ring.distance(middle) < 0.0)[:, None]
        a, b = np.where(within, middle, a), np.where(within, b, middle)
    assert len(chosen) > 300
    for k, slope in enumerate(evaluate(GRID.derivatives, [*address, *a.T])):
        assert (at_zeros[2 + 2 * k][chosen] <= slope + 1e-9).all() and (
            slope <= at_zeros[3 + 2 * k][chosen] + 1e-9
        ).all()
    widths = [
        np.mean([(found[3 + 2 * k] - found[2 + 2 * k])[chosen] for k in range(3)]) for found in (at_zeros, everywhere)
    ]
    assert widths[0] < 0.9 * widths[1]


def test_boxes_where_a_grid_has_one_sign_are_settled(ring):
    tree = interior.tree(ring)
    rng = np.random.default_rng(3)
    for state, sign in ((interior.INSIDE, -1.0), (interior.OUTSIDE, 1.0)):
        leaves = tree.boxes[(tree.nodes["first"] < 0) & (tree.nodes["state"] == state)]
        points = leaves[:, :3] + rng.random((30, len(leaves), 3)) * (leaves[:, 3:] - leaves[:, :3]) + tree.center
        assert (sign * ring.distance(points) > 0.0).all()
    # All others may have both, as far as their voxels tell.
    low, high = np.split(tree.boxes[tree.boundary] + np.tile(tree.center, 2), 2, axis=1)
    corners = [end for k in range(3) for end in (low[:, k], high[:, k])]
    bounds = evaluate(GRID.bounds, [float(ring.data.address), float(ring.values.address), *corners])
    assert (bounds[0] <= 1e-8).all() and (bounds[1] >= -1e-8).all()


def _box():
    vertices = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
    sides = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    return vertices, np.array([[a, b, c] for p, q, r, s in sides for a, b, c in ((p, q, r), (p, r, s))])


def _soup(mesh):
    vertices, faces = mesh
    return vertices[faces.ravel()], np.arange(faces.size).reshape(-1, 3)


def _without(mesh, count):
    vertices, faces = mesh
    return vertices, np.delete(faces, np.random.default_rng(3).choice(len(faces), count, replace=False), axis=0)


def _turned(mesh, part):
    vertices, faces = mesh[0], mesh[1].copy()
    faces[part] = faces[part, ::-1]
    return vertices, faces


def _cracked(mesh):
    vertices, faces = _soup(mesh)
    return vertices + np.random.default_rng(3).normal(size=vertices.shape) * 1e-3, faces


HARD = {
    "closed": TORUS,
    "soup": _soup(TORUS),
    "a hole": (TORUS[0], TORUS[1][150:]),
    "holes": _without(TORUS, 150),
    "a sieve": (TORUS[0], TORUS[1][: len(TORUS[1]) // 2]),
    "cracked": _cracked(TORUS),
    "a turned patch": _turned(TORUS, slice(300, 420)),
    "turned": _turned(TORUS, slice(None)),
    "doubled": (TORUS[0], np.concatenate([TORUS[1], TORUS[1][:700]])),
    "overlapping": grids.joined(TORUS, (TORUS[0] + (0.2, 0.05, 0.0), TORUS[1]), _without(TORUS, 100)),
    "overlapping, turned": grids.joined(TORUS, _turned((TORUS[0][:, [1, 2, 0]], TORUS[1]), slice(0, 900))),
    "a wall with a hole": grids.joined(
        (TORUS[0], TORUS[1][150:]), _turned((grids.torus(0.7, 0.2, 64, 32)[0], TORUS[1][150:]), slice(None))
    ),
    "five sheets with a hole": grids.joined(
        *((grids.torus(0.7, minor, 64, 32)[0], TORUS[1][150:]) for minor in (0.29, 0.26, 0.23, 0.2, 0.17))
    ),
    "a box on the lattice": _box(),
    "an open box": (_box()[0], _box()[1][2:]),
    "thin sheets": (_box()[0] * (1.0, 1.0, 0.03), _box()[1]),
    "thin sheets with holes": _without(grids.torus(0.7, 0.02, 64, 12), 60),
    "scan": grids.scan(8_000),
}


def _lattices(vertices, faces, count):
    """A builder, some of the blocks near the surface, and their points (n, CORNERS, CORNERS, CORNERS, 3)."""
    builder = voxels._Builder(triangles(vertices, faces), vertices.min(axis=0), vertices.max(axis=0), 2.0 / 48)
    blocks = np.stack(np.meshgrid(*map(np.arange, builder.counts), indexing="ij"), axis=-1).reshape(-1, 3)
    blocks = builder.near_enough(blocks)
    starts = SIDE * blocks[np.random.default_rng(5).permutation(len(blocks))[:count]]
    own = np.arange(CORNERS)
    places = np.stack(np.meshgrid(own, own, own, indexing="ij"), axis=-1)[..., ::-1]
    return builder, starts, builder.corner + builder.size * (starts[:, None, None, None] + places)


@pytest.mark.parametrize("name", HARD)
def test_sides_are_those_of_the_winding_numbers_of_all_triangles(name):
    builder, starts, points = _lattices(*HARD[name], 40)
    distances, found = builder.measured(starts, CORNERS, 1.0, builder.band)
    if len(HARD[name][1]) > 4500:  # the sum over all triangles is what takes time: every ninth point has it
        points, distances, found = points[..., ::3, ::3, :], distances[..., ::3, ::3], found[..., ::3, ::3]
    exact = windings(builder.mesh, points, np.inf)
    # Beside a face, and where half of the sphere is covered, rounding and distant triangles decide.
    judged = (np.abs(np.abs(exact) - voxels.INSIDE) > 0.04) & (distances > 1e-5 * builder.size)
    assert judged.mean() > 0.85 and (np.abs(exact[judged]) > 0.5).any() and (np.abs(exact[judged]) < 0.5).any()
    np.testing.assert_array_equal((np.abs(found) > voxels.INSIDE)[judged], (np.abs(exact) > voxels.INSIDE)[judged])


def _to_triangle(a, b, c, p):
    """Ericson, Real-Time Collision Detection, section 5.1.5."""
    u, v = b - a, c - a
    d1, d2, d3, d4, d5, d6 = (q @ e for q in (p - a, p - b, p - c) for e in (u, v))
    va, vb, vc = d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2
    if d1 <= 0.0 and d2 <= 0.0:
        s, t = 0.0, 0.0
    elif d3 >= 0.0 and d4 <= d3:
        s, t = 1.0, 0.0
    elif d6 >= 0.0 and d5 <= d6:
        s, t = 0.0, 1.0
    elif vc <= 0.0 and d1 >= 0.0 and d3 <= 0.0:
        s, t = d1 / (d1 - d3), 0.0
    elif vb <= 0.0 and d2 >= 0.0 and d6 <= 0.0:
        s, t = 0.0, d2 / (d2 - d6)
    elif va <= 0.0 and d4 - d3 >= 0.0 and d5 - d6 >= 0.0:
        t = (d4 - d3) / ((d4 - d3) + (d5 - d6))
        s = 1.0 - t
    else:
        s, t = vb / (va + vb + vc), vc / (va + vb + vc)
    return np.linalg.norm(p - a - s * u - t * v)


@pytest.mark.parametrize("shape", ["ordinary", "thin", "one"])
def test_distances_are_those_to_the_nearest_of_all_triangles(shape):
    rng = np.random.default_rng(6)
    found = rng.normal(size=(1 if shape == "one" else 150, 3, 3))
    if shape == "thin":
        found[:, 2] = 0.3 * found[:, 0] + 0.7 * found[:, 1] + rng.normal(size=(150, 3)) * 1e-9
    mesh = triangles(found.reshape(-1, 3), np.arange(found[..., 0].size).reshape(-1, 3))
    for point in rng.normal(size=(100, 3)):
        exact = min(_to_triangle(*corners, point) for corners in found)
        distance, leaf = nearest(mesh.corners, mesh.nodes, mesh.disks, *point, np.inf, len(mesh.corners) - 1)
        assert distance == pytest.approx(exact, abs=1e-12) and 0 <= leaf < len(mesh.corners)
        assert nearest(mesh.corners, mesh.nodes, mesh.disks, *point, 0.5 * exact, 0)[0] > 0.5 * exact


@pytest.mark.parametrize("name", ["closed", "a hole", "scan"])
def test_a_block_does_not_depend_on_others(name):
    """Threads take blocks in any order."""
    builder, starts, _ = _lattices(*HARD[name], 60)
    together = builder.measured(starts, CORNERS, 1.0, builder.band)
    turned = builder.measured(starts[::-1], CORNERS, 1.0, builder.band)
    for first, second in zip(together, turned):
        np.testing.assert_array_equal(np.minimum(first, builder.band), np.minimum(second[::-1], builder.band))


def test_lines_cross_closed_meshes_as_often_as_winding_numbers_change():
    for mesh, size in ((TORUS, 2.0 / 40), (_soup(TORUS), 2.0 / 40), (_box(), 1.0 / 8)):
        tree, corner, aside = triangles(*mesh), np.array([-0.5, 0.0, -0.25]), size * np.array(voxels.ASIDE)
        crossings = np.empty((3, CORNERS, CORNERS, CORNERS), np.int64)
        find_crossings(tree.corners, tree.nodes, *(corner + aside), size, crossings)
        places = np.random.default_rng(7).integers(0, CORNERS, (200, 2, 3))
        exact = windings(tree, corner + aside + size * places[..., ::-1], np.inf)
        found = [crossed(crossings, *first, *second) for first, second in places]
        np.testing.assert_array_equal(found, np.round(exact[:, 1] - exact[:, 0]))
        assert np.any(found)


def test_open_edges_are_those_that_no_other_edge_balances():
    assert not len(open_edges(*TORUS)) and not len(open_edges(*_soup(TORUS))) and not len(open_edges(*_box()))
    vertices, faces = _box()
    found = open_edges(vertices, faces[2:])
    assert len(found) == 4 and (found[..., 0] == -0.5).all()
    np.testing.assert_allclose((found[:, 1] - found[:, 0]).sum(axis=0), 0.0)
    # A turned face counts twice at each of its edges, and one that is there again once.
    assert len(open_edges(*_turned((vertices, faces), slice(0, 1)))) == 6
    assert len(open_edges(vertices, np.concatenate([faces, faces[:1]]))) == 3
    assert not len(open_edges(vertices, np.concatenate([faces, [[0, 1, 1]]])))


@pytest.mark.parametrize("name", ["a hole", "a sieve", "scan"])
def test_neighbours_differ_by_no_more_than_their_distance(name):
    grid = mesh_grid(*HARD[name], 2.0 / 48)
    values = grid.values.array.reshape(-1, CORNERS, CORNERS, CORNERS).astype(float)
    for axis in (1, 2, 3):
        assert np.abs(np.diff(values, axis=axis)).max() <= grid.voxel_size * (1.0 + 1e-6)


@pytest.mark.parametrize("count", [1, 3, 4, 5, 1000])
def test_a_tree_has_all_things_in_boxes_that_hold_them(count, monkeypatch):
    low = np.random.default_rng(8).integers(0, 9, (count, 3)) / 8.0
    high = low + 0.1
    order, nodes = boxes.tree(low, high)
    leaves = len(nodes) // 2
    assert set(order) == set(range(count)) and len(order) == boxes.LEAF * leaves
    for leaf in range(leaves):
        own = order[boxes.LEAF * leaf : boxes.LEAF * (leaf + 1)]
        np.testing.assert_array_equal(nodes[leaves + leaf], [*low[own].min(axis=0), *high[own].max(axis=0)])
    for node in range(1, leaves):
        children = nodes[2 * node : 2 * node + 2]
        np.testing.assert_array_equal(nodes[node], [*children[:, :3].min(axis=0), *children[:, 3:].max(axis=0)])
    monkeypatch.setattr(boxes, "LARGE", 8)
    for first, second in zip(boxes.tree(low, high), (order, nodes)):
        np.testing.assert_array_equal(first, second)
