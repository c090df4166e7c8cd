# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Takes screenshots of the documents again, in a Blender with a window.

    SDF_LIGHTS_BLENDER="xvfb-run -a blender" scripts/artist_screenshots [SESSION …]

Needs ImageMagick's `import`.
"""

from __future__ import annotations

import argparse
import os
import pathlib
import shutil
import sys
import tempfile

import build_extension
import numpy as np
from host import NO_WINDOW, REPOSITORY, python_of, windowed_blender
from sessions import seen_by

PICTURES = {  # session: files in docs/images by the picture's name
    "screenshots": {
        "sidebar": "lamp_sidebar",
        "mistake": "lamp_mistake",
        "error": "lamp_error",
        "nodes": "lamp_nodes",
        "nodes_mistake": "lamp_nodes_mistake",
        "solid": "viewport_solid",
        "rendered": "viewport_rendered",
    },
    "properties": {
        "view_layer": "panels_view_layer",
        "view_layer_end": "panels_view_layer_end",
        "world": "panels_world",
        "light": "panels_light",
        "lamp": "panels_lamp",
        "report": "panels_report",
        "object": "panels_object",
        "overlay": "panels_overlay",
        "other_engine": "panels_other_engine",
        "feedback": "panels_warnings",
    },
    "nodes": {"node_emission": "lamp_nodes_emission"},  # these three are sessions of the tests
    "panels": {"preset_browser": "lamp_presets"},
    "bounds": {"circle_select": "lamp_circle_select"},
    "native": {"arrow_label": "lamp_arrow", "last_good": "lamp_last_good", "warnings": "lamp_warnings"},
}

# Panels by the files in docs/images that show them open: names without SDFLIGHTS_PT_. Menus of presets, which open from
# a button in a header, are left out.
PANELS = {
    "lamp_sidebar.png": "view3d view3d_shape view3d_emission view3d_pattern view3d_visibility presets",
    "panels_warnings.png": "feedback",
    "panels_lamp.png": "light_shape light_emission light_pattern light_visibility light_readout light_details",
    "panels_light.png": "light",
    "panels_object.png": "object_visibility",
    "panels_other_engine.png": "other_engine",
    "panels_overlay.png": "overlay",
    "panels_render.jpg": "sampling sampling_viewport sampling_render sampling_advanced light_paths light_paths_bounces "
    "light_paths_clamping light_paths_caustics film performance simplify simplify_viewport simplify_render "
    "simplify_culling motion_blur motion_blur_curve scene_report",
    "panels_view_layer.png": "passes passes_data",
    "panels_view_layer_end.png": "passes_light override",
    "panels_world.png": "world_preview",
}

WALK = (
    "start",
    "engine",
    "search",
    "added",
    "placed",
    "rendered",
)  # pictures of the session "walk", in a strip of rows
RENDER_TAB = ("render_0", "render_1", "render_2")  # pictures of the session "properties", side by side
FIRST_MINUTE = ("start", "installed", "lamp", "first_pixels", "viewport", "picture")
KNOWN = (*PICTURES, "walk", "first_minute")
ROW, WIDTH, QUALITY = 2, 1300, 68


def write_strip(
    folder: pathlib.Path, names: tuple[str, ...], path: pathlib.Path, row: int = ROW, across: int = WIDTH
) -> None:
    """Pictures side by side, ``row`` in each row, as one JPEG that is ``across`` pixels wide."""
    import OpenImageIO

    algorithms = OpenImageIO.ImageBufAlgo
    parts = []
    for name in names:
        whole = OpenImageIO.ImageBuf(str(folder / f"{name}.png"))
        width = across // row
        height = round(whole.spec().height * width / whole.spec().width)
        small = algorithms.resize(whole, filtername="lanczos3", roi=OpenImageIO.ROI(0, width, 0, height, 0, 1, 0, 3))
        parts.append(small.get_pixels(OpenImageIO.FLOAT)[..., :3])
    rows = [np.concatenate(parts[first : first + row], axis=1) for first in range(0, len(parts), row)]
    strip = np.ascontiguousarray(np.concatenate(rows, axis=0))
    spec = OpenImageIO.ImageSpec(strip.shape[1], strip.shape[0], 3, "uint8")
    spec.attribute("Compression", f"jpeg:{QUALITY}")
    made = OpenImageIO.ImageBuf(spec)
    made.set_pixels(OpenImageIO.ROI.All, strip)
    if not made.write(str(path)):
        raise OSError(made.geterror())


def first_minute(command: list[str], folder: pathlib.Path) -> None:
    """Install a zip in a Blender with empty user folders, and take the strip of its first minute."""
    session = REPOSITORY / "scripts" / "first_minute_session.py"
    platform = build_extension.this_platform()
    path = build_extension.build(platform, python_of(command), folder, with_kernels=True)
    # The preferences show where the add-on is: a name that says nothing about a machine.
    shown = pathlib.Path(tempfile.gettempdir()) / "blender"
    shown.mkdir()
    kept = os.environ.pop("SDF_LIGHTS_CACHE", None)
    try:
        environment = {"BLENDER_USER_RESOURCES": str(shown)}
        report = seen_by(command, session, folder, str(path), str(folder), environment=environment, size=(1240, 800))
    finally:
        shutil.rmtree(shown)
        if kept is not None:
            os.environ["SDF_LIGHTS_CACHE"] = kept
    print({name: round(seconds, 1) for name, seconds in report["seconds"].items()})
    pictures = REPOSITORY / "docs" / "images"
    write_strip(folder, FIRST_MINUTE, pictures / "first_minute.jpg")
    shutil.copyfile(folder / "preferences.png", pictures / "panels_preferences.png")


def main(arguments: list[str]) -> None:
    parser = argparse.ArgumentParser(prog="artist_screenshots", description=__doc__.splitlines()[0])
    parser.add_argument("sessions", nargs="*", metavar="SESSION", help=f"of {', '.join(KNOWN)}; default: all")
    options = parser.parse_args(arguments)
    command = windowed_blender()
    if command is None:
        parser.error(NO_WINDOW)
    for name in options.sessions or KNOWN:
        if name not in KNOWN:
            parser.error(f"there is no session {name!r}: choose from {', '.join(KNOWN)}")
        with tempfile.TemporaryDirectory() as folder:
            if name == "first_minute":
                first_minute(command, pathlib.Path(folder))
                continue
            session = next(REPOSITORY.glob(f"*/**/{name}_session.py"))
            seen_by(command, session, pathlib.Path(folder), folder, **({"size": (1240, 800)} if name == "walk" else {}))
            if name == "walk":
                write_strip(pathlib.Path(folder), WALK, REPOSITORY / "docs" / "images" / "walk.jpg")
            if name == "properties":
                path = REPOSITORY / "docs" / "images" / "panels_render.jpg"
                write_strip(pathlib.Path(folder), RENDER_TAB, path, row=3, across=1440)
            for picture, file in PICTURES.get(name, {}).items():
                shutil.copyfile(pathlib.Path(folder) / f"{picture}.png", REPOSITORY / "docs" / "images" / f"{file}.png")


if __name__ == "__main__":
    main(sys.argv[1:])
