# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The manifest, the scripts' manners, and links between documents."""

import os
import pathlib
import re
import subprocess
import sys
import tomllib
import zipfile

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


@pytest.mark.parametrize(
    ("version", "python"), [("4.5", "3.11"), ("5.0", "3.11"), ("5.0.1", "3.11"), ("5.1", "3.13"), ("5.2", "3.13")]
)
def test_the_zip_of_a_blender_is_that_of_its_python(version, python):
    assert build_extension.asked_python(None, version) == python


@pytest.mark.parametrize(("version", "said"), [("4.2", "too old"), ("new", "is not a version")])
def test_a_blender_without_a_zip_is_named(version, said):
    with pytest.raises(build_extension.BuildError, match=said):
        build_extension.asked_python(None, version)


def test_the_blender_on_the_path_is_asked(tmp_path, monkeypatch):
    command = tmp_path / "blender"
    command.write_text("#!/bin/sh\necho Blender\necho Python 3 14\n", encoding="utf-8")
    command.chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path), prepend=os.pathsep)
    assert build_extension.asked_python(None, None) == "3.14"
    assert build_extension.asked_python("3.11", None) == "3.11"
    command.write_text("#!/bin/sh\necho Python 3 9\n", encoding="utf-8")
    with pytest.raises(build_extension.BuildError, match="has Python 3.9"):
        build_extension.asked_python(None, None)


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


def test_every_wheel_of_every_zip_has_its_hash():
    pins = {line for line in build_extension.BUNDLED.read_text(encoding="utf-8").split("\n") if line and line[0] != "#"}
    systems = {"linux-x64": "x86_64", "windows-x64": "win_amd64", "macos-arm64": "arm64"}
    assert systems.keys() == build_extension.PLATFORMS.keys()
    found = []
    for line in build_extension.WHEELS.read_text(encoding="utf-8").splitlines():
        digest, name = line.split("  ")
        assert re.fullmatch("[0-9a-f]{64}", digest)
        package, version, python, _, system = name.removesuffix(".whl").split("-")
        ending = next(end for end in systems.values() if system.endswith(end))
        found.append((f"{package}=={version}", python, ending))
    wanted = {
        (pin, "cp" + python.replace(".", ""), ending)
        for pin in pins
        for python in build_extension.PYTHONS
        for ending in systems.values()
    }
    assert len(found) == len(wanted) and set(found) == wanted


def test_a_wheel_with_another_hash_is_refused(tmp_path):
    wheel = tmp_path / build_extension.WHEELS.read_text(encoding="utf-8").split()[1]
    wheel.write_bytes(b"another")
    with pytest.raises(build_extension.BuildError, match=f"{wheel.name} has the hash"):
        build_extension._check_hashes([wheel])
    assert not wheel.exists()


def test_a_zip_depends_on_nothing_but_what_is_in_it(tmp_path):
    """Not on the order of files, their dates and rights, or how they were compressed."""
    contents = {"b/two.py": b"two\n" * 99, "a.whl": bytes(range(256)), "b/one.py": b"one\n"}
    first, second = tmp_path / "first.zip", tmp_path / "second.zip"
    for path, names, year in ((first, list(contents), 2001), (second, sorted(contents), 2026)):
        with zipfile.ZipFile(path, "w") as archive:
            archive.writestr(zipfile.ZipInfo("b/", (year, 1, 1, 0, 0, 0)), b"")
            for name in names:
                entry = zipfile.ZipInfo(name, (year, 1, 1, 0, 0, 0))
                entry.external_attr = (0o100600 + year % 64) << 16
                archive.writestr(entry, contents[name], year % 2 * zipfile.ZIP_DEFLATED)
        build_extension.settle(path)
    assert first.read_bytes() == second.read_bytes()
    with zipfile.ZipFile(first) as archive:
        assert {name: archive.read(name) for name in archive.namelist()} == contents


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
    calls = re.search(r"\| part \| functions \|\n(.*?)\n\n", text, re.DOTALL)[1]
    kernels = {name.rpartition(".")[2] for name in re.findall(r"`([a-z_.]+)`", calls) if not name.endswith(".py")}
    assert kernels and [name for name in kernels if f"def {name}(" not in sources] == []


@pytest.mark.parametrize("document", readme_tables.TABLES, ids=lambda path: path.name)
def test_tables_of_documents_are_up_to_date(document):
    """If this fails: python scripts/readme_tables.py"""
    pytest.importorskip("bpy")
    assert readme_tables.with_tables(document) == document.read_text(encoding="utf-8")
