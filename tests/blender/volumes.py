# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What tests of volumes beside Cycles share."""

import numpy as np

from tests.blender.node_trees import new

CLOSE = 0.01


def set_world(scene, color) -> None:
    scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = color


def agree(render, samples: int, close: float = CLOSE) -> None:
    ours, theirs = (picture[..., :3].mean((0, 1)) for picture in render(samples))
    assert theirs.max() > 1e-3
    np.testing.assert_allclose(ours, theirs, rtol=close, atol=close * theirs.max())


def linked(tree, source, kind: str, target: str, **values):
    """A new node with a link from the socket ``source`` to its input ``target``."""
    node = new(tree, kind, **values)
    tree.links.new(source, node.inputs[target])
    return node
