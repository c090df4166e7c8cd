# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Jobs for render farms, as Open Job Description templates: frames × ranges of samples, then one picture for each
frame, then an optional movie.

A farm that reads such a template, or ``openjd run`` on one machine, starts the tasks and repeats failed ones. An
operator writes it, or ``blender -c sdf_lights_job OUT.json FILE.blend``. Specification: "Open Job Description",
template schema 2023-09.
"""

from __future__ import annotations

import argparse
import json
import os
import pathlib
import re

import bpy
from bpy_extras.io_utils import ExportHelper

from .naming import ENGINE

_PARTS = "parts"
_MOST_VALUES = 1024  # of a task parameter, by the specification


def ranges(samples: int, count: int) -> list[tuple[int, int]]:
    """(first, end) of at most ``count`` ranges of ``samples`` samples. Their lengths differ by at most one."""
    ends = [samples * index // count for index in range(count + 1)]
    return [(first, end) for first, end in zip(ends, ends[1:]) if end > first]


def template(
    place: pathlib.Path,
    file: pathlib.Path,
    folder: pathlib.Path,
    frames: str,
    samples: int,
    count: int,
    denoise: bool,
    movie: bool,
) -> dict:
    """The job: ``frames`` such as ``"1-10"`` or ``"1-100:2"`` of a .blend, with ``count`` tasks for each frame, into a
    folder.

    ``place`` is the path of the template. Paths below its folder are defaults. The specification allows no others, so
    others must be given with the job. Joined parts get a temporary name and are renamed at the end, so an existing
    frame is complete.
    """
    shares = ranges(samples, min(count, _MOST_VALUES))
    firsts, ends = ([str(value) for value in values] for values in zip(*shares))
    frame = {"name": "Frame", "type": "INT", "range": "{{Param.Frames}}"}

    def step(title: str, parameters: list[dict], arguments: list[str], **rest) -> dict:
        run = {"command": "{{Param.Blender}}", "args": arguments, "cancelation": {"mode": "TERMINATE"}}
        space: dict = {"taskParameterDefinitions": parameters}
        if len(parameters) > 1:
            space["combination"] = "Frame * (First, End)"
        tasks = {"parameterSpace": space} if parameters else {}
        return {"name": title, **tasks, "script": {"actions": {"onRun": run}}, **rest}

    def part(first: str) -> str:
        return f"{{{{Param.Folder}}}}/{_PARTS}/{first}_####"

    render = step(
        "Render",
        [
            frame,
            *({"name": key, "type": "STRING", "range": values} for key, values in (("First", firsts), ("End", ends))),
        ],
        [
            *("-b", "{{Param.File}}", "-E", ENGINE, "-F", "OPEN_EXR_MULTILAYER"),
            *("-o", part("{{Task.Param.First}}"), "-f", "{{Task.Param.Frame}}"),
            *("--", "--sdf-samples", "{{Task.Param.First}}:{{Task.Param.End}}"),
        ],
    )
    merge = step(
        "Merge",
        [frame],
        [
            *("-c", "sdf_lights_merge", "--frame", "{{Task.Param.Frame}}", *(["--denoise"] if denoise else [])),
            *("{{Param.Folder}}/####.exr", *(part(first) + ".exr" for first in firsts)),
        ],
        dependencies=[{"dependsOn": "Render"}],
    )
    steps = [render, merge]
    if movie:
        arguments = ["-c", "sdf_lights_movie", "{{Param.Folder}}/movie.mp4", "{{Param.File}}", "{{Param.Folder}}/*.exr"]
        steps.append(step("Movie", [], arguments, dependencies=[{"dependsOn": "Merge"}]))

    def path(title: str, kind: str, flow: str, default: pathlib.Path) -> dict:
        found = {"name": title, "type": "PATH", "objectType": kind, "dataFlow": flow}
        inside = default.is_relative_to(place.parent)
        return found | ({"default": default.relative_to(place.parent).as_posix()} if inside else {})

    return {
        "specificationVersion": "jobtemplate-2023-09",
        "name": file.stem[:128],
        "parameterDefinitions": [
            path("File", "FILE", "IN", file),
            path("Folder", "DIRECTORY", "OUT", folder),
            {"name": "Frames", "type": "STRING", "default": frames},
            {"name": "Blender", "type": "STRING", "default": "blender", "description": "Command that starts Blender"},
        ],
        "steps": steps,
    }


def write(place: str, file: str, folder: str | None, *rest) -> None:
    """Write the template of a job; ``rest`` is as in ``template``. Frames go beside the file by default. Raises
    OSError."""
    job, blend = pathlib.Path(os.path.abspath(place)), pathlib.Path(os.path.abspath(file))
    frames = pathlib.Path(os.path.abspath(folder)) if folder else blend.with_name(f"{blend.stem} frames")
    made = template(job, blend, frames, *rest)
    job.write_text(json.dumps(made, indent=2, ensure_ascii=False) + "\n", encoding="utf-8")


def _frames(text: str) -> str:
    """Frames of the command line, in the notation of templates. Raises argparse.ArgumentTypeError."""
    for part in text.split(","):
        found = re.fullmatch(r"\s*(-?\d+)(?:-(-?\d+)(?::(\d+))?)?\s*", part, re.ASCII)
        if found is None or found[2] and int(found[2]) < int(found[1]) or found[3] and int(found[3]) == 0:
            raise argparse.ArgumentTypeError(f"{text!r} are not frames: write them as 7, 1-10 or 1-100:2")
    return text


def _at_least_one(text: str) -> int:
    if not (text.isascii() and text.isdecimal() and int(text[:12]) > 0):
        raise argparse.ArgumentTypeError(f"{text!r} is not a number: write a whole number from 1")
    return int(text)


def frames_of(scene: bpy.types.Scene) -> str:
    """The frame range of a scene, in the notation of templates."""
    step = f":{scene.frame_step}" if scene.frame_step > 1 else ""
    return f"{scene.frame_start}-{scene.frame_end}{step}"


class SDFLIGHTS_OT_render_job_write(bpy.types.Operator, ExportHelper):
    """Write a job for a render farm: an Open Job Description template of the frames of this scene. Several machines
    share the samples of each frame"""

    bl_idname = "sdf_lights.render_job_write"
    bl_label = "Write Render Job"
    filename_ext = ".json"
    filter_glob: bpy.props.StringProperty(default="*.json", options={"HIDDEN"})
    tasks: bpy.props.IntProperty(
        name="Tasks per Frame",
        description="Number of tasks that share the samples of a frame",
        default=4,
        min=1,
        max=256,
    )
    denoise: bpy.props.BoolProperty(
        name="Denoise",
        description="Denoise each joined frame. The pass Denoising Data keeps more detail",
        default=False,
    )
    movie: bpy.props.BoolProperty(
        name="Movie", description="Make a movie of the joined frames, as this scene shows them", default=False
    )

    @classmethod
    def poll(cls, context):
        if context.scene.render.engine != ENGINE:
            cls.poll_message_set("SDF Lights is not the render engine of this scene")
            return False
        return True

    def execute(self, context):
        scene = context.scene
        if not bpy.data.filepath:
            self.report({"ERROR"}, "This file has no name yet: save it, so that other machines can open it.")
            return {"CANCELLED"}
        settings = frames_of(scene), scene.sdf_lights.samples, self.tasks, self.denoise, self.movie
        try:
            write(self.filepath, bpy.data.filepath, None, *settings)
        except OSError as error:
            self.report({"ERROR"}, f"{self.filepath} cannot be written ({error.strerror}): choose another folder.")
            return {"CANCELLED"}
        if bpy.data.is_dirty:
            self.report({"WARNING"}, "The job renders the saved file: save it to include its last changes in the job.")
        self.report({"INFO"}, f"{self.filepath} has the job.")
        return {"FINISHED"}


def command(words: list[str]) -> int:
    """``sdf_lights_job``; the exit code."""
    parser = argparse.ArgumentParser(prog="sdf_lights_job", description="Writes a job for a render farm.")
    parser.add_argument("out", help="the template to write, a .json")
    parser.add_argument("file", help="the .blend to render")
    parser.add_argument("--frames", type=_frames, help="such as 1-10 or 1-100:2; by default those of the file")
    parser.add_argument("--samples", type=_at_least_one, help="by default those of the file")
    parser.add_argument("--tasks", type=_at_least_one, default=4, help="tasks that share the samples of a frame")
    parser.add_argument("--folder", help="folder of the frames; by default beside the file")
    parser.add_argument("--denoise", action="store_true", help="denoise each joined frame")
    parser.add_argument("--movie", action="store_true", help="make a movie of the joined frames")
    chosen = parser.parse_args(words)
    try:
        bpy.ops.wm.open_mainfile(filepath=os.path.abspath(chosen.file), load_ui=False)
        scene = bpy.context.scene
        frames, samples = chosen.frames or frames_of(scene), chosen.samples or scene.sdf_lights.samples
        wanted = chosen.tasks, chosen.denoise, chosen.movie
        write(chosen.out, chosen.file, chosen.folder, frames, samples, *wanted)
    except (OSError, RuntimeError) as error:
        print(f"sdf_lights_job: {str(error).strip()}")
        return 1
    print(f"{chosen.out} has the job.")
    return 0


def _draw(self, context):
    if context.scene.render.engine == ENGINE:
        self.layout.separator()
        self.layout.operator(SDFLIGHTS_OT_render_job_write.bl_idname)


CLASSES = (SDFLIGHTS_OT_render_job_write,)


def register():
    bpy.types.TOPBAR_MT_render.append(_draw)


def unregister():
    bpy.types.TOPBAR_MT_render.remove(_draw)
