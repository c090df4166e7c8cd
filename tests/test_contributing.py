# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""CONTRIBUTING.md tells the truth: the files of each recipe are those that one thing of its kind needs today."""

import pathlib
import re
import subprocess

import pytest

REPOSITORY = pathlib.Path(__file__).resolve().parents[1]
TEXT = (REPOSITORY / "CONTRIBUTING.md").read_text(encoding="utf-8")
RECIPES = dict(re.findall(r"^### ([^\n]*)\n(.*?)(?=^### |\Z)", TEXT, re.DOTALL | re.MULTILINE))

# What a file mentions if it knows of the example of a recipe, and folders that mention it for other reasons.
EXAMPLES = {
    "A shape": (r"\bclass Gyroid\b", ()),
    "A shape with closed-form intersection": (r"\bTORUS\b|\btorus_", ("sdf_lights/sdf/shapes/",)),
    "A value node": (r"\bShaderNodeGamma\b", ()),
    "A BSDF": (r"\btoon\b|Toon\b|TOON\b", ()),
    "A light": (r"\bAreaLight\b|(?<!\")\bAREA\b(?!\")", ()),
    "A pass": (r"\bglossy_albedo\b", ()),
    "A sampler": (r"(?i)sobol_", ()),
}
PRODUCT = ("sdf_lights", "shaders_glsl")
SOURCES = (".py", ".glsl", ".comp")


def test_every_recipe_has_an_example():
    assert set(RECIPES) == set(EXAMPLES)


@pytest.mark.parametrize("recipe", RECIPES)
def test_files_of_a_recipe_exist(recipe):
    named = re.findall(r"`([\w.]+(?:/[\w.]+)*/?)`", RECIPES[recipe])
    paths = [name for name in named if "/" in name]
    assert paths and [path for path in paths if not (REPOSITORY / path).exists()] == []


@pytest.mark.parametrize("recipe", EXAMPLES)
def test_a_recipe_lists_the_files_that_know_of_its_example(recipe):
    """If this fails, the list in CONTRIBUTING.md is longer or shorter than it says: the shorter, the better."""
    pattern, elsewhere = EXAMPLES[recipe]
    listed = set(re.findall(r"^\d+\. `([^`]+)`", RECIPES[recipe], re.MULTILINE))
    tracked = subprocess.run(
        ["git", "ls-files", *PRODUCT], cwd=REPOSITORY, capture_output=True, text=True, check=True
    ).stdout.split("\n")
    knowing = {
        name
        for name in tracked
        if name.endswith(SOURCES)
        and (REPOSITORY / name).is_file()
        and re.search(pattern, (REPOSITORY / name).read_text(encoding="utf-8"))
    }
    assert {name for name in listed if not name.startswith(elsewhere)} == {
        name for name in knowing if not name.startswith(elsewhere)
    }


def test_the_table_counts_the_lists():
    table = dict(re.findall(r"^\| (A [^|]*) \| [^|]* \| (\d+) \|$", TEXT, re.MULTILINE))
    counts = {recipe: len(re.findall(r"^\d+\. `", text, re.MULTILINE)) for recipe, text in RECIPES.items()}
    assert {recipe: int(count) for recipe, count in table.items()} == counts
