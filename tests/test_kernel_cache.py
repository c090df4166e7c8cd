# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Compiled kernels on disk survive whatever happens to their files."""

import dataclasses
import os
import pathlib
import random
import shutil
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor

import pytest

from sdf_lights import jit, kernel_cache, kernel_entries
from sdf_lights.kernel_cache import MAGIC, Files
from sdf_lights.render import session
from support.scenes import cove

REPOSITORY = pathlib.Path(__file__).resolve().parents[1]
KEY = ("(float64) -> float64", "x86", "")


@pytest.fixture
def files(tmp_path, monkeypatch):
    monkeypatch.setattr(kernel_cache, "_problems", [])
    monkeypatch.setattr(kernel_cache, "_refused", [])
    return Files(tmp_path / "0123456789abcdef" / "module", "kernel-1.py313")


def test_what_is_saved_is_loaded(files):
    assert files.load(KEY) is None
    files.save(KEY, ("code", 1))
    files.save("another", ("code", 2))
    assert files.load(KEY) == ("code", 1)
    files.save(KEY, ("code", 3))
    assert files.load(KEY) == ("code", 3) and files.load("another") == ("code", 2)
    files.flush()
    assert files.load(KEY) is None and files.load("another") is None


def flipped(content: bytes, place: int) -> bytes:
    return content[:place] + bytes([content[place] ^ 0x10]) + content[place + 1 :]


DAMAGES = {
    "empty": lambda content: b"",
    "truncated": lambda content: content[: len(content) // 2],
    "cut in its checksum": lambda content: content[: len(MAGIC) + 5],
    "zeroed": lambda content: bytes(len(content)),
    "garbled": lambda content: bytes((7 * index) % 256 for index in range(len(content))),
    "a bit of the code": lambda content: flipped(content, len(content) - 3),
    "a bit of the checksum": lambda content: flipped(content, len(MAGIC) + 3),
    "longer": lambda content: content + b"more",
}


@pytest.mark.parametrize("damage", DAMAGES.values(), ids=DAMAGES)
def test_a_damaged_file_is_dropped(files, damage):
    files.save(KEY, list(range(100)))
    path = files.path(KEY)
    path.write_bytes(damage(path.read_bytes()))
    assert files.load(KEY) is None
    assert not path.exists()
    assert str(path.parent) in kernel_cache.refused() and kernel_cache.refused() == ""
    files.save(KEY, "again")
    assert files.load(KEY) == "again"


@pytest.mark.skipif(not jit.AVAILABLE, reason="Numba is not installed")
def test_a_render_says_once_that_files_were_damaged(files):
    for key in ("first", "second"):
        files.save(key, "code")
        files.path(key).write_bytes(MAGIC)
        assert files.load(key) is None
    told = []
    for _ in range(2):
        scene = cove(8, 6)
        scene.settings = dataclasses.replace(scene.settings, samples=1)
        session.render(scene, ())
        told.append(scene.warnings)
    sentence = f"2 damaged or foreign files of compiled kernels in '{files.path(KEY).parent}' were not used"
    assert [sentence in text for text in told[0]] == [True]
    assert told[1] == []


@pytest.mark.skipif(not hasattr(os, "getuid"), reason="rights of files are by the folder here")
def test_a_file_that_others_can_write_is_dropped(files):
    for mode in (0o666, 0o620):
        files.save(KEY, "mine")
        os.chmod(files.path(KEY), mode)
        assert files.load(KEY) is None and not files.path(KEY).exists()


@pytest.mark.skipif(not hasattr(os, "getuid") or os.getuid() != 0, reason="only root can give files away")
def test_a_file_of_another_user_is_dropped(files):
    files.save(KEY, "mine")
    os.chown(files.path(KEY), 12345, -1)
    assert files.load(KEY) is None and not files.path(KEY).exists()


def test_a_folder_that_cannot_be_made_is_told_of(tmp_path, monkeypatch):
    monkeypatch.setattr(kernel_cache, "_problems", [])
    (tmp_path / "file").write_text("no folder")
    found = Files(tmp_path / "file" / "module", "kernel")
    found.save(KEY, "data")
    assert found.load(KEY) is None
    assert str(tmp_path / "file") in kernel_cache.problem() and "SDF_LIGHTS_CACHE" in kernel_cache.problem()


def test_old_versions_go_by_age_and_by_size(tmp_path):
    now, day = 2_000_000_000.0, 86_400.0
    for name, age in (("used", 0.5), ("week", 7.0), ("month", 30.0), ("old", 100.0)):
        (tmp_path / name / "module").mkdir(parents=True)
        (tmp_path / name / "module" / "a.kernel").write_bytes(bytes(1000))
        os.utime(tmp_path / name, (now - age * day, now - age * day))
    kernel_cache.tidy(tmp_path, now)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["month", "used", "week"]
    kernel_cache.tidy(tmp_path, now, most=2000)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["used", "week"]
    kernel_cache.tidy(tmp_path, now, most=0)
    assert [path.name for path in tmp_path.iterdir()] == ["used"]


# Prints what two kernels give, and whether their code could be kept.
PROGRAM = """
import sys
sys.path.insert(0, {root!r})
{before}
from sdf_lights import jit, kernel_cache
from sdf_lights.render.kernels.samplers import get_1d, pixel_seed
print(get_1d(3, pixel_seed(1, 2, 3), 4), pixel_seed(1, 2, 3), bool(kernel_cache.problem()))
"""


def drawn(cache: pathlib.Path, before: str = "") -> list[str]:
    environment = {**os.environ, "SDF_LIGHTS_CACHE": str(cache)}
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM.format(root=str(REPOSITORY), before=before)],
        env=environment,
        capture_output=True,
        text=True,
        timeout=300,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout.split()


