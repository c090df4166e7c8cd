# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The table of value nodes has all of them, by the names that Blender shows."""

import pytest

from sdf_lights.render.nodes import DEFINITIONS
from sdf_lights.render.nodes.reference import markdown, name_of, rows


def test_every_node_has_a_row_with_a_remark():
    assert len(rows()) == len({name for name, _, _ in rows()}) == len(DEFINITIONS)
    assert all(remark.endswith(".") for _, _, remark in rows())
    assert "| Vector Math | add, " in markdown()


def test_names_are_those_of_blender():
    bpy = pytest.importorskip("bpy")
    if bpy.app.version < (5, 0):
        pytest.skip("some nodes have other names")
    shown = {node: getattr(bpy.types, node).bl_rna.name for node in DEFINITIONS if hasattr(bpy.types, node)}
    assert shown == {node: name_of(node) for node in shown}
