# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Nodes for tests of materials."""


def new(tree, kind: str, **values):
    """A node with values of its sockets by identifier (``_`` for a space), or with settings."""
    node = tree.nodes.new(kind)
    for name, value in values.items():
        socket = next((socket for socket in node.inputs if socket.identifier == name.replace("_", " ")), None)
        if socket is None:
            setattr(node, name, value)
        else:
            socket.default_value = value
    return node