def test_what_another_copy_has_compiled_is_the_same_bytes_and_is_shipped(tmp_path):
    """Whatever the folder and the name of the package, and with a cache of its own that is empty."""
    renamed = tmp_path / "elsewhere" / "renamed"
    shutil.copytree(REPOSITORY / "sdf_lights", renamed, ignore=shutil.ignore_patterns("__pycache__", "blender"))
    code = (
        "from {0}.emitter.primitives.box import box_span; from {0} import jit; "
        "print(*box_span((0.0, 0.0, -3.0), (0.0, 0.0, 1.0), 1.0, 1.0, 0.5), jit.compiled_kernels())"
    )

    def run(folder, package: str, cache: pathlib.Path) -> list[str]:
        environment = {**os.environ, "PYTHONPATH": str(folder), "PYTHONHASHSEED": "0", "SDF_LIGHTS_CACHE": str(cache)}
        command = [sys.executable, "-c", code.format(package)]
        return subprocess.run(command, env=environment, capture_output=True, text=True, check=True).stdout.split()

    def kept(cache: pathlib.Path) -> dict[pathlib.Path, bytes]:
        """Code: without what is known about sources."""
        return {path.relative_to(cache): path.read_bytes() for path in cache.glob("*/*/*.kernel")}

    caches = [tmp_path / name for name in ("first", "second", "third")]
    *span, compiled = run(REPOSITORY, "sdf_lights", caches[0])
    assert span == ["2.5", "3.5"] and int(compiled) > 0
    assert run(REPOSITORY, "sdf_lights", caches[1]) == [*span, compiled]
    assert kept(caches[0]) == kept(caches[1]) != {}
    shutil.copytree(caches[0], renamed / "compiled")
    assert run(renamed.parent, "renamed", caches[2]) == [*span, "0"]
    assert kept(caches[2]) == {}


def test_only_what_a_new_version_has_changed_is_compiled_again(tmp_path):
    """Of two kernels in two modules, after changes of neither, of one, and of the other."""
    sources, cache = tmp_path / "sources", tmp_path / "cache"
    shutil.copytree(REPOSITORY / "sdf_lights", sources / "sdf_lights", ignore=shutil.ignore_patterns("__pycache__"))
    code = (
        "from sdf_lights.emitter.hashing import seeded; from sdf_lights.emitter.primitives.box import box_span; "
        "seeded(0.25, 0.5, 0.75); box_span((0.0, 0.0, -3.0), (0.0, 0.0, 1.0), 1.0, 1.0, 0.5)"
    )

    def compiled() -> list[bool]:
        """Whether either has new code in the cache."""
        before = set(cache.glob("*/*/*.kernel"))
        environment = {**os.environ, "PYTHONPATH": str(sources), "SDF_LIGHTS_CACHE": str(cache)}
        subprocess.run([sys.executable, "-c", code], env=environment, cwd=tmp_path, check=True)
        found = {path.name.partition("-")[0] for path in set(cache.glob("*/*/*.kernel")) - before}
        return [any(name in word for word in found) for name in ("seeded", "box_span")]

    def change(name: str) -> None:
        path = sources / "sdf_lights" / name
        path.write_text(path.read_text(encoding="utf-8") + "\nCHANGED = 1\n", encoding="utf-8")

    assert compiled() == [True, True] and compiled() == [False, False]
    change("emitter/primitives/torus.py")
    assert compiled() == [False, False]
    change("emitter/primitives/box.py")
    assert compiled() == [False, True]
    change("emitter/hashing.py")
    assert compiled()[0] and compiled() == [False, False]


