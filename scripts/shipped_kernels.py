# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Kernels that a zip ships: compiled from its sources, in separate processes, for the base processor.

Two runs give the same bytes: one thread compiles, in one order, with one seed of Python's hashes.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import pathlib
import re
import shutil
import subprocess
import sys
import zipfile
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import host

from sdf_lights.render.cpu import background

REPOSITORY = pathlib.Path(__file__).resolve().parents[1]
PROGRAM = "sdf_lights.render.cpu.precompile"
GROUPS = sum(background.PROCESSES, ())  # of that program: one process each
KEPT = "*/*/*.kernel"


@dataclass(frozen=True)
class Compiler:
    """A command that starts a Python, and whether that is the one in a Blender, which has no Numba of its own."""

    command: tuple[str, ...]
    in_blender: bool = False

    def run(self, sources: pathlib.Path, libraries: pathlib.Path, group: str) -> list[str]:
        """The command that compiles one group of kernels of the package in ``sources``."""
        if not self.in_blender:
            return [*self.command, "-m", PROGRAM, group]
        paths = [str(sources), str(libraries)]
        text = f"import sys; sys.path[:0] = {paths!r}; from {PROGRAM} import main; main([{group!r}])"
        # Blender's Python ignores PYTHONHASHSEED unless it is told to use the environment.
        options = ("--background", "--factory-startup", "--python-use-system-env", "--python-exit-code", "1")
        return [*self.command, *options, "--python-expr", text]


def compiler(python: str) -> Compiler | None:
    """What compiles for a version of Python: this process's Python, that of an environment of the checkout, or that
    of the installed Blender. None if none of them has that version."""
    if python == "%d.%d" % sys.version_info[:2]:
        return Compiler((sys.executable,))
    environment = REPOSITORY / f".venv-{python}"
    found = environment / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
    if found.is_file():
        return Compiler((str(found),))
    blender = host.blender_command()
    if blender is not None:
        with contextlib.suppress(RuntimeError):
            if host.python_of(blender) == python:
                return Compiler(tuple(blender), in_blender=True)
    return None


def compiled(
    sources: pathlib.Path, compiler: Compiler, groups: tuple[str, ...] = GROUPS, keep: bool = True
) -> pathlib.Path:
    """Folder with the kernels of the package in ``sources``, which has the zip's ``wheels``. Kernels compiled before
    from the same sources and wheels are reused, unless ``keep`` is False. Raises ``subprocess.CalledProcessError``."""
    wheels = sorted((sources / "wheels").glob("*.whl"))
    digest = hashlib.sha256(str((compiler, groups, [wheel.name for wheel in wheels])).encode())
    package = sources / "sdf_lights"
    for path in sorted(package.rglob("*.py")):
        if path.relative_to(package).parts[0] != "blender":  # nothing there is a kernel
            digest.update(path.read_bytes())
    folder = REPOSITORY / "build" / "shipped" / digest.hexdigest()[:16]
    if keep and (folder / "complete").is_file():
        return folder
    shutil.rmtree(folder, ignore_errors=True)
    libraries = folder / "libraries"
    if compiler.in_blender:
        for wheel in wheels:
            with zipfile.ZipFile(wheel) as archive:
                archive.extractall(libraries)

    def compile_group(group: str) -> None:
        done = subprocess.run(
            compiler.run(sources, libraries, group),
            cwd=sources,
            env=_environment(folder / group),
            check=True,
            capture_output=True,
            text=True,
        )
        host_hash = re.findall(r"^for (\w+)$", done.stdout, re.MULTILINE)[-1]
        (folder / background.shipped_mark(group, host_hash)).touch()

    with ThreadPoolExecutor(min(len(groups), os.cpu_count() or 1)) as pool:
        list(pool.map(compile_group, groups))
    for group in groups:
        for path in sorted((folder / group).glob(KEPT)):
            place = folder / path.relative_to(folder / group)
            place.parent.mkdir(parents=True, exist_ok=True)
            if not place.exists():
                path.rename(place)
        shutil.rmtree(folder / group)
    shutil.rmtree(libraries, ignore_errors=True)
    (folder / "complete").touch()
    return folder


def _environment(cache: pathlib.Path) -> dict[str, str]:
    told = {
        name: value
        for name, value in os.environ.items()
        if not name.startswith(("NUMBA_", "SDF_LIGHTS_", "PYTHONPATH")) or name.startswith("SDF_LIGHTS_BLENDER")
    }
    return told | {"SDF_LIGHTS_CACHE": str(cache), "PYTHONHASHSEED": "0", "PYTHONDONTWRITEBYTECODE": "1"}


def ship(folder: pathlib.Path, package: pathlib.Path) -> None:
    """Copy the kernels in ``folder`` to where the ``package`` looks for them."""
    for path in sorted(folder.glob(KEPT)):
        if path.parent.name == "formulas":
            continue  # of the shapes used for compilation
        place = package / "compiled" / path.relative_to(folder)
        place.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(path, place)
    for path in folder.glob(background.shipped_mark("*", "*")):
        shutil.copyfile(path, package / "compiled" / path.name)
