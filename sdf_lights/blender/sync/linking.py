# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Light linking: the objects that a light lights, and those that cast its shadows, from the collections of the light's
object.

As in Cycles, a collection that includes any object lights no others. A collection with only exclusions lights all the
rest. An entry in the collection itself overrides entries in its children.
"""

from __future__ import annotations

from collections.abc import Iterator

import bpy

from ...render.scene import ALL_SETS, OPEN_SET

KINDS = RECEIVER, BLOCKER = "receiver_collection", "blocker_collection"


def linked(depsgraph: bpy.types.Depsgraph) -> list[tuple[str, bpy.types.Object, bpy.types.Collection]]:
    """For each object with linked light: the kind, the object and the collection."""
    found = []
    for obj in depsgraph.objects:
        linking = getattr(obj, "light_linking", None)
        if linking is None:
            continue
        for kind in KINDS:
            collection = getattr(linking, kind)
            if collection is not None:
                found.append((kind, obj.original, collection.original))
    return found


def signature(depsgraph: bpy.types.Depsgraph) -> tuple:
    """A key that changes when objects must be read again because of light linking."""
    return tuple((kind, obj.session_uid, collection.session_uid) for kind, obj, collection in linked(depsgraph))


def _states(collection: bpy.types.Collection) -> Iterator[tuple[bpy.types.Object, bool]]:
    """Objects of a collection, and whether each is included or excluded; the last entry of an object counts."""
    for child, link in zip(collection.children, collection.collection_children):
        included = link.light_linking.link_state == "INCLUDE"
        yield from ((obj, included) for obj in child.all_objects)
    for obj, link in zip(collection.objects, collection.collection_objects):
        yield obj, link.light_linking.link_state == "INCLUDE"


class _Sets:
    """Sets of objects named by the same collections, for one kind of linking, numbered from ``OPEN_SET`` + 1."""

    def __init__(self, links: list[tuple[bpy.types.Object, bpy.types.Collection]]):
        self._masks: dict[int, int] = {}  # by emitter
        self._sets: dict[int, int] = {}  # by object
        collections = {collection.session_uid: collection for _, collection in links}
        emitters = [(obj.session_uid, collection.session_uid) for obj, collection in links]
        states = {uid: {obj.session_uid: part for obj, part in _states(found)} for uid, found in collections.items()}
        numbers: dict[tuple, int] = {}
        for uid in {uid for found in states.values() for uid in found}:
            said = tuple(found.get(uid) for found in states.values())
            self._sets[uid] = numbers.setdefault(said, OPEN_SET + 1 + len(numbers))
        masks = {}
        for place, (uid, found) in enumerate(states.items()):
            included = sum(1 << number for said, number in numbers.items() if said[place] is True)
            excluded = sum(1 << number for said, number in numbers.items() if said[place] is False)
            masks[uid] = included or ALL_SETS & ~excluded
        self._masks = {emitter: masks[collection] for emitter, collection in emitters}

    def mask(self, emitter: int) -> int:
        """Bits of the sets that an emitter is linked to."""
        return self._masks.get(emitter, ALL_SETS)

    def number(self, obj: int) -> int:
        """The set of an object."""
        return self._sets.get(obj, OPEN_SET)


class Linking:
    """Light and shadow linking of all objects of a dependency graph. Objects are original ones."""

    def __init__(self, depsgraph: bpy.types.Depsgraph):
        links = linked(depsgraph)
        self._light, self._shadow = (
            _Sets([(obj, collection) for own, obj, collection in links if own == kind]) for kind in KINDS
        )
        self._any = bool(links)

    def of_emitter(self, obj: bpy.types.Object) -> dict[str, int]:
        """Fields of ``render.scene.Emitter`` that differ from the default."""
        if not self._any:
            return {}
        uid = obj.session_uid
        return dict(receivers=self._light.mask(uid), blockers=self._shadow.mask(uid))

    def of_instance(self, obj: bpy.types.Object, owner: bpy.types.Object) -> dict[str, int]:
        """Fields of ``render.scene.Instance`` that differ from the default; ``owner``: its instancer, or itself."""
        if not self._any:
            return {}
        uid = owner.session_uid
        return dict(light_set=self._light.number(uid), shadow_set=self._shadow.number(uid)) | self.of_emitter(obj)