def test_kernels_of_damaged_files_are_compiled_again(tmp_path):
    first = drawn(tmp_path)
    kept = sorted(tmp_path.rglob("*.kernel"))
    assert len(kept) >= 2 and first[-1] == "False"
    for path, damage in zip(kept, [DAMAGES["a bit of the code"], DAMAGES["truncated"]] * len(kept)):
        path.write_bytes(damage(path.read_bytes()))
    damaged = {path: path.read_bytes() for path in kept}
    assert drawn(tmp_path) == first
    assert all(path.is_file() and path.read_bytes() != damaged[path] for path in kept)
    assert not list(tmp_path.rglob("*.part"))


@pytest.mark.skipif(sys.platform == "win32", reason="there is no limit of file sizes")
def test_a_full_disk_costs_time_alone(tmp_path):
    first = drawn(tmp_path / "free")
    limit = (
        "import resource, signal; signal.signal(signal.SIGXFSZ, signal.SIG_IGN); "
        "resource.setrlimit(resource.RLIMIT_FSIZE, (100, 100))"
    )
    assert drawn(tmp_path / "full", limit) == [*first[:-1], "True"]


@pytest.mark.slow
def test_four_processes_share_a_folder(tmp_path):
    with ThreadPoolExecutor(4) as pool:
        found = list(pool.map(lambda _: drawn(tmp_path), range(4)))
    assert found[0][-1] == "False" and all(each == found[0] for each in found)
    assert not list(tmp_path.rglob("*.part"))


def test_processes_that_are_killed_while_they_compile_leave_nothing_that_is_wrong(tmp_path):
    """Four at once, of which each is killed at some moment; at last one is left alone."""
    moments = random.Random(3)
    program = PROGRAM.format(root=str(REPOSITORY), before="")
    environment = {**os.environ, "SDF_LIGHTS_CACHE": str(tmp_path / "killed")}
    expected = drawn(tmp_path / "whole")
    for _ in range(2):
        running = [
            subprocess.Popen([sys.executable, "-c", program], env=environment, stdout=subprocess.DEVNULL)
            for _ in range(4)
        ]
        for process in running:
            time.sleep(moments.uniform(0.2, 1.2))
            process.kill()
        for process in running:
            process.wait()
        for path in (tmp_path / "killed").rglob("*.kernel"):
            assert kernel_cache._verified(path) is not None
    assert drawn(tmp_path / "killed") == expected


def test_what_a_killed_process_left_unfinished_goes(tmp_path):
    now = time.time()
    (tmp_path / "version" / "module").mkdir(parents=True)
    old, new = (tmp_path / "version" / "module" / name for name in ("old.part", "new.part"))
    for path, age in ((old, 7200.0), (new, 10.0)):
        path.write_bytes(b"half")
        os.utime(path, (now - age, now - age))
    kernel_cache.tidy(tmp_path, now)
    assert new.exists() and not old.exists()


@pytest.fixture
def small_disk(tmp_path):
    """A file system of its own with 64 KB."""
    folder = tmp_path / "disk"
    folder.mkdir()
    mounted = subprocess.run(["mount", "-t", "tmpfs", "-o", "size=64k", "tmpfs", folder], capture_output=True)
    if mounted.returncode:
        pytest.skip("only root can mount a small disk")
    yield folder
    subprocess.run(["umount", folder], check=True)


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="disks are mounted otherwise")
def test_a_disk_that_is_full_costs_time_alone(tmp_path, small_disk):
    """Unlike files with a limit, a full disk lets files begin."""
    (small_disk / "other").write_bytes(bytes(60 << 10))
    assert drawn(small_disk) == [*drawn(tmp_path / "free")[:-1], "True"]
    assert not list(small_disk.rglob("*.part"))


def test_a_folder_with_a_limit_loses_what_was_used_least_recently(tmp_path):
    files = Files(tmp_path, "formulas", 10**9)
    for number in range(4):
        files.save(number, bytes(1000))
        os.utime(files.path(number), (number, number))
    files.load(0)  # is used now
    kernel_cache.trim(tmp_path, 2500)
    assert [files.path(number).exists() for number in range(4)] == [True, False, False, True]


def test_versions_of_python_share_what_c_calls(tmp_path, monkeypatch):
    """Another one finds the machine code for C, and compiles what Python calls by itself."""
    monkeypatch.setattr(kernel_cache, "writable_folder", lambda: tmp_path)
    source, stored, compiled = pathlib.Path(kernel_entries.__file__), kernel_entries.Stored(b"", "f", []), []

    def use(kinds) -> None:
        def compile_() -> tuple[kernel_entries.Stored, bool]:
            compiled.append(kinds)
            return stored, True

        kernel_entries.Entry(source, ("f",), kinds).get(compile_, lambda found: found)

    for version in ((3, 11), "1"), ((3, 13), "2"):
        monkeypatch.setattr(kernel_entries, "python_interface", lambda version=version: version)
        for _ in range(2):
            use(kernel_entries.FOR_C)
            use(("int64",))
    assert compiled == [kernel_entries.FOR_C, ("int64",), ("int64",)]
