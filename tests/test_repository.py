# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The manifest, the scripts' manners, and links between documents."""

import os
import pathlib
import re
import subprocess
import sys
import tomllib

import pytest

REPOSITORY = pathlib.Path(__file__).resolve().parents[1]
sys.path.insert(0, str(REPOSITORY / "scripts"))

import build_extension  # noqa: E402  (found on the path set above)
import readme_tables  # noqa: E402


def test_blenders_validator_accepts_the_manifest():
    tool, tags = build_extension.blender_tool()
    done = subprocess.run(
        [sys.executable, tool, "validate", f"--valid-tags={tags}", REPOSITORY],
        capture_output=True,
        text=True,
        timeout=60,
    )
    assert done.returncode == 0, done.stdout + done.stderr


def test_manifest_says_what_the_root_package_is():
    manifest = tomllib.loads((REPOSITORY / "blender_manifest.toml").read_text(encoding="utf-8"))
    assert manifest["id"] == "sdf_lights"
    assert manifest["license"] == ["SPDX:GPL-3.0-or-later"]
    assert set(manifest["tags"]) == {"Render", "Lighting"}
    assert manifest["blender_version_min"] == build_extension.PYTHONS["3.11"].first


@pytest.mark.parametrize("python", build_extension.PYTHONS)
def test_manifest_of_a_zip_keeps_to_the_blenders_of_its_python(python):
    wheel = pathlib.Path("numba-1.0-cp300-cp300-any.whl")
    manifest = tomllib.loads(build_extension.manifest("linux-x64", python, [wheel]))
    host = build_extension.PYTHONS[python]
    assert manifest["blender_version_min"] == host.first
    assert manifest.get("blender_version_max") == host.end
    assert manifest["wheels"] == [f"./wheels/{wheel.name}"]
    assert manifest["platforms"] == ["linux-x64"]


def test_numpy_is_never_bundled():
    assert "numpy" not in build_extension.BUNDLED.read_text(encoding="utf-8").lower().split("#")[0]
    pins = [
        line for line in build_extension.BUNDLED.read_text(encoding="utf-8").splitlines() if line and line[0] != "#"
    ]
    assert {pin.split("==")[0] for pin in pins} == {"numba", "llvmlite", "moderngl", "glcontext"}


def run(script: str, *arguments, **environment):
    return subprocess.run(
        [REPOSITORY / "scripts" / script, *arguments],
        capture_output=True,
        text=True,
        timeout=900,
        env={**os.environ, **environment},
    )


def test_a_python_that_blender_does_not_run_on_is_named():
    """/bin/false is found and starts, but is no Python."""
    done = run("environment.sh", PYTHON="/bin/false")
    assert (done.returncode, done.stdout) == (3, "")
    assert done.stderr == "$PYTHON is /bin/false, which does not start.\n"


def test_without_any_python_the_cure_is_named(tmp_path):
    for tool in ("dirname", "cat", "cksum", "echo", "sed", "sh"):
        (tmp_path / tool).symlink_to(f"/usr/bin/{tool}")
    done = run("environment.sh", PATH=str(tmp_path), PYENV_ROOT=str(tmp_path), PYTHON="")
    assert done.returncode == 3
    assert done.stderr == (
        "No suitable Python: install Python 3.13 or 3.11 (Blender runs on no other), "
        "or name one with PYTHON=/path/to/python.\n"
    )


def test_environment_is_ready_at_once_the_second_time():
    done = run("environment.sh", PYTHON=sys.executable)
    assert done.returncode == 0, done.stderr
    again = run("environment.sh", PYTHON=sys.executable)
    assert (again.stdout, again.stderr) == (done.stdout, "")


def test_scripts_are_portable_shell():
    for path in (REPOSITORY / "scripts").iterdir():
        if path.is_file() and path.read_bytes()[:2] == b"#!" and path.suffix != ".py":
            done = subprocess.run(["sh", "-n", path], capture_output=True, text=True)
            assert done.returncode == 0, done.stderr
            assert path.read_text(encoding="utf-8").startswith("#!/bin/sh\n")


