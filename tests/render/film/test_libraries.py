# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Finding Blender's libraries. Each case runs in a Python of its own, which has loaded none of them yet."""

import pathlib
import shutil
import subprocess
import sys

import pytest

from sdf_lights.render import libraries

REPOSITORY = pathlib.Path(__file__).resolve().parents[3]
LIBRARY_FOLDER = next((folder for folder in libraries.search_folders() if list(folder.glob("libembree4*"))), None)


def python(code: str, prefix: str = "") -> str:
    """Output of ``code`` in a fresh interpreter, where ``prefix`` runs first."""
    start = f"import sys; sys.path.insert(0, {str(REPOSITORY)!r})"
    script = "\n".join([start, prefix, "from sdf_lights.render import libraries", code])
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()


# Hides the bpy wheel, as in a Python that has none.
NO_BPY = """
import importlib.util
find = importlib.util.find_spec
importlib.util.find_spec = lambda name, *rest: None if name == "bpy" else find(name, *rest)"""
LOAD = """
print(libraries.load_embree()._name)
print(libraries.load_denoise()._name)
assert "bpy" not in sys.modules"""


def test_libraries_of_the_bpy_wheel_are_found_without_importing_it():
    embree, denoise = python(LOAD).splitlines()
    assert "embree4" in embree and "OpenImageDenoise" in denoise


def test_a_library_in_the_process_already_is_taken():
    """ctypes gives both objects the handle of the one copy in memory."""
    if LIBRARY_FOLDER is None or sys.platform != "linux":
        pytest.skip("needs a Linux bpy wheel")
    path = LIBRARY_FOLDER / "libembree4.so.4"
    out = python(
        "library = libraries.load_embree(); print(library._name, library._handle == first._handle)",
        f"import ctypes; first = ctypes.CDLL({str(path)!r})",
    )
    assert out == "libembree4.so.4 True"


@pytest.mark.skipif(LIBRARY_FOLDER is None or sys.platform != "linux", reason="lays out the files of Linux")
@pytest.mark.parametrize(
    "layout, registered",
    [
        ("blender/lib", "blender"),  # blender.org, Linux: beside the binary
        ("Blender.app/Contents/Resources/lib", "Blender.app/Contents/MacOS"),
        ("Blender/blender.shared", "Blender"),
        ("blender/lib", "blender/5.2/python/bin"),  # from sys.executable of Blender
    ],
)
def test_layouts_of_blender(tmp_path, layout, registered):
    """A registered folder leads to the libraries from anywhere below Blender's own folder."""
    (tmp_path / layout).mkdir(parents=True)
    (tmp_path / registered).mkdir(parents=True, exist_ok=True)
    for path in LIBRARY_FOLDER.iterdir():
        if path.suffix != ".py":
            (tmp_path / layout / path.name).symlink_to(path)
    code = f"libraries.add_search_folder({str(tmp_path / registered)!r})" + LOAD
    embree, denoise = python(code, NO_BPY).splitlines()
    assert embree == str(tmp_path / layout / "libembree4.so.4")
    assert denoise == str(tmp_path / layout / "libOpenImageDenoise.so.2")


def test_a_missing_library_is_one_sentence_with_a_cure():
    """Where the system has one of its own, that is found, which is right too."""
    code = """
from sdf_lights.render.errors import RenderError
for load in (libraries.load_embree, libraries.load_denoise):
    try:
        load()
    except RenderError as error:
        text = str(error)
        assert "was not found" in text and "install" in text and text.count(". ") == 0 and text.endswith("."), text
        print("refused")
    else:
        print("system")"""
    if shutil.which("ldconfig") is None:
        pytest.skip("no ldconfig to ask for the system's libraries")
    known = subprocess.run(["ldconfig", "-p"], capture_output=True, text=True).stdout
    expected = ["system" if name in known else "refused" for name in ("libembree4.so.4", "libOpenImageDenoise.so.2")]
    assert python(code, NO_BPY).splitlines() == expected


def test_a_library_that_does_not_load_is_passed_over(tmp_path):
    """A damaged file in the first folder searched does not hide a good one further on."""
    (tmp_path / "libembree4.so.4").write_bytes(b"not a library")
    out = python(f"libraries.add_search_folder({str(tmp_path)!r})\nprint(libraries.load_embree()._name)")
    assert "embree4" in out and str(tmp_path) not in out
