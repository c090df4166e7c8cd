# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Builds the extension's zips, each with the wheels of one platform and one Python, and validates them with Blender's
own validator.

Blender extracts every wheel of a zip that its platform and Python accept. So a zip has one Python's wheels and names
the Blender versions with that Python. Two builds of the same sources give the same bytes.
"""

from __future__ import annotations

import argparse
import hashlib
import importlib.util
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import tomllib
import zipfile
from dataclasses import dataclass

import host
import shipped_kernels
from packaging.requirements import Requirement

REPOSITORY = pathlib.Path(__file__).resolve().parents[1]
MANIFEST = REPOSITORY / "blender_manifest.toml"
BUNDLED = REPOSITORY / "scripts" / "requirements" / "bundled.txt"
WHEELS = REPOSITORY / "scripts" / "requirements" / "wheels.sha256"  # as sha256sum writes it
CONTENTS = ("__init__.py", "LICENSE", "README.md", "sdf_lights", "shaders_glsl")

# Tags that pip accepts for each of Blender's platforms, newest first.
PLATFORMS = {
    "linux-x64": ("manylinux_2_28_x86_64", "manylinux_2_27_x86_64", "manylinux_2_17_x86_64", "manylinux2014_x86_64"),
    "windows-x64": ("win_amd64",),
    "macos-arm64": tuple(f"macosx_{version}_0_arm64" for version in (14, 13, 12, 11)),
}


@dataclass(frozen=True)
class Blenders:
    """The Blender versions with one Python: the first, the first without it, and their NumPy."""

    first: str
    end: str | None
    numpy: tuple[str, ...]


# 3.14 is not in Blender's own builds: some Linux distributions build Blender with their Python.
PYTHONS = {
    "3.11": Blenders("4.5.0", "5.1.0", ("1.26.4",)),
    "3.13": Blenders("5.1.0", None, ("2.2.0", "2.5.5")),
    "3.14": Blenders("5.1.0", None, ("2.2.0", "2.5.5")),
}


class BuildError(Exception):
    """One sentence for the user."""


def blender_tool() -> tuple[pathlib.Path, pathlib.Path]:
    """Blender's extension builder, which runs without Blender, and its list of tags, from the installed bpy."""
    spec = importlib.util.find_spec("bpy")
    if spec is None:
        raise BuildError("Blender's Python module is missing: run scripts/build_extension, which installs it.")
    for scripts in pathlib.Path(spec.origin).parent.glob("*/scripts"):
        return (
            scripts / "addons_core" / "bl_pkg" / "cli" / "blender_ext.py",
            scripts / "modules" / "_bpy_internal" / "extensions" / "tags.py",
        )
    raise BuildError("Blender's Python module has no extension builder: it is older than 4.5.")


def _run(command: list, purpose: str) -> None:
    done = subprocess.run([str(part) for part in command], capture_output=True, text=True)
    if done.returncode:
        raise BuildError(f"{purpose} failed:\n{done.stdout}{done.stderr}".rstrip())


def collect_wheels(platform: str, python: str) -> list[pathlib.Path]:
    """The bundled wheels, from pip; kept in ``build/wheels`` for the next build."""
    folder = REPOSITORY / "build" / "wheels" / f"{platform}-python{python}"
    pins = [line.strip() for line in BUNDLED.read_text(encoding="utf-8").splitlines() if line and line[0] != "#"]

    def present() -> list[pathlib.Path]:
        return [
            wheel
            for name, version in (pin.split("==") for pin in pins)
            for wheel in folder.glob(f"{name}-{version}-*.whl")
        ]

    if len(present()) != len(pins):
        shutil.rmtree(folder, ignore_errors=True)
        tags = [part for tag in PLATFORMS[platform] for part in ("--platform", tag)]
        _run(
            [
                sys.executable,
                "-m",
                "pip",
                "download",
                "--quiet",
                "--no-deps",
                "--only-binary=:all:",
                "--implementation",
                "cp",
                "--python-version",
                python,
                *tags,
                "--dest",
                folder,
                "-r",
                BUNDLED,
            ],
            f"Downloading the wheels for {platform} and Python {python}",
        )
    wheels = present()
    if len(wheels) != len(pins):
        raise BuildError(f"pip found {len(wheels)} of {len(pins)} wheels for {platform} and Python {python}.")
    _check_hashes(wheels)
    _check_numpy(wheels, python)
    return wheels


