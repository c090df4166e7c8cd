# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Renders a .blend, by default the demo scene, through the registered engine, and writes an EXR and a PNG."""

from __future__ import annotations

import argparse
import hashlib
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import time

import bpy
import host
import OpenImageIO
from stages import Stages

DEMO_SCENE = host.REPOSITORY / "scripts" / "demo_scene.py"
SCENERY = host.REPOSITORY / "scripts" / "scenery"


# Stages, and their times on two idle cores of an AMD EPYC: ``./scripts/bench start`` measures the whole.
SCENE, KERNELS, SAMPLES, FINISH = "scene", "kernels", "samples", "finish"
EXPECTED = {SCENE: 8.0, KERNELS: 60.0, SAMPLES: 25.0, FINISH: 3.0}
PREVIEW_SIZE = "128x72"


class Failure(Exception):
    """One sentence for the user, and an exit code: 2 for a wrong call, 1 for a render that failed."""

    def __init__(self, sentence: str, code: int = 1):
        super().__init__(sentence)
        self.code = code


def size(text: str) -> tuple[int, int]:
    match = re.fullmatch(r"(\d+)x(\d+)", text)
    width, height = (int(match[1]), int(match[2])) if match else (0, 0)
    if not (4 <= width <= 65536 and 4 <= height <= 65536):
        raise argparse.ArgumentTypeError(f"{text!r} is not WIDTHxHEIGHT in pixels, such as 960x540")
    return width, height


def count(text: str) -> int:
    if not text.isdecimal() or not 1 <= int(text) <= 1 << 24:
        raise argparse.ArgumentTypeError(f"{text!r} is not a number of samples, from 1 to {1 << 24}")
    return int(text)


def seed(text: str) -> int:
    if not text.isdecimal() or int(text) >= 1 << 31:
        raise argparse.ArgumentTypeError(f"{text!r} is not a seed, from 0 to {(1 << 31) - 1}")
    return int(text)


