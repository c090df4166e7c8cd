# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The extension as users get it: installed from its zip, in Blender's Python module and in a Blender with a window."""

import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tomllib
import zipfile
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]
SESSION = pathlib.Path(__file__).with_name("zip_session.py")
PYTHON = "%d.%d" % sys.version_info[:2]

sys.path.insert(0, str(REPOSITORY / "scripts"))

import build_extension  # noqa: E402  (found on the path set above)
import host  # noqa: E402
import shipped_kernels  # noqa: E402

USER = "extensions/.user/user_default/sdf_lights/"
PRESENT = dict(engine=True, lamp=True, settings=True, enabled=True)
ABSENT = dict(engine=False, lamp=False, settings=False, enabled=False)


def older_version(path: pathlib.Path, folder: pathlib.Path) -> pathlib.Path:
    """A zip as of an older version, with a file that the new one does not have."""
    older = folder / f"older-{path.name}"
    with zipfile.ZipFile(path) as source, zipfile.ZipFile(older, "w") as target:
        for name in source.namelist():
            content = source.read(name)
            if name == "blender_manifest.toml":
                content = re.sub(rb'(?m)^version = ".*"$', b'version = "0.0.1"', content)
            target.writestr(name, content)
        target.writestr("of_old.py", "")
    return older


def run_session(
    command: list[str], zip_path: pathlib.Path, folder: pathlib.Path, compiles: bool = True
) -> tuple[dict, str]:
    """The report of ``zip_session.py``, and what Blender printed. ``compiles``: kernels are not those that other tests
    keep."""
    resources, report = folder / "resources", folder / "report.json"
    resources.mkdir()
    environment = {name: value for name, value in os.environ.items() if name != "SDF_LIGHTS_CACHE" or not compiles}
    environment["BLENDER_USER_RESOURCES"] = str(resources)
    done = subprocess.run(
        [*command, str(older_version(zip_path, folder)), str(zip_path), str(report)],
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        timeout=600,
    )
    assert report.is_file(), f"Blender ended with code {done.returncode}:\n{done.stdout}"
    seen = json.loads(report.read_text(encoding="utf-8"))
    assert "error" not in seen, seen["error"] + done.stdout
    return seen, done.stdout


def judge(seen: dict, printed: str) -> None:
    """What holds with and without the wheels."""
    assert seen["older"] == PRESENT | dict(version="0.0.1", files=["__init__.py", "of_old.py"])
    about = tomllib.loads(build_extension.MANIFEST.read_text(encoding="utf-8"))
    assert seen["installed"] == PRESENT | dict(version=about["version"], files=["__init__.py"])
    assert seen["threads"] == 3  # preferences outlive an update
    assert seen["disabled"] == ABSENT
    assert seen["enabled"] == PRESENT
    assert seen["removed"] == ABSENT
    assert seen["left"] == []
    assert "Policy violation" not in printed
    assert "Traceback" not in printed

    picture = np.array(seen["picture"]).reshape(16, 24, 4)[..., :3]
    assert np.isfinite(picture).all()
    # The lamp's ball, in the middle of the picture, outshines the floor, and the floor is lit.
    assert picture[8, 12].min() > 4.0 * picture[1, 12].max() > 0.0
    assert picture[15, 0].max() == 0.0  # the black world
    assert seen["picture again"] == seen["picture"]


def judge_wheels(seen: dict) -> None:
    assert "/extensions/.local/" in seen["modules"]["numba"]
    assert "/extensions/.local/" in seen["modules"]["llvmlite"]


def judge_kernels(seen: dict) -> None:
    # Compiled kernels are kept where the user may write, not beside the sources, which every update removes.
    assert seen["compiles"] and seen["files"]
    assert all(name.startswith(USER) for name in seen["files"])


@pytest.fixture(scope="module")
def zip_folder(tmp_path_factory):
    return tmp_path_factory.mktemp("zip")


@pytest.mark.slow  # compiles the kernels
def test_zip_installs_renders_and_goes(zip_folder, tmp_path):
    path = build_extension.build(build_extension.this_platform(), PYTHON, zip_folder)
    seen, printed = run_session([sys.executable, str(SESSION)], path, tmp_path)
    judge(seen, printed)
    judge_wheels(seen)
    judge_kernels(seen)


