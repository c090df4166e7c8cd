# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Kernels that a zip ships: compiled from its sources, in separate processes, for the base processor.

Two runs give the same bytes: one thread compiles, in one order, with one seed of Python's hashes.
"""

from __future__ import annotations

import hashlib
import os
import pathlib
import shutil
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

REPOSITORY = pathlib.Path(__file__).resolve().parents[1]
GROUPS = ("paths", "lamps", "special")  # of ``sdf_lights.render.cpu.precompile``: one process each
KEPT = "*/*/*.kernel"


def interpreter(python: str) -> pathlib.Path | None:
    """A Python of that version with Numba and Blender's libraries: this one, or that of an environment of the
    checkout."""
    if python == "%d.%d" % sys.version_info[:2]:
        return pathlib.Path(sys.executable)
    environment = REPOSITORY / f".venv-{python}"
    found = environment / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
    return found if found.is_file() else None


def compiled(
    sources: pathlib.Path, python: pathlib.Path, groups: tuple[str, ...] = GROUPS, keep: bool = True
) -> pathlib.Path:
    """Folder with the kernels of the package in ``sources``, compiled by an interpreter. Kernels compiled before from
    the same sources are reused, unless ``keep`` is False. Raises ``subprocess.CalledProcessError``."""
    digest = hashlib.sha256(str((python.resolve(), groups)).encode())
    package = sources / "sdf_lights"
    for path in sorted(package.rglob("*.py")):
        if path.relative_to(package).parts[0] != "blender":  # nothing there is a kernel
            digest.update(path.read_bytes())
    folder = REPOSITORY / "build" / "shipped" / digest.hexdigest()[:16]
    if keep and (folder / "complete").is_file():
        return folder
    shutil.rmtree(folder, ignore_errors=True)

    def compile_group(group: str) -> None:
        subprocess.run(
            [python, "-m", "sdf_lights.render.cpu.precompile", group],
            cwd=sources,
            env=_environment(folder / group),
            check=True,
            capture_output=True,
            text=True,
        )

    with ThreadPoolExecutor(min(len(groups), os.cpu_count() or 1)) as pool:
        list(pool.map(compile_group, groups))
    for group in groups:
        for path in sorted((folder / group).glob(KEPT)):
            place = folder / path.relative_to(folder / group)
            place.parent.mkdir(parents=True, exist_ok=True)
            if not place.exists():
                path.rename(place)
        shutil.rmtree(folder / group)
    (folder / "complete").touch()
    return folder


def _environment(cache: pathlib.Path) -> dict[str, str]:
    told = {name: value for name, value in os.environ.items() if not name.startswith(("NUMBA_", "SDF_LIGHTS_"))}
    told.pop("PYTHONPATH", None)
    return told | {"SDF_LIGHTS_CACHE": str(cache), "PYTHONHASHSEED": "0", "PYTHONDONTWRITEBYTECODE": "1"}


def ship(folder: pathlib.Path, package: pathlib.Path) -> None:
    """Copy the kernels in ``folder`` to where the ``package`` looks for them."""
    for path in sorted(folder.glob(KEPT)):
        if path.parent.name == "formulas":
            continue  # of the shapes used for compilation
        place = package / "compiled" / path.relative_to(folder)
        place.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(path, place)
