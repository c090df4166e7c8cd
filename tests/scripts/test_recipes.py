# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The recipes of docs/recipes.md: the page and its pictures are those of the script, and each scene is built and
rendered."""

import pathlib
import re
import subprocess
import sys

import pytest

pytest.importorskip("bpy")
OpenImageIO = pytest.importorskip("OpenImageIO")

import recipes  # noqa: E402  (found on the path that conftest.py sets)
from recipe_scenes import RECIPES  # noqa: E402

from sdf_lights.blender.presets import presets  # noqa: E402
from sdf_lights.sdf.shapes import SHAPES  # noqa: E402

KIB = 1024


def test_pages_are_those_of_the_script():
    assert (recipes.DOCS / "recipes.md").read_text(encoding="utf-8") == recipes.recipes_page()
    assert (recipes.DOCS / "gallery.md").read_text(encoding="utf-8") == recipes.gallery_page()


def test_every_recipe_has_steps_and_a_picture():
    assert len(RECIPES) == 20 and sum(made.gallery for made in RECIPES.values()) == 8
    assert all(made.about and len(made.steps) >= 3 for made in RECIPES.values())
    pictures = {path.stem: path for path in recipes.PICTURES.iterdir()}
    assert pictures.keys() == RECIPES.keys()
    for name, path in pictures.items():
        spec = OpenImageIO.ImageBuf(str(path)).spec()
        assert (spec.width, spec.height) == RECIPES[name].size, name
    assert sum(path.stat().st_size for path in pictures.values()) < 1500 * KIB


def test_steps_name_presets_and_shapes_that_exist():
    presets_there = {preset.title for preset in presets().values()}
    shapes_there = {shape.label() for shape in SHAPES.values()}
    named = dict(presets=set(), shapes=set())
    for step in (step for made in RECIPES.values() for step in made.steps):
        for listed in re.findall(r"[Pp]resets? (?:> )?((?:\*\*[^*]+\*\*(?:,? and )?)+)", step):
            named["presets"] |= set(re.findall(r"\*\*([^*]+)\*\*", listed))
        named["shapes"] |= set(re.findall(r"SDF Lamp > [A-Z]\w+ > \*\*([^*]+)\*\*", step))
    named["shapes"] -= named["presets"]
    assert len(named["presets"]) > 8 and len(named["shapes"]) > 3
    assert named["presets"] <= presets_there and named["shapes"] <= shapes_there


def _made(name: str, folder: pathlib.Path) -> None:
    """Runs the command for a recipe, with a tiny picture."""
    command = [sys.executable, pathlib.Path(recipes.__file__), name, "--render", "--out", folder, "--pictures", folder]
    done = subprocess.run(
        [*command, "--samples", "1", "--percentage", "8"], capture_output=True, text=True, timeout=600
    )
    printed = done.stdout + done.stderr
    assert done.returncode == 0 and "Traceback" not in printed, printed
    assert "left out" not in printed, printed  # no lamp has a mistake
    assert (folder / f"{name}.blend").stat().st_size > 10 * KIB
    picture = OpenImageIO.ImageBuf(str(folder / f"{name}.jpg"))
    light = OpenImageIO.ImageBufAlgo.computePixelStats(picture)
    assert max(light.max[:3]) > 0.5 and max(light.stddev[:3]) > 0.05


def test_a_recipe_is_built_and_rendered(tmp_path):
    _made("statue_of_light", tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize("name", RECIPES)
def test_recipe(name, tmp_path):
    _made(name, tmp_path)