def _check_hashes(wheels: list[pathlib.Path]) -> None:
    """Every wheel must be the one that was checked when its version was chosen."""
    lines = [line.split() for line in WHEELS.read_text(encoding="utf-8").splitlines() if line]
    pinned = {name: digest for digest, name in lines}
    for wheel in wheels:
        found = hashlib.sha256(wheel.read_bytes()).hexdigest()
        if pinned.get(wheel.name) != found:
            wheel.unlink()
            raise BuildError(f"{wheel.name} has the hash {found}, which is not the one in {WHEELS.name}.")


def _check_numpy(wheels: list[pathlib.Path], python: str) -> None:
    """NumPy is Blender's: every wheel must accept Blender's versions."""
    for wheel in wheels:
        with zipfile.ZipFile(wheel) as archive:
            metadata = next(name for name in archive.namelist() if name.endswith(".dist-info/METADATA"))
            lines = archive.read(metadata).decode().splitlines()
        for line in lines:
            if not line.startswith("Requires-Dist: numpy"):
                continue
            requirement = Requirement(line.partition(": ")[2])
            refused = [version for version in PYTHONS[python].numpy if not requirement.specifier.contains(version)]
            if refused:
                raise BuildError(
                    f"{wheel.name} needs {requirement}, but Blender with Python {python} has NumPy {refused[0]}."
                )


def manifest(platform: str, python: str, wheels: list[pathlib.Path]) -> str:
    """The manifest of one zip: the repository's, with wheels, platform and range of Blender versions."""
    blenders = PYTHONS[python]
    lines = [f'blender_version_min = "{blenders.first}"']
    if blenders.end:
        lines.append(f'blender_version_max = "{blenders.end}"')
    if wheels:
        lines.append(f'platforms = ["{platform}"]')
        lines += ["wheels = [", *(f'  "./wheels/{wheel.name}",' for wheel in wheels), "]"]
    text = MANIFEST.read_text(encoding="utf-8")
    return re.sub(r"^blender_version_min = .*$", "\n".join(lines), text, count=1, flags=re.MULTILINE)


def _add_kernels(stage: pathlib.Path, platform: str, python: str) -> bool:
    """Compile the kernels for the zip, if this machine can. Raises BuildError."""
    if platform != this_platform():
        return False
    compiler = shipped_kernels.compiler(python)
    if compiler is None:
        return False
    try:
        shipped_kernels.ship(shipped_kernels.compiled(stage, compiler), stage / "sdf_lights")
    except subprocess.CalledProcessError as error:
        raise BuildError(f"Compiling the kernels failed:\n{error.stderr}".rstrip()) from error
    return True


def settle(path: pathlib.Path) -> None:
    """Write a zip again so that its bytes depend only on its content: names in order, one date, the same
    permissions."""
    settled = path.with_suffix(".part")
    with zipfile.ZipFile(path) as source, zipfile.ZipFile(settled, "w") as target:
        for item in sorted(source.infolist(), key=lambda item: item.filename):
            if item.is_dir():
                continue
            entry = zipfile.ZipInfo(item.filename, (1980, 1, 1, 0, 0, 0))
            entry.create_system, entry.external_attr = 3, 0o100644 << 16
            entry.compress_type = zipfile.ZIP_STORED if item.filename.endswith(".whl") else zipfile.ZIP_DEFLATED
            target.writestr(entry, source.read(item), compresslevel=9)
    settled.replace(path)


def build(
    platform: str, python: str, out: pathlib.Path, with_wheels: bool = True, with_kernels: bool = False
) -> pathlib.Path:
    """Build and validate one zip; returns its path. Kernels are compiled if this machine can. Raises BuildError."""
    wheels = collect_wheels(platform, python) if with_wheels else []
    about = tomllib.loads(MANIFEST.read_text(encoding="utf-8"))
    name = f"{about['id']}-{about['version']}-{platform}-python{python}" + ("" if with_wheels else "-no_wheels")
    out.mkdir(parents=True, exist_ok=True)
    path = out.resolve() / f"{name}.zip"
    stages = REPOSITORY / "build" / "extension"
    stages.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=stages) as folder:  # one for each build: several may run at once
        stage = pathlib.Path(folder) / about["id"]
        stage.mkdir()
        for entry in CONTENTS:
            source = REPOSITORY / entry
            if source.is_dir():
                shutil.copytree(source, stage / entry, ignore=shutil.ignore_patterns("__pycache__", "*.pyc", ".*"))
            elif source.is_file():
                shutil.copy2(source, stage / entry)
        for wheel in wheels:
            (stage / "wheels").mkdir(exist_ok=True)
            shutil.copy2(wheel, stage / "wheels" / wheel.name)
        if with_kernels and with_wheels and not _add_kernels(stage, platform, python):
            print(
                f"{name}: without compiled kernels, which only {platform} with Python {python} and Numba, or with a "
                f"Blender that has Python {python}, can make",
                file=sys.stderr,
            )
        (stage / "blender_manifest.toml").write_text(manifest(platform, python, wheels), encoding="utf-8")

        tool, tags = blender_tool()
        _run(
            [sys.executable, tool, "build", "--source-dir", stage, "--output-filepath", path, f"--valid-tags={tags}"],
            f"Building {path.name}",
        )
    settle(path)
    _run([sys.executable, tool, "validate", f"--valid-tags={tags}", path], f"Validating {path.name}")
    return path