def threshold(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = -1.0
    if not 0.0 <= value <= 1.0:
        raise argparse.ArgumentTypeError(f"{text!r} is not a relative error, from 0 to 1")
    return value


class Arguments(argparse.ArgumentParser):
    def error(self, message):
        """argparse would print the whole usage before the one sentence that matters."""
        raise Failure(f"demo: {message}.", 2)


def parse(arguments: list[str]) -> argparse.Namespace:
    parser = Arguments(prog="demo", description="Render the demo scene, or any .blend, with SDF Lights.")
    parser.add_argument(
        "--scene", type=pathlib.Path, metavar="FILE.blend", help="render this file, with its own settings"
    )
    parser.add_argument("--samples", type=count, help="most samples per pixel")
    parser.add_argument("--size", type=size, metavar="WIDTHxHEIGHT", help="resolution in pixels")
    parser.add_argument("--frame", type=int, help="frame to render")
    parser.add_argument("--seed", type=seed, help="seed of the sampling pattern")
    parser.add_argument(
        "--noise-threshold",
        type=threshold,
        metavar="ERROR",
        help="relative error at which a pixel gets no more samples; 0: all pixels get all",
    )
    parser.add_argument("--denoise", action=argparse.BooleanOptionalAction, help="remove the noise that is left")
    parser.add_argument("--device", choices=["automatic", "cpu", "reference"], help="what computes the picture")
    parser.add_argument("--strict", action="store_true", help="fail where something is not rendered as the scene says")
    parser.add_argument(
        "--out",
        type=pathlib.Path,
        default=host.REPOSITORY / "renders" / "demo",
        metavar="NAME",
        help="path of both pictures without ending (default: renders/demo)",
    )
    parser.add_argument("--preview", action="store_true", help=argparse.SUPPRESS)  # for a process that makes one
    return parser.parse_args(arguments)


def demo_scene() -> pathlib.Path:
    """The demo scene's .blend; if necessary, its script makes it in a separate process."""
    digest = hashlib.sha256(bpy.app.version_string.encode())
    sources = [DEMO_SCENE, host.REPOSITORY / "scripts" / "host.py", *sorted(SCENERY.glob("*.py"))]
    for source in sources:
        digest.update(source.read_bytes())
    path = host.REPOSITORY / "build" / "demo" / f"demo-{digest.hexdigest()[:12]}.blend"
    if not path.is_file():
        done = subprocess.run([sys.executable, DEMO_SCENE, path], capture_output=True, text=True)
        if done.returncode or not path.is_file():
            raise Failure(f"The demo scene could not be built:\n{done.stdout}{done.stderr}".rstrip())
    return path


def open_scene(options: argparse.Namespace):
    """Open the file, apply what the command line overrides and return the scene."""
    path = options.scene or demo_scene()
    try:
        bpy.ops.wm.open_mainfile(filepath=str(path.resolve()))
    except RuntimeError:
        raise Failure(f"demo: {path} is no .blend that this Blender ({bpy.app.version_string}) can open.", 2) from None
    scene = bpy.context.scene
    scene.render.engine = host.ENGINE
    settings = scene.sdf_lights
    for name in ("samples", "seed", "noise_threshold", "denoise"):
        value = getattr(options, name)
        if value is not None:
            setattr(settings, name, value)
    if options.device:
        settings.device = options.device.upper()
    if options.size:
        scene.render.resolution_x, scene.render.resolution_y = options.size
        scene.render.resolution_percentage = 100
    scene.view_layers[0].sdf_lights.use_pass_sample_count = True
    if options.frame is not None:
        scene.frame_set(options.frame)
    return scene


class Progress:
    """The stages of a render, from the engine's status text.

    Blender passes that to its ``render_stats`` handlers: «Remaining: 01:02 | … | Noise: 0.0123 | Sample 4/64».
    """

    def __init__(self, stages: Stages):
        self.stages = stages
        self.sampling_started = self.sampling_ended = None
        self.samples, self.noise = 0, None

    def __call__(self, status: str, _=None) -> None:
        now = time.perf_counter()
        text = status.rsplit(" | ", 1)[-1]
        sample = re.search(r"Sample (\d+)/(\d+)", text)
        noise = re.search(r"Noise: ([\d.]+)", status)
        remaining = re.search(r"Remaining: ([\d:]+)", status)
        kernels = re.search(r"(\d+) of (\d+)", text)
        part = int(kernels[1]) / max(int(kernels[2]), 1) if kernels else 0.0
        if noise:
            self.noise = float(noise[1])
        if sample:
            self.stages.begin(SAMPLES)
            self.samples = int(sample[1])
            self.sampling_started = self.sampling_started or now
            part = self.samples / int(sample[2])
            if remaining:
                left = 0
                for number in remaining[1].split(":"):
                    left = 60 * left + int(number)
                elapsed = now - self.sampling_started
                part = max(part, elapsed / (elapsed + left)) if elapsed + left > 0.0 else part
        elif self.samples:  # after the samples, such as denoising
            self.sampling_ended = self.sampling_ended or now
            self.stages.begin(FINISH)
        if self.noise is not None:
            text += f"  noise {100.0 * self.noise:.2f} %"
        self.stages.show(text, part)

    def close(self) -> None:
        self.sampling_ended = self.sampling_ended or time.perf_counter()


def render(scene, stages: Stages) -> tuple[Progress, float]:
    """Render the scene's frame through the engine. Returns its last status, and the total seconds."""
    progress = Progress(stages)
    bpy.app.handlers.render_stats.append(progress)
    started = time.perf_counter()
    try:
        bpy.ops.render.render(scene=scene.name)
    except RuntimeError as error:
        raise Failure(f"demo: the render failed: {str(error).removeprefix('Error: ').strip()}") from None
    finally:
        bpy.app.handlers.render_stats.remove(progress)
        progress.close()
        stages.close()
    if not progress.samples:
        raise Failure("demo: the render failed: no sample was taken; see the message above.")
    return progress, time.perf_counter() - started


class Preview:
    """A small picture by the NumPy reference, which compiles nothing, in a separate process while kernels compile."""

    def __init__(self, options: argparse.Namespace, out: pathlib.Path):
        self.path = out.with_name(out.name + "-preview.png")
        self._out = self.path.with_suffix("")
        arguments = ["--preview", "--device", "reference", "--samples", "1", "--denoise"]
        arguments += ["--size", PREVIEW_SIZE, "--out", str(self._out)]
        if options.scene:
            arguments += ["--scene", str(options.scene)]
        if options.frame is not None:
            arguments += ["--frame", str(options.frame)]
        command = [sys.executable, str(pathlib.Path(__file__).resolve()), *arguments]
        self._process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)

    def arrived(self) -> bool:
        """Whether it is there now; True once."""
        if self._process is None or self._process.poll() is None:
            return False
        code, self._process = self._process.returncode, None
        return code == 0 and self.path.is_file()

    def drop(self) -> None:
        """Remove it, because the picture itself is there."""
        if self._process is not None:
            self._process.kill()
            self._process.wait()
        for ending in (".png", ".exr"):
            self.path.with_suffix(ending).unlink(missing_ok=True)


