# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Node trees of type SDF Lamp. ``modules`` lists what there is to register."""


def modules() -> tuple:
    """Modules with ``CLASSES``, in order of registration."""
    # Not before: the properties of a lamp are read through this package too.
    from . import editor, emission_nodes, function_nodes, groups, link_search, scene, sockets, tree, value_nodes

    return sockets, tree, function_nodes, value_nodes, scene, emission_nodes, groups, link_search, editor