def sizes(path: pathlib.Path) -> list[str]:
    """Sizes in a zip, line by line: each wheel, the compiled kernels, everything else."""
    found: dict[str, int] = {}
    with zipfile.ZipFile(path) as archive:
        for item in archive.infolist():
            name = "sources"
            if item.filename.endswith(".whl"):
                name = item.filename.rpartition("/")[2]
            elif item.filename.startswith("sdf_lights/compiled/"):
                name = "compiled kernels"
            found[name] = found.get(name, 0) + item.compress_size
    return [f"{size / 1e6:6.1f} MB  {name}" for name, size in found.items()]


def this_platform() -> str:
    """The platform of this machine, or "" if Blender has none of the three."""
    import platform

    machine = {"amd64": "x64", "x86_64": "x64", "arm64": "arm64", "aarch64": "arm64"}.get(
        platform.machine().lower(), ""
    )
    name = f"{ {'Darwin': 'macos'}.get(platform.system(), platform.system().lower()) }-{machine}"
    return name if name in PLATFORMS else ""


def python_for(version: str) -> str:
    """The Python in Blender's own builds of a version such as 5.2. Raises BuildError."""
    match = re.fullmatch(r"(\d+)\.(\d+)(?:\.\d+)?", version)
    if match is None:
        raise BuildError(f"{version!r} is not a version of Blender, such as 5.2.")
    asked = int(match[1]), int(match[2]), 0
    for python, blenders in PYTHONS.items():
        first, end = (tuple(map(int, text.split("."))) if text else None for text in (blenders.first, blenders.end))
        if first <= asked and (end is None or asked < end):
            return python
    first = PYTHONS["3.11"].first
    raise BuildError(f"Blender {version} is too old: the extension needs Blender {first} or later.")


def asked_python(python: str | None, blender: str | None) -> str:
    """The Python to build for: the given one, that of a version of Blender, of the Blender on the path, or of this
    process."""
    if python is not None:
        return python
    if blender is not None:
        return python_for(blender)
    command = host.blender_command()
    if command is None:
        return "%d.%d" % sys.version_info[:2]
    try:
        found = host.python_of(command)
    except RuntimeError as error:
        raise BuildError(f"{error}\nSay which Blender with --blender 5.2.") from error
    if found not in PYTHONS:
        raise BuildError(f"{command[-1]} has Python {found}, for which there are no wheels: choose one with --python.")
    return found


def main(arguments: list[str]) -> int:
    here = this_platform()
    parser = argparse.ArgumentParser(
        prog="build_extension", description="Build the extension's zips, with their wheels."
    )
    parser.add_argument(
        "--platform",
        choices=[*PLATFORMS, "all"],
        default=here or None,
        required=not here,
        help="what the wheels are for (default: this machine)",
    )
    parser.add_argument(
        "--python",
        choices=[*PYTHONS, "all"],
        help="Python of the Blender to install in: 3.11 up to Blender 5.0, 3.13 from 5.1; "
        "3.14 for a Blender that a Linux distribution built",
    )
    parser.add_argument(
        "--blender",
        metavar="VERSION",
        help="Blender to install in, such as 5.2 (default: the one on the path, else the one of the Python that is found)",
    )
    parser.add_argument(
        "--out", type=pathlib.Path, default=REPOSITORY / "dist", help="folder for the zips (default: dist)"
    )
    parser.add_argument(
        "--no-wheels", action="store_true", help="leave the wheels out: small, but renders slowly, with NumPy"
    )
    parser.add_argument(
        "--no-kernels",
        action="store_true",
        help="leave compiled kernels out: the first render of an installation then compiles them for a minute",
    )
    options = parser.parse_args(arguments)
    platforms = list(PLATFORMS) if options.platform == "all" else [options.platform]
    try:
        pythons = list(PYTHONS) if options.python == "all" else [asked_python(options.python, options.blender)]
        for version in pythons:
            for platform in platforms:
                path = build(platform, version, options.out, not options.no_wheels, not options.no_kernels)
                print(f"{path}  {path.stat().st_size / 1e6:.1f} MB")
                for line in sizes(path):
                    print(f"  {line}")
    except BuildError as error:
        print(f"build_extension: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