def test_without_numba_it_still_renders_and_says_what_is_lost(zip_folder, tmp_path):
    path = build_extension.build(build_extension.this_platform(), PYTHON, zip_folder, with_wheels=False)
    seen, printed = run_session([sys.executable, str(SESSION)], path, tmp_path)
    judge(seen, printed)
    assert seen["modules"]["numba"] is None
    assert "Numba could not be imported" in printed
    assert "slow NumPy renderer takes over" in printed


def test_two_zips_of_the_same_sources_are_the_same_bytes(zip_folder, tmp_path):
    first, second = (
        build_extension.build(build_extension.this_platform(), PYTHON, folder, with_wheels=False)
        for folder in (zip_folder, tmp_path)
    )
    assert first.read_bytes() == second.read_bytes()


@pytest.mark.slow  # compiles kernels twice
@pytest.mark.skipif(os.name == "nt", reason="links an environment")
def test_kernels_of_two_checkouts_are_the_same_bytes(tmp_path):
    """In folders of other names and lengths, each with its own path to Python, caches and temporary folder. Nothing in
    them names a folder. All kernels are made alike, so those of lamps, which are the fewest, stand for all."""
    environment = pathlib.Path(sys.executable).parents[1]

    def compiled(name: str) -> dict[pathlib.Path, pathlib.Path]:
        checkout = tmp_path / name / "checkout"
        shutil.copytree(
            REPOSITORY / "sdf_lights", checkout / "sdf_lights", ignore=shutil.ignore_patterns("__pycache__")
        )
        (checkout / environment.name).symlink_to(environment)
        python = checkout / environment.name / pathlib.Path(sys.executable).relative_to(environment)
        folders = {key: checkout.with_name(key) for key in ("TMPDIR", "XDG_CACHE_HOME", "HOME", "SDF_LIGHTS_CACHE")}
        for folder in folders.values():
            folder.mkdir()
        given = os.environ | {key: str(folder) for key, folder in folders.items()} | {"PYTHONHASHSEED": "0"}
        command = [python, "-m", shipped_kernels.PROGRAM, "lamps"]
        done = subprocess.run(command, cwd=checkout, env=given, capture_output=True, text=True, timeout=600)
        assert done.returncode == 0, done.stderr
        cache = folders["SDF_LIGHTS_CACHE"]
        return {path.relative_to(cache): path for path in cache.glob(shipped_kernels.KEPT)}

    with ThreadPoolExecutor() as pool:
        one, other = pool.map(compiled, ("one", "another folder/with a longer name"))
    assert len(one) >= 10 and one.keys() == other.keys()
    for name, path in one.items():
        code = path.read_bytes()
        assert code == other[name].read_bytes() and b"site-packages" not in code, name


@pytest.mark.gui
def test_zip_in_a_blender_with_a_window(blender_command, tmp_path):
    """The zip has all kernels, whatever Python that Blender has."""
    python = host.python_of(blender_command)
    path = build_extension.build(build_extension.this_platform(), python, tmp_path, with_kernels=True)
    command = [*blender_command, "--python", str(SESSION), "--"]
    seen, printed = run_session(command, path, tmp_path)
    assert not seen["background"] and not seen["compiles"]
    judge(seen, printed)
    judge_wheels(seen)
    written = [name for name in seen["files"] if name.startswith(USER)]
    # Formulas are those of lamps of the scene; hashes of sources hold for one installation.
    assert [name for name in written if "/formulas/" not in name and "/sources/" not in name] == []


def test_zip_holds_what_blender_needs_and_nothing_else(zip_folder):
    path = build_extension.build(build_extension.this_platform(), PYTHON, zip_folder)
    with zipfile.ZipFile(path) as archive:
        names = archive.namelist()
    top = {name.partition("/")[0] for name in names}
    assert {"__init__.py", "blender_manifest.toml", "LICENSE", "README.md", "sdf_lights", "wheels"} <= top
    assert top <= {
        "__init__.py",
        "blender_manifest.toml",
        "LICENSE",
        "README.md",
        "sdf_lights",
        "shaders_glsl",
        "wheels",
    }
    wheels = sorted(
        name.partition("/")[2].partition("-")[0]
        for name in names
        if name.startswith("wheels/") and name.endswith(".whl")
    )
    assert wheels == ["glcontext", "llvmlite", "moderngl", "numba"]
    assert [name for name in names if "__pycache__" in name or "/." in name] == []
    sources = {path.relative_to(REPOSITORY).as_posix() for path in (REPOSITORY / "sdf_lights").rglob("*.py")}
    assert {name for name in names if name.endswith(".py")} == sources | {"__init__.py"}
