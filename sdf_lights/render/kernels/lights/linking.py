# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Light and shadow linking: which emitters light which instances, and which instances cast the shadows of an emitter.

With an emitter that does not light all instances, instances have other light trees than the one of all emitters. An
emitter whose shadows are not cast by all instances has its own bit in the masks of rays.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from ....jit import kernel
from ....replaced import replaced_on_gpu
from ...scene import ALL_SETS, OPEN_SET, Emitter, Scene
from ..rays import SHADOW_BITS, SHADOW_OPAQUE
from .records import PLACE, TREE, emitter_table, header_table, link_table, place_table, tree_of_table


def _members(scene: Scene) -> Iterator[Emitter]:
    yield from scene.lamps
    yield from scene.lights
    yield from scene.instances


def shadow_bits(scene: Scene) -> dict[int, int]:
    """The bit of rays towards an emitter that replaces ``SHADOW_OPAQUE``, by its ``blockers``.

    If there are too many of them, the last are missing here: everything casts their shadows.
    """
    found = dict.fromkeys(member.blockers for member in _members(scene) if member.blockers != ALL_SETS)
    return dict(zip(found, SHADOW_BITS))


def shadow_bit(bits: dict[int, int], blockers: int) -> int:
    """As ``shadow_bits``, for one emitter."""
    return bits.get(blockers, SHADOW_OPAQUE)


def pack_trees(
    tables: dict[str, np.ndarray],
    scene: Scene,
    is_in_light_tree: Callable[[int], np.ndarray],
    build: Callable[[np.ndarray | None], tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]],
) -> None:
    """Fill the tables of all light trees. Returns which of them belongs to which instance.

    ``is_in_light_tree`` gives (emitters,) bool, whether each lights a set of instances. ``build`` makes a tree of some
    (None: all) of the emitters: its nodes, its infinite emitters, and (emitters,) their leaves and their rows among the
    infinite ones.
    """
    numbers, chosen, links = {}, [None], []
    known: dict[bytes, int] = {}
    if any(member.receivers != ALL_SETS for member in _members(scene)):
        for number in sorted({OPEN_SET, *(instance.light_set for instance in scene.instances)}):
            lit = is_in_light_tree(number)
            glow = np.array([instance.receivers >> number & 1 for instance in scene.instances], np.int32)
            if lit.all() and glow.all():
                numbers[number] = 0
                continue
            key = lit.tobytes() + glow.tobytes()
            if key not in known:
                known[key] = len(chosen)
                chosen.append(lit)
                links.append(glow)
            numbers[number] = known[key]
    trees, nodes, infinite, places = np.zeros(len(chosen), TREE), [], [], []
    node, row = 0, 0
    for number, lit in enumerate(chosen):
        own, endless, leaf, place = build(lit)
        own, place = own.copy(), np.where(place >= 0, place + row, -1)
        own["child"] = np.where(own["child"] >= 0, own["child"] + node, own["child"])
        trees[number] = node, len(own), row, row + len(endless)
        if number == 0:
            tables["light_emitters"]["leaf"], tables["light_emitters"]["infinite"] = leaf, place
        else:
            both = np.zeros(len(leaf), PLACE)
            both["leaf"], both["infinite"] = leaf, place
            places.append(both)
        nodes.append(own)
        infinite.append(endless)
        node, row = node + len(own), row + len(endless)
    tables["light_trees"], tables["light_nodes"] = trees, np.concatenate(nodes)
    tables["light_infinite"] = np.concatenate(infinite)
    header = tables["light_header"]
    header["tree_count"], header["emitter_count"] = len(chosen), len(tables["light_emitters"])
    header["instance_count"], header["open_tree"] = len(scene.instances), numbers.get(OPEN_SET, 0)
    if len(chosen) == 1:
        return
    tables["light_tree_places"] = np.concatenate(places)
    tables["light_tree_of"] = np.array([numbers[instance.light_set] for instance in scene.instances], np.int32)
    tables["light_links"] = np.concatenate(links)


@kernel
def place_in(block, number, emitter):
    """Position of an emitter in tree ``number``: its leaf, and its row in light_infinite; −1: not there."""
    if number == 0:
        row = emitter_table(block)[emitter]
        return row.leaf, row.infinite
    place = place_table(block)[(number - 1) * header_table(block)[0].emitter_count + emitter]
    return place.leaf, place.infinite


@kernel
def tree_of(block, instance):
    """Number of the tree of all emitters that light an instance."""
    return np.int64(tree_of_table(block)[instance]) if header_table(block)[0].tree_count > 1 else np.int64(0)


@kernel
def open_tree(block):
    """Number of the tree of all emitters that light the medium of the world."""
    return header_table(block)[0].open_tree


@replaced_on_gpu
@kernel
def is_in_light_tree(block, number, emitter):
    """Whether an emitter that gives light is in tree ``number``."""
    if number == 0:
        return True
    leaf, endless = place_in(block, number, emitter)
    return leaf >= 0 or endless >= 0


@kernel
def emission_is_linked(block, number, instance):
    """Whether emission of an instance lights objects with the tree ``number``."""
    if number == 0:
        return True
    return link_table(block)[(number - 1) * header_table(block)[0].instance_count + instance] != 0
