# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Files that come with Blender open and render; what cannot is told, and no exception ends the run."""

import pathlib
import sys

import bpy
import pytest

SCRIPTS = pathlib.Path(__file__).resolve().parents[2] / "scripts"
sys.path.insert(0, str(SCRIPTS))

import open_files  # noqa: E402  (found on the path set above)

ASSETS = pathlib.Path(bpy.utils.resource_path("LOCAL")) / "datafiles" / "assets"
BUNDLED = sorted({path.resolve() for path in ASSETS.rglob("*.blend")})


pytestmark = pytest.mark.slow


def test_bundled_files_open_and_render():
    rows = open_files.rows_of(BUNDLED, 16, 1)
    assert len(rows) == len(BUNDLED) > 0
    assert {row["file"]: row["errors"] for row in rows if row["errors"]} == {}
    # What is not rendered as it says is told by the names of a file's things, in sentences.
    told = [sentence for row in rows for sentence in row["not_modelled"]]
    assert [sentence for sentence in told if "Traceback" in sentence or not sentence.endswith(".")] == []
    assert sum(row["scenes"] + row["shown_apart"] for row in rows) > 0


def test_what_no_scene_shows_is_rendered_too(file, material, tmp_path):
    """A material that nobody uses, with a node that is not modelled; and what is no .blend is told of."""
    made, tree, output = material("Unused")
    made.use_fake_user = True
    node = tree.nodes.new("ShaderNodeUVAlongStroke")
    link = tree.links.new(node.outputs[0], tree.nodes.new("ShaderNodeEmission").inputs["Color"])
    tree.links.new(link.to_node.outputs[0], output)
    path, other = tmp_path / "unused.blend", tmp_path / "other.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path), copy=True)
    other.write_text("This is a text.")
    good, bad = open_files.rows_of(open_files.files_in([path, other]), 16, 1)
    assert good["errors"] == [] and good["shown_apart"] >= 1
    assert any("UV Along Stroke" in sentence for sentence in good["not_modelled"])
    assert len(bad["errors"]) == 1 and "Traceback" not in bad["errors"][0]
