# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Links of node trees: which one counts at an input, where they go round in a circle, and what an input has that leads nowhere."""

from __future__ import annotations

import bpy

INLINED = bpy.app.version >= (5, 0, 0)
"""Whether Blender takes groups apart before Cycles sees them. Then values of a group's inputs stay where a texture has coordinates
of its own, an input that leads nowhere has its own value, and a tree whose links go round in a circle is nothing. Until then such a
texture has its own coordinates, an input that leads nowhere is zero, and the link that closes a circle is not there."""


class _Nowhere:
    """Stands for the socket at the end of a walk that leads nowhere. Textures, normals and shaders take it for no link."""

    type, identifier, default_value, hide_value = "VALUE", "", 0.0, True

    def as_pointer(self) -> int:
        return 0


NOWHERE = _Nowhere()


class Links:
    """Those of all trees that a walk comes to. Blender searches all links of a tree for each input, so a tree is gone through once."""

    def __init__(self):
        self._known: dict[int, tuple[dict, bool]] = {}

    def into(self, socket):
        """The link that counts at an input socket; None where there is none."""
        return self._of(socket.id_data)[0].get(socket.as_pointer())

    def circular(self, tree: bpy.types.NodeTree) -> bool:
        """Whether links go round in a circle, so that there is nothing of the tree."""
        return self._of(tree)[1]

    def _of(self, tree: bpy.types.NodeTree) -> tuple[dict, bool]:
        if tree.as_pointer() not in self._known:
            links = list(tree.links)
            counted = {
                link.to_socket.as_pointer(): link
                for link in links
                if link.is_valid and not link.is_muted and not link.to_socket.is_unavailable
            }
            # Blender says "not valid" of a link that closes a circle, and of some others.
            circular = INLINED and len(counted) < len(links) and _circular(links)
            self._known[tree.as_pointer()] = counted, circular
        return self._known[tree.as_pointer()]


def _circular(links: list) -> bool:
    """Whether links, muted ones too, lead from a node to itself: taking away all nodes that none leads into leaves some."""
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
    for node in free:  # grows
        for other in following.get(node, ()):
            count[other] -= 1
            if not count[other]:
                free.append(other)
    return len(free) < len(count)
