# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Links of node trees: the link that counts at an input, circles of links, and the value of an input without a
source."""

from __future__ import annotations

import bpy

INLINED = bpy.app.version >= (5, 0, 0)
"""Whether Blender resolves groups before Cycles sees them. If so, a texture keeps the value of a group's input as its
coordinates; an input without a source has its own value; a tree with a circle of links is empty. If not, such a texture
has its own coordinates; an input without a source is zero; the link that closes a circle is removed."""


class _Nowhere:
    """Stands for the socket at the end of a walk without a source. Textures, normals and shaders treat it as no
    link."""

    type, identifier, default_value, hide_value = "VALUE", "", 0.0, True

    def as_pointer(self) -> int:
        return 0


NOWHERE = _Nowhere()


class Links:
    """Links of all trees that a walk enters. Blender searches all links of a tree for each input, so each tree is read
    only once."""

    def __init__(self):
        self._known: dict[int, tuple[dict, bool]] = {}

    def into(self, socket):
        """The link that counts at an input socket; None if there is none."""
        return self._of(socket.id_data)[0].get(socket.as_pointer())

    def circular(self, tree: bpy.types.NodeTree) -> bool:
        """Whether links form a circle, so that the tree is empty."""
        return self._of(tree)[1]

    def _of(self, tree: bpy.types.NodeTree) -> tuple[dict, bool]:
        key = tree.as_pointer()
        if key not in self._known:
            links = list(tree.links)
            counted = {
                link.to_socket.as_pointer(): link
                for link in links
                if link.is_valid and not link.is_muted and not link.to_socket.is_unavailable
            }
            # Blender marks a link that closes a circle, and some other links, as "not valid".
            circular = INLINED and len(counted) < len(links) and _circular(links)
            self._known[key] = counted, circular
        return self._known[key]


def _circular(links: list) -> bool:
    """Whether links, including muted ones, lead from a node back to itself. Remove nodes without incoming links until
    none is left; a rest means a circle."""
    following: dict[int, list[int]] = {}
    count: dict[int, int] = {}
    for link in links:
        if link.from_socket.is_unavailable or link.to_socket.is_unavailable:
            continue
        start, end = link.from_node.as_pointer(), link.to_node.as_pointer()
        following.setdefault(start, []).append(end)
        count[end] = count.get(end, 0) + 1
        count.setdefault(start, 0)
    free = [node for node, number in count.items() if not number]
    for node in free:  # the list grows
        for other in following.get(node, ()):
            count[other] -= 1
            if not count[other]:
                free.append(other)
    return len(free) < len(count)
