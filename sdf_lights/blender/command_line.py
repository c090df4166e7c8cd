# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Arguments of renders without a window: ``blender -b FILE -E SDF_LIGHTS -a -- --sdf-samples 0:64 --sdf-threads 8``.

Arguments after ``--`` belong to scripts. Only words that begin with ``--sdf-``, and ``--strict``, are read here. They
apply to all final renders of this process and override the file.

``blender -c sdf_lights_merge OUT.exr IN.exr ...`` joins the files of renders that shared the samples of a frame.
``blender -c sdf_lights_job OUT.json FILE.blend`` writes a job for a render farm. ``sdf_lights_movie`` makes a movie of
the frames.
"""

from __future__ import annotations

import dataclasses
import logging
import os
import sys
from collections.abc import Sequence

import bpy

from ..render.errors import RenderError
from ..render.settings import Device, Settings
from . import movie, render_job

LOG = logging.getLogger("sdf_lights")

_PREFIX = "--sdf-"
_STRICT = "--strict"  # the same as with the prefix
LEVELS = {name.lower(): getattr(logging, name) for name in ("DEBUG", "INFO", "WARNING", "ERROR")}
_LIMITS = {item.name: item.metadata for item in dataclasses.fields(Settings)}


@dataclasses.dataclass
class Arguments:
    """The parsed command line. ``settings`` has the names of ``Settings``."""

    settings: dict = dataclasses.field(default_factory=dict)
    strict: bool = False
    log: str | None = None


def arguments(words: Sequence[str] | None = None) -> Arguments:
    """The arguments in ``words``, by default those of the process. Raises RenderError with the wrong word."""
    found = Arguments(strict=os.environ.get("SDF_LIGHTS_STRICT", "") not in ("", "0"))
    rest = iter(_own_words(sys.argv if words is None else words))
    for word in rest:
        if word == _STRICT:
            found.strict = True
        if not word.startswith(_PREFIX):
            continue
        name, equals, value = word.removeprefix(_PREFIX).partition("=")
        if name == "strict":
            found.strict = True
            continue
        if name not in _READERS:
            raise RenderError(f"There is no argument {_PREFIX}{name}: choose from {_names()}.")
        value = value if equals else next(rest, "")
        try:
            _READERS[name](found, value)
        except ValueError as error:
            raise RenderError(f"{_PREFIX}{name} {value}".rstrip() + f": {error}.") from None
    return found


def strict() -> bool:
    """Whether a render must fail if the scene is not rendered as it says: ``-- --sdf-strict`` or
    ``SDF_LIGHTS_STRICT=1``. A wrong argument fails too: nobody wants a different picture than the requested one."""
    try:
        return arguments().strict
    except RenderError:
        return True


def apply(settings: Settings) -> None:
    """Write the values of the command line into ``settings``."""
    for name, value in arguments().settings.items():
        setattr(settings, name, value)


def begin_log() -> None:
    """Write the log to the console, if the command line asks for it."""
    level = arguments().log
    if level is not None:
        write_log(level)


def write_log(level: str) -> None:
    """From now on, write messages of this level or above (``debug``, ``info``, ``warning``, ``error``) to the
    console."""
    LOG.setLevel(LEVELS[level])
    if not LOG.handlers:
        handler = logging.StreamHandler()
        handler.setFormatter(logging.Formatter("%(asctime)s %(name)s %(levelname)s: %(message)s"))
        LOG.addHandler(handler)


def _own_words(words: Sequence[str]) -> list[str]:
    return list(words[words.index("--") + 1 :]) if "--" in words else []


def _names() -> str:
    return ", ".join(_PREFIX + name for name in sorted((*_READERS, "strict")))


def _read_device(found: Arguments, value: str) -> None:
    devices = {item.value.lower(): item for item in Device}
    if value.lower() not in devices:
        raise ValueError(f"choose from {', '.join(devices)}")
    found.settings["device"] = devices[value.lower()]


def _read_threads(found: Arguments, value: str) -> None:
    found.settings["threads"] = _number("threads", value)


def _read_samples(found: Arguments, value: str) -> None:
    """``64``, or ``64:128`` for the samples 64 to 127 of a picture shared by several renders."""
    first, colon, end = value.partition(":")
    if not colon:
        found.settings["samples"] = _number("samples", first)
        return
    start, stop = _number("sample_offset", first), _number("samples", end)
    if stop <= start:
        raise ValueError("the range has no sample: write the first sample and the one after the last, such as 64:128")
    found.settings.update(sample_offset=start, samples=stop - start)


def _read_log(found: Arguments, value: str) -> None:
    if value.lower() not in LEVELS:
        raise ValueError(f"choose from {', '.join(LEVELS)}")
    found.log = value.lower()


def _number(name: str, text: str) -> int:
    least, most = _LIMITS[name]["minimum"], _LIMITS[name]["maximum"]
    if not (text.isascii() and text.isdecimal()) or not least <= int(text[:12]) <= most:
        raise ValueError(f"write a whole number from {least} to {most}")
    return int(text)


_READERS = {"device": _read_device, "threads": _read_threads, "samples": _read_samples, "log": _read_log}


def _merge(words: list[str]) -> int:
    from ..render import libraries, merge_files

    if bpy.app.binary_path:
        libraries.add_search_folder(os.path.dirname(bpy.app.binary_path))
    return merge_files.main(words)


_commands: list = []

CLASSES = ()


def register():
    runs = {"merge": _merge, "job": render_job.command, "movie": movie.command}
    for name, run in runs.items():
        _commands.append(bpy.utils.register_cli_command(f"sdf_lights_{name}", run))


def unregister():
    while _commands:
        bpy.utils.unregister_cli_command(_commands.pop())
