# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender, with this checkout loaded into it like an extension."""

from __future__ import annotations

import contextlib
import importlib
import importlib.util
import os
import pathlib
import re
import shlex
import shutil
import subprocess
import sys

REPOSITORY = pathlib.Path(__file__).resolve().parents[1]
# The layers below the add-on, and the cases shared by tests, by their own names.
sys.path.insert(0, str(REPOSITORY))

PACKAGE = "sdf_lights_checkout"
ENGINE = "SDF_LIGHTS"


NO_WINDOW = "no Blender with a window: put blender on the path, or set SDF_LIGHTS_BLENDER to its command"


@contextlib.contextmanager
def checkout_of(revision: str, folder: pathlib.Path):
    """A checkout of another revision of this repository in a new ``folder``, for as long as the context lasts."""
    git = ["git", "-C", REPOSITORY, "worktree"]
    subprocess.run([*git, "add", "--quiet", "--detach", folder, revision], check=True)
    try:
        yield folder
    finally:
        subprocess.run([*git, "remove", "--force", folder], check=True)


def blender_command() -> list[str] | None:
    """Command that starts the installed Blender; arguments follow it. None if there is none.

    ``SDF_LIGHTS_BLENDER`` is that command, with any prefix (``"xvfb-run -a blender"``); without it, the ``blender`` on
    the path.
    """
    found = shutil.which("blender")
    return shlex.split(os.environ.get("SDF_LIGHTS_BLENDER", "")) or ([found] if found else None)


def windowed_blender() -> list[str] | None:
    """Command that opens the installed Blender with a window, if need be on a virtual screen. None if there is no
    Blender."""
    command = blender_command()
    without_screen = sys.platform == "linux" and not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))
    if command and without_screen and "SDF_LIGHTS_BLENDER" not in os.environ:
        return ["xvfb-run", "-a", *command]
    return command


def python_of(command: list[str]) -> str:
    """Version of the Python in the Blender that ``command`` starts, such as "3.13". Raises RuntimeError, with a
    sentence, if it does not start."""
    ask = "import sys; print('Python', *sys.version_info[:2])"
    try:
        told = subprocess.run(
            [*command, "--background", "--factory-startup", "--python-expr", ask],
            capture_output=True,
            text=True,
            timeout=120,
        )
    except (OSError, subprocess.TimeoutExpired) as error:
        raise RuntimeError(f"{shlex.join(command)} does not start: {error}.") from error
    found = re.search(r"^Python (\d+) (\d+)$", told.stdout, re.MULTILINE)
    if found is None:
        raise RuntimeError(f"{shlex.join(command)} does not say which Python it has:\n{told.stdout}{told.stderr}")
    return f"{found[1]}.{found[2]}"


def register_extension():
    """Register the add-on in this checkout and return its root package.

    Blender calls an extension's package ``bl_ext.<repository>.<id>``. Here the folder of the checkout, with any name,
    is one package too, so that all its imports stay relative to it.
    """
    if PACKAGE in sys.modules:
        sys.modules[PACKAGE].register()
        return sys.modules[PACKAGE]
    os.environ.setdefault("SDF_LIGHTS_CACHE", str(REPOSITORY / "build" / "kernels"))
    spec = importlib.util.spec_from_file_location(
        PACKAGE, REPOSITORY / "__init__.py", submodule_search_locations=[str(REPOSITORY)]
    )
    package = importlib.util.module_from_spec(spec)
    sys.modules[PACKAGE] = package
    spec.loader.exec_module(package)
    package.register()
    return package


def program(module: str = ""):
    """A module of the registered copy of the program, by its name below ``sdf_lights``.

    A process may contain several copies, for instance a test's own; the first to register renders.
    """
    import bpy

    package = type(bpy.context.scene.sdf_lights).__module__.partition(".blender.")[0]
    return importlib.import_module(f"{package}.{module}" if module else package)


def unregister_extension() -> None:
    package = sys.modules.pop(PACKAGE, None)
    if package is not None:
        package.unregister()


def set_lamp(light, shape: str, **parameters) -> None:
    """Make a Light datablock an SDF lamp: ``shape`` is a primitive's name with its parameters, or an expression."""
    lamp = light.sdf_lamp
    lamp.use = True
    if "(" in shape:
        lamp.source, lamp.expression = "EXPRESSION", shape
        return
    lamp.source, lamp.shape = "PRIMITIVE", shape.upper()
    for name, value in parameters.items():
        setattr(getattr(lamp, shape), name, value)


def finish(code: int) -> None:
    """Leave the process with an exit code.

    Python's own exit runs the destructors of Blender's module, which report leaked memory, and can hang.
    """
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(code)