def test_every_tool_has_one_version():
    """CI and every developer judge by the same tools."""
    lines = (REPOSITORY / "scripts/requirements/checks.txt").read_text(encoding="utf-8").splitlines()
    assert [line for line in lines if not line.startswith("#") and not re.fullmatch(r"[\w-]+==[\d.]+", line)] == []


def test_modules_whose_types_are_checked_exist():
    settings = tomllib.loads((REPOSITORY / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["mypy"]
    assert [name for name in settings["files"] if not (REPOSITORY / name).exists()] == []


def test_ci_needs_nothing_beside_the_checkout():
    """What the checkout lacks is installed by its own scripts."""
    text = (REPOSITORY / ".ci/run").read_text(encoding="utf-8")
    commands = [line for line in text.splitlines()[1:] if not line.lstrip().startswith("#")]
    commands.remove('cd "$(dirname "${BASH_SOURCE[0]}")/.." || exit 1')
    assert [line for line in commands if re.search(r"\.\./|cd \.\.|(?<![\w.>])/(?!dev/null)", line)] == []
    assert "bash .ci/run" in (REPOSITORY / ".github/workflows/ci.yml").read_text(encoding="utf-8")


def test_where_no_windowed_blender_can_be_installed_the_cure_is_named(tmp_path):
    for tool in ("cat", "cksum", "dirname", "sh", "id"):
        (tmp_path / tool).symlink_to(f"/usr/bin/{tool}")
    done = run("windowed_blender.sh", "blender", PATH=str(tmp_path), SDF_LIGHTS_BLENDER_ROOT=str(tmp_path / "root"))
    assert (done.returncode, done.stdout) == (3, "")
    assert "install Blender 4.5 or later" in done.stderr and "SDF_LIGHTS_BLENDER" in done.stderr
    assert not (tmp_path / "root").exists()


DOCUMENTS = sorted(
    path
    for place in (REPOSITORY, *(REPOSITORY / name for name in ("docs", "scripts", "tests", "sdf_lights")))
    for path in (place.glob("*.md") if place == REPOSITORY else place.rglob("*.md"))
    if ".pytest_cache" not in path.parts
)


@pytest.mark.parametrize("path", DOCUMENTS, ids=lambda path: path.relative_to(REPOSITORY).as_posix())
def test_links_between_documents_lead_somewhere(path):
    text = path.read_text(encoding="utf-8")
    targets = re.findall(r"\]\(([^)#\s]+)", text)
    broken = [target for target in targets if "://" not in target and not (path.parent / target).exists()]
    assert broken == []


def test_the_architecture_names_what_there_is():
    """Files, folders and kernels of docs/architecture.md exist; it stays short enough to be read at once."""
    text = (REPOSITORY / "docs/architecture.md").read_text(encoding="utf-8")
    assert len(text.splitlines()) <= 150
    roots = [
        REPOSITORY,
        *(REPOSITORY / "sdf_lights" / name for name in ("", "graph", "render", "render/kernels", "render/cpu")),
    ]
    named = set(re.findall(r"`([\w/]+(?:\.py|/))`", text))
    assert [name for name in named if not any((root / name).exists() for root in roots)] == []
    sources = "".join(path.read_text(encoding="utf-8") for path in (REPOSITORY / "sdf_lights").rglob("*.py"))
    calls = re.search(r"\| part \| calls \|\n(.*?)\n\n", text, re.DOTALL)[1]
    kernels = {name.rpartition(".")[2] for name in re.findall(r"`([a-z_.]+)`", calls) if not name.endswith(".py")}
    assert kernels and [name for name in kernels if f"def {name}(" not in sources] == []


@pytest.mark.parametrize("document", readme_tables.TABLES, ids=lambda path: path.name)
def test_tables_of_documents_are_up_to_date(document):
    """If this fails: python scripts/readme_tables.py"""
    pytest.importorskip("bpy")
    assert readme_tables.with_tables(document) == document.read_text(encoding="utf-8")
