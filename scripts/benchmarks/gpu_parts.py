# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Where a render on the GPU spends its time, part by part: what is not in dispatches leaves the card idle."""

from __future__ import annotations

import collections
import functools
import time
from collections.abc import Callable

import host

from . import pictures

# What is measured: module, class, method. The rest is Blender, and the add-on's reading of the scene.
PARTS = {
    "prepare": ("render.gpu.renderer", "GpuRenderer", "_prepare"),
    "begin": ("render.gpu.renderer", "GpuRenderer", "_begin"),
    "dispatches": ("render.gpu.renderer", "GpuRenderer", "_run"),
    "collect": ("render.gpu.renderer", "GpuRenderer", "_collect"),
    "noise": ("render.film", "Film", "noise"),
    "show_picture": ("blender.engine", "_Result", "update"),
}


def seconds(render: Callable[[], pictures.Picture]) -> dict[str, float]:
    """Seconds of each part of a render, and of the whole of it."""
    found: collections.Counter[str] = collections.Counter()
    usual = []

    def timed(name: str, method: Callable) -> Callable:
        @functools.wraps(method)
        def call(*arguments, **options):
            started = time.perf_counter()
            try:
                return method(*arguments, **options)
            finally:
                found[name] += time.perf_counter() - started

        return call

    for name, (module, owner, method) in PARTS.items():
        place = getattr(host.program(module), owner)
        usual.append((place, method, getattr(place, method)))
        setattr(place, method, timed(name, getattr(place, method)))
    try:
        whole = render().seconds
    finally:
        for place, name, method in usual:
            setattr(place, name, method)
    return {f"seconds_of_{name}": found[name] for name in PARTS} | dict(seconds_of_render=whole)
