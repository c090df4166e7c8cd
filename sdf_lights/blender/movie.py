# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A movie from joined frames of a render farm: ``blender -c sdf_lights_movie OUT.mp4 FILE.blend IN.exr …``.

Blender's own sequencer makes it, with the color management and the frame rate of the file.
"""

from __future__ import annotations

import argparse
import glob
import os
import re

import bpy

_VIEW = (
    "view_transform",
    "look",
    "exposure",
    "gamma",
    "use_white_balance",
    "white_balance_temperature",
    "white_balance_tint",
)
_EVEN = 2  # H.264 halves the colour resolution


def write(out: str, scene: bpy.types.Scene, frames: list[str]) -> None:
    """Write pictures, in this order, as an H.264 movie with the colour management of ``scene``. Raises RuntimeError if
    Blender fails."""
    made = bpy.data.scenes.new("Movie")
    try:
        editor = made.sequence_editor_create()
        strips = editor.strips if hasattr(editor, "strips") else editor.sequences  # renamed in 4.4, removed in 5.0
        strip = strips.new_image("Frames", frames[0], 1, 1)
        if os.path.dirname(frames[0]) != os.path.dirname(frames[-1]):
            raise RuntimeError("frames are in several folders: put them into one.")
        for path in frames[1:]:
            strip.elements.append(os.path.basename(path))
        width, height = strip.elements[0].orig_width, strip.elements[0].orig_height
        if not width or not height:
            raise RuntimeError(f"{frames[0]} is not a picture.")
        render = made.render
        render.resolution_x, render.resolution_y = width - width % _EVEN, height - height % _EVEN
        render.resolution_percentage = 100
        render.fps, render.fps_base = scene.render.fps, scene.render.fps_base
        made.frame_start, made.frame_end = 1, len(frames)
        made.display_settings.display_device = scene.display_settings.display_device
        for name in _VIEW:
            if hasattr(scene.view_settings, name):
                setattr(made.view_settings, name, getattr(scene.view_settings, name))
        settings = render.image_settings
        if hasattr(settings, "media_type"):  # new in 5.0
            settings.media_type = "VIDEO"
        settings.file_format = "FFMPEG"
        render.ffmpeg.format, render.ffmpeg.codec, render.ffmpeg.constant_rate_factor = "MPEG4", "H264", "HIGH"
        part = f"{out}.part.mp4"
        render.filepath, render.use_file_extension = part, False
        bpy.ops.render.render(animation=True, scene=made.name)
        os.replace(part, out)
    finally:
        bpy.data.scenes.remove(made)


def command(words: list[str]) -> int:
    """Runs ``sdf_lights_movie``; returns the exit code. Raises RuntimeError with a sentence if it cannot."""
    parser = argparse.ArgumentParser(prog="sdf_lights_movie", description="Makes a movie of rendered frames.")
    parser.add_argument("out", help="the movie to write, an .mp4")
    parser.add_argument("file", help="the .blend with the color management and the frame rate of the movie")
    parser.add_argument("frames", nargs="+", help="pictures in their order, or patterns such as 'frames/*.exr'")
    chosen = parser.parse_args(words)
    found = [path for pattern in chosen.frames for path in (sorted(glob.glob(pattern), key=_number) or [pattern])]
    missing = next((path for path in found if not os.path.isfile(path)), None)
    try:
        if missing is not None:
            raise RuntimeError(f"there is no picture {missing}: render it first.")
        bpy.ops.wm.open_mainfile(filepath=os.path.abspath(chosen.file), load_ui=False)
        write(os.path.abspath(chosen.out), bpy.context.scene, [os.path.abspath(path) for path in found])
    except (OSError, RuntimeError) as error:
        print(f"sdf_lights_movie: {str(error).strip()}")
        return 1
    print(f"{chosen.out} has {len(found)} frames.")
    return 0


def _number(path: str) -> tuple[int, str]:
    """Sorts by the last number of a name, so frame 10,000 comes after 9999."""
    numbers = re.findall(r"\d+", os.path.basename(path))
    return (int(numbers[-1]) if numbers else 0, path)
