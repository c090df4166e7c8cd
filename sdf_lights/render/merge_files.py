# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Joins OpenEXR files of renders that shared the samples of a frame (``--sdf-samples 0:64``, ``64:128`` and so on).

Every pass is joined by its own rule, weighted by the number of samples recorded in each file.
"""

from __future__ import annotations

import argparse
import os
import pathlib
import re
import sys
from dataclasses import dataclass

import numpy as np
import OpenImageIO as oiio

from ..kernel_cache import drop
from .denoise import denoise
from .errors import RenderError, reason_of
from .merging import Layer, MergeError, Shares, joined, joined_metadata, merge, shares


@dataclass
class Part:
    """A part of a file: its metadata, and its pixels (height, width, channels)."""

    spec: oiio.ImageSpec
    pixels: np.ndarray


def groups(parts: list[Part]) -> dict[tuple[str, str], dict[str, tuple[int, list[int]]]]:
    """The part and the channels of each pass, by (view layer, view). Blender writes one part for each pass, or one for
    all."""
    found: dict[tuple[str, str], dict[str, tuple[int, list[int]]]] = {}
    for index, part in enumerate(parts):
        views = str(part.spec.getattribute("multiView") or part.spec.getattribute("view") or "")
        for number, channel in enumerate(part.spec.channelnames):
            *place, last = channel.split(".")
            view = place.pop() if len(place) > 2 and place[-1] in views else ""
            name = place.pop() if place else "Depth" if last == "Z" else "Combined"
            found.setdefault((".".join(place), view), {}).setdefault(name, (index, []))[1].append(number)
    return found


def read(path: pathlib.Path) -> list[Part]:
    """The parts of a file. Raises MergeError."""
    source = oiio.ImageInput.open(str(path))
    if source is None:
        raise MergeError(f"{path} cannot be read ({reason_of(oiio, 'no reason is given')}): render that range again")
    parts = []
    try:
        while source.seek_subimage(len(parts), 0):
            spec = source.spec()
            pixels = source.read_image(len(parts), 0, 0, spec.nchannels, oiio.FLOAT)
            if pixels is None:
                raise MergeError(
                    f"{path} cannot be read ({reason_of(source, 'no reason is given')}): render that range again"
                )
            parts.append(Part(spec, pixels))
    finally:
        source.close()
    return parts


def shares_of(path: pathlib.Path, told: dict[str, Shares], layer: str) -> Shares:
    """The samples of a view layer of a file; a file with one layer does not name it. Raises MergeError."""
    if layer in told:
        return told[layer]
    if not layer and len(told) == 1:
        return next(iter(told.values()))
    raise MergeError(
        f"{path} does not say which samples {layer or 'it'} has: render with SDF Lights to OpenEXR, with metadata"
    )


def merged(paths: list[pathlib.Path]) -> list[Part]:
    """The files joined, with the parts of the first. Raises MergeError."""
    files = [read(path) for path in paths]
    told = [
        shares({str(item.name): str(item.value) for part in file for item in part.spec.extra_attribs}) for file in files
    ]
    first = files[0]
    for path, file in zip(paths[1:], files[1:]):
        if [part.spec.channelnames for part in file] != [part.spec.channelnames for part in first]:
            raise MergeError(f"{path} has other passes than {paths[0]}: render all ranges with the same settings")
        if [part.pixels.shape for part in file] != [part.pixels.shape for part in first]:
            raise MergeError(f"{path} has another size than {paths[0]}: render all ranges with the same settings")
    pixels = [np.empty_like(part.pixels) for part in first]
    for (layer, _view), passes in groups(first).items():
        found = merge(
            [
                Layer(
                    shares_of(path, of_file, layer),
                    {name: file[part].pixels[..., channels] for name, (part, channels) in passes.items()},
                )
                for path, of_file, file in zip(paths, told, files)
            ]
        )
        for name, (part, channels) in passes.items():
            pixels[part][..., channels] = found[name]
    for part, part.pixels in zip(first, pixels):
        for layer in told[0]:
            parts = joined([share for of_file in told for share in of_file.get(layer, ())])
            for key, value in joined_metadata(layer, parts).items():
                part.spec.attribute(key, value)
    return first


def write(path: pathlib.Path, parts: list[Part]) -> None:
    """Write a file, under a temporary name until it is complete. Raises MergeError."""
    if path.suffix.lower() != ".exr":  # other formats would lose passes
        raise MergeError(f"{path} is not the name of an OpenEXR file: name a file that ends with .exr")
    unfinished = path.with_name(f".{path.stem}-{os.getpid()}{path.suffix}")
    target = oiio.ImageOutput.create(str(unfinished))
    if target is None:
        raise MergeError(f"{path} cannot be written ({reason_of(oiio, 'no reason is given')}): update OpenImageIO")
    try:
        specs = tuple(part.spec for part in parts)
        done = target.open(str(unfinished), specs) if len(specs) > 1 else target.open(str(unfinished), specs[0])
        for index, part in enumerate(parts):
            if index and done:
                done = target.open(str(unfinished), part.spec, "AppendSubimage")
            done = done and target.write_image(part.pixels)
        if not (target.close() and done):
            raise MergeError(
                f"{path} cannot be written ({reason_of(target, 'no reason is given')}): check free space and "
                "permissions there"
            )
        os.replace(unfinished, path)
    except OSError as error:
        raise MergeError(f"{path} cannot be written ({error.strerror}): name a file that is not a folder") from error
    finally:
        drop(unfinished)


def denoise_combined(parts: list[Part]) -> None:
    """Denoise the pictures, guided by the denoising passes if they exist. Raises RenderError."""

    def read(place: tuple[int, list[int]] | None) -> np.ndarray | None:
        return None if place is None else parts[place[0]].pixels[..., place[1][:3]]

    for passes in groups(parts).values():
        if "Combined" in passes:
            color = read(passes.get("Noisy Image") or passes["Combined"])
            clean = denoise(color, read(passes.get("Denoising Albedo")), read(passes.get("Denoising Normal")))
            part, channels = passes["Combined"]
            parts[part].pixels[..., channels[:3]] = clean


def _of_frame(path: pathlib.Path, frame: int | None) -> pathlib.Path:
    """The path, with the number of the frame instead of ####, as in Blender."""
    if frame is None:
        return path
    return path.with_name(re.sub("#+", lambda found: str(frame).zfill(len(found[0])), path.name, count=1))


def main(arguments: list[str]) -> int:
    """Join the files named by ``arguments``; returns the exit code."""
    parser = argparse.ArgumentParser(prog="merge", description=__doc__)
    parser.add_argument("--frame", type=int, help="number that replaces #### in the names of files")
    parser.add_argument("--denoise", action="store_true", help="denoise Combined of the joined picture")
    parser.add_argument("out", type=pathlib.Path, help="the OpenEXR file to write")
    parser.add_argument("files", type=pathlib.Path, nargs="+", help="the OpenEXR files to join")
    chosen = parser.parse_args(arguments)
    out, *files = (_of_frame(path, chosen.frame) for path in (chosen.out, *chosen.files))
    try:
        parts = merged(files)
        if chosen.denoise:
            denoise_combined(parts)
        write(out, parts)
    except RenderError as error:
        print(f"merge: {error}", file=sys.stderr)
        return 1
    except MergeError as error:
        print(f"merge: {error}.", file=sys.stderr)
        return 1
    print(f"{out}: {len(files)} files joined")
    return 0