def compile_kernels(stages: Stages, options: argparse.Namespace, out: pathlib.Path) -> Preview | None:
    """Wait until the kernels for a picture are compiled, by one process per core; a preview is made meanwhile."""
    background = host.program("render.cpu.background")
    if not background.running():
        return None
    stages.begin(KERNELS)
    preview = Preview(options, out)

    def look() -> None:
        done, total = background.progress()
        if preview.arrived():
            stages.say(f"{preview.path}  a preview")
        stages.show(background.text() or "Compiling kernels, once for this installation", done / max(total, 1))

    background.wait(look)
    return preview


def save(scene, path: pathlib.Path, file_format: str, **settings) -> None:
    """Save the render result; a format that is not linear goes through the scene's view transform."""
    image = scene.render.image_settings
    if hasattr(image, "media_type"):  # since 5.0, where it limits the formats
        image.media_type = "MULTI_LAYER_IMAGE" if "MULTILAYER" in file_format else "IMAGE"
    image.file_format = file_format
    for name, value in settings.items():
        setattr(image, name, value)
    bpy.data.images["Render Result"].save_render(str(path), scene=scene)
    if not path.is_file():
        raise Failure(f"demo: {path} could not be written.")


def write(scene, out: pathlib.Path) -> list[pathlib.Path]:
    """The picture as EXR, 32 bit float and scene-linear, and as PNG, as Blender shows it."""
    exr, png = (out.with_name(out.name + ending) for ending in (".exr", ".png"))
    save(scene, exr, "OPEN_EXR", color_mode="RGBA", color_depth="32", exr_codec="ZIP")
    save(
        scene,
        png,
        "PNG",
        color_mode="RGBA" if scene.render.film_transparent else "RGB",
        color_depth="8",
        compression=90,
    )
    return [exr, png]


def count_samples(scene) -> tuple[int, int]:
    """(pixels, total number of their samples), from the pass Sample Count of the first view layer."""
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "passes.exr"
        save(scene, path, "OPEN_EXR_MULTILAYER", color_depth="32")
        parts = range(OpenImageIO.ImageBuf(str(path)).nsubimages)
        pictures = [OpenImageIO.ImageBuf(str(path), part, 0) for part in parts]
        counts = next(
            picture.get_pixels(OpenImageIO.FLOAT)[..., index]
            for picture in pictures
            for index, name in enumerate(picture.spec().channelnames)
            if ".Sample Count." in name
        )
    return counts.size, round(float(counts.sum(dtype=float)))


def main(arguments: list[str]) -> int:
    try:
        options = parse(arguments)
        if options.scene and not options.scene.is_file():
            raise Failure(f"demo: there is no file {options.scene}.", 2)
        out = options.out.resolve()
        try:
            out.parent.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise Failure(f"demo: {out.parent} cannot be made: {error.strerror}.", 2) from None
        host.register_extension()
        if options.strict:
            os.environ["SDF_LIGHTS_STRICT"] = "1"
        stages = Stages(EXPECTED)
        stages.show("Building the scene" if options.scene is None else "Opening the scene")
        if not options.preview and options.device != "reference":
            background = host.program("render.cpu.background")
            background.start(low=False, processes=background.NEEDED)
        scene = open_scene(options)
        preview = None if options.preview else compile_kernels(stages, options, out)
        progress, seconds = render(scene, stages)
        paths = write(scene, out)
        if preview is not None:
            preview.drop()
        pixels, samples = count_samples(scene)
    except Failure as failure:
        print(failure, file=sys.stderr)
        return failure.code
    for path in paths:
        print(path)
    noise = "unknown, too few samples" if progress.noise is None else f"{100.0 * progress.noise:.2f} %"
    print(
        f"{pixels} pixels, {samples / pixels:.1f} samples per pixel, {seconds:.1f} s, "
        f"{samples / (progress.sampling_ended - progress.sampling_started) / 1e6:.3f} million samples/s, noise {noise}"
    )
    return 0


if __name__ == "__main__":
    try:
        code = main(sys.argv[1:])
    except SystemExit as stop:  # argparse, after --help
        code = stop.code or 0
    except KeyboardInterrupt:
        code = 130
    host.finish(code)
