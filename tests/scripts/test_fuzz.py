# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""``bench fuzz``: differences of pictures whose noise is known, and scenes without some of their features."""

import bpy
import numpy as np
import pytest
from benchmarks import fuzz, random_nodes, random_scenes

from sdf_lights.blender.shader_trees import use_nodes

SIZE, SEEDS = 48, 4
SEEDS_OF_TREES = range(83, 115)  # none hangs on rounding, as white noise of a varying number does


def noisy(seed: int, scale: np.ndarray | float = 1.0) -> np.ndarray:
    """Pictures of brightness 0.5 with noise of 10 % a pixel."""
    noise = np.random.default_rng(seed).normal(1.0, 0.1, (SEEDS, SIZE, SIZE, 3))
    return 0.5 * noise * scale


@pytest.mark.parametrize("seed", range(5))
def test_noise_is_no_difference(seed):
    assert not fuzz.difference_of(noisy(seed), noisy(seed + 100)).is_beyond_noise


def test_brighter_pictures_and_blocks_differ():
    found = fuzz.difference_of(noisy(1), noisy(2, 1.02))
    assert found.is_beyond_noise and found.mean == pytest.approx(0.02, abs=0.002)
    scale = np.ones((SIZE, SIZE, 1))
    scale[8:16, 24:32] = 0.8
    found = fuzz.difference_of(noisy(1), noisy(2, scale))
    assert found.is_beyond_noise and found.block == pytest.approx(-0.2, abs=0.03)


def test_fireflies_decide_nothing():
    bright = noisy(2)
    bright[0, 20, 20] = 1e4
    assert not fuzz.difference_of(noisy(1), bright).is_beyond_noise


def described(without: frozenset[str] = frozenset()) -> tuple[list[str], dict]:
    """Features of a scene, and where its objects are."""
    names = random_scenes.build(3, 8, 1, "CPU", without).names
    return names, {obj.name: tuple(obj.matrix_basis.to_translation()) for obj in bpy.context.scene.objects}


def test_a_scene_without_a_feature_keeps_all_others():
    names, places = described()
    assert described() == (names, places)
    light = next(name for name in names if name.startswith("light"))
    left = [name for name in names if name.partition(" ")[0] != "light" or not name.startswith(light)]
    assert len(left) < len(names)
    fewer, kept = described(frozenset([light]))
    assert fewer == left
    assert kept == {name: place for name, place in places.items() if name != light}


def test_features_are_left_out_while_pictures_differ(monkeypatch):
    def measured(seed, device, without=frozenset()):
        names = [name for name in ("thing 0", "fog", "light 0", "wall") if name not in without]
        differs = {"fog", "light 0"} <= set(names)
        return fuzz.Difference(0.1 * differs, 10.0 * differs, 0.0, 0.0), names

    monkeypatch.setattr(fuzz, "measure", measured)
    assert fuzz.reduced(0, "CPU", ["thing 0", "fog", "light 0", "wall"]) == ["fog", "light 0"]


def nodes_of(seed: int) -> list[tuple]:
    """Nodes of a tree, with the links between them."""
    tree = use_nodes(bpy.data.materials.new("Tree"))
    tree.nodes.clear()
    random_nodes.case(seed).tree(tree)
    links = [(link.from_node.name, link.from_socket.identifier, link.to_node.name) for link in tree.links]
    return [(node.name, node.mute) for node in tree.nodes] + links


def test_a_seed_always_gives_the_same_tree():
    bpy.ops.wm.read_factory_settings(use_empty=True)
    trees = [nodes_of(seed) for seed in range(20)]
    assert trees == [nodes_of(seed) for seed in range(20)]
    kinds = {name.partition(".")[0] for tree in trees for name, *_ in tree}
    assert len(kinds) > 25 and "Group" in kinds


def test_random_trees_look_as_in_cycles():
    rows = fuzz.tree_rows(SEEDS_OF_TREES, "CPU")
    assert [row["tree_seed"] for row in rows if row["different_pixels"] > fuzz.PIXELS] == []
