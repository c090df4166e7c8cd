# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Builds the scenes of docs/recipes.md, saves them as .blend files, and renders their pictures."""

from __future__ import annotations

import argparse
import pathlib
import sys
import textwrap
import time

import bpy
import host
import recipe_scenes
from recipe_scenes import RECIPES, Recipe

DOCS = host.REPOSITORY / "docs"
PICTURES = DOCS / "images" / "recipes"
QUALITY = 82
HEAD = """# Recipes

<!-- Made by `./scripts/recipes --document`; edit the docstrings of scripts/recipe_scenes instead. -->

This page has twenty scenes and the steps to their light. Before the first step, choose Render Properties > Render Engine >
**SDF Lights**, give the *World* a dark colour, and turn *Denoise* on. [first_steps.md](first_steps.md) explains the first
steps with the engine, and [lamps.md](lamps.md) explains the panels.

    ./scripts/recipes

builds each scene and saves it as a .blend in `build/recipes/`. It uses the operators and properties that the steps name.
With a name, such as `portal`, it builds one scene. `./scripts/recipes --render` also renders the pictures of this page.
"""
GALLERY = """# Gallery

<!-- Made by `./scripts/recipes --document`. -->

Each picture has its [recipe](recipes.md). `./scripts/recipes` saves its .blend.
"""


def recipes_page() -> str:
    """Text of docs/recipes.md."""
    parts, module = [HEAD], ""
    for made in RECIPES.values():
        if made.build.__module__ != module:
            module = made.build.__module__
            parts.append(f"\n## {sys.modules[module].__doc__.strip().partition(':')[0]}\n")
        listed = "\n".join(f"{number}. {step}" for number, step in enumerate(made.steps, 1))
        parts.append(
            f"\n### {made.title}\n\n![{made.title}](images/recipes/{made.name}.jpg)\n\n{made.about}\n\n{listed}\n"
        )
        for what, text in made.texts.items():
            parts.append(f"\nThe {what}:\n\n{textwrap.indent(text, '    ')}")
    return "".join(parts)


def gallery_page() -> str:
    """Text of docs/gallery.md."""
    parts = [GALLERY]
    for made in RECIPES.values():
        if made.gallery:
            target = made.title.lower().replace(" ", "-")
            parts.append(f"\n[![{made.title}](images/recipes/{made.name}.jpg)](recipes.md#{target})\n")
    return "".join(parts)


def document() -> None:
    (DOCS / "recipes.md").write_text(recipes_page(), encoding="utf-8")
    (DOCS / "gallery.md").write_text(gallery_page(), encoding="utf-8")


def render(scene: bpy.types.Scene, path: pathlib.Path) -> None:
    """Render the frame of a scene into a JPEG."""
    image = scene.render.image_settings
    if hasattr(image, "media_type"):  # since 5.0, where it limits the formats
        image.media_type = "IMAGE"
    image.file_format, image.quality, image.color_mode = "JPEG", QUALITY, "RGB"
    for stamp in ("filename", "date", "render_time"):  # a picture of the documents says nothing about a machine
        setattr(scene.render, f"use_stamp_{stamp}", False)
    path.parent.mkdir(parents=True, exist_ok=True)
    scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True)


def make(made: Recipe, folder: pathlib.Path, pictures: pathlib.Path | None, samples: int, percentage: int) -> None:
    """Save the scene of a recipe, and its picture where ``pictures`` is a folder."""
    scene = recipe_scenes.build(made.name)
    folder.mkdir(parents=True, exist_ok=True)
    bpy.ops.wm.save_as_mainfile(filepath=str(folder / f"{made.name}.blend"), compress=True)
    if pictures is None:
        return
    scene.render.resolution_percentage = percentage
    if samples:
        scene.sdf_lights.samples = samples
        if hasattr(scene, "cycles"):
            scene.cycles.samples = samples
    if scene.sdf_lights.beside is not None:  # follow these settings
        bpy.ops.sdf_lights.beside_cycles_add()
    render(scene, pictures / f"{made.name}.jpg")


def main(arguments: list[str]) -> int:
    parser = argparse.ArgumentParser(prog="recipes", description=__doc__)
    parser.add_argument("names", nargs="*", metavar="RECIPE", help=f"some of {', '.join(RECIPES)}; default: all")
    parser.add_argument("--out", type=pathlib.Path, default=host.REPOSITORY / "build" / "recipes", metavar="FOLDER")
    parser.add_argument("--render", action="store_true", help="render the pictures, too")
    parser.add_argument("--pictures", type=pathlib.Path, default=PICTURES, metavar="FOLDER", help="where they go")
    parser.add_argument("--samples", type=int, default=0, help="samples of a pixel; 0: those of the recipe")
    parser.add_argument("--percentage", type=int, default=100, help="size of the pictures in percent")
    parser.add_argument(
        "--document", action="store_true", help="write docs/recipes.md and docs/gallery.md, and nothing else"
    )
    options = parser.parse_args(arguments)
    for name in options.names:
        if name not in RECIPES:
            parser.error(f"there is no recipe {name!r}: choose from {', '.join(RECIPES)}")
    if options.document:
        document()
        return 0
    for name in options.names or RECIPES:
        started = time.perf_counter()
        pictures = options.pictures.resolve() if options.render else None
        make(RECIPES[name], options.out.resolve(), pictures, options.samples, options.percentage)
        print(f"{name}: {time.perf_counter() - started:.1f} s", flush=True)
    return 0


if __name__ == "__main__":
    host.finish(main(sys.argv[1:]))
