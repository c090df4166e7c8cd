# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Compiled kernels on disk survive whatever happens to their files."""

import os
import pathlib
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

import pytest

from sdf_lights import kernel_cache
from sdf_lights.kernel_cache import MAGIC, Files

REPOSITORY = pathlib.Path(__file__).resolve().parents[1]
KEY = ("(float64) -> float64", "x86", "")


@pytest.fixture
def files(tmp_path, monkeypatch):
    monkeypatch.setattr(kernel_cache, "_problems", [])
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
    files.save(KEY, "again")
    assert files.load(KEY) == "again"


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
from sdf_lights import kernel_cache
from sdf_lights.render.kernels.sampler import draw1, pixel_seed
print(draw1(3, pixel_seed(1, 2, 3), 4), pixel_seed(1, 2, 3), bool(kernel_cache.problem()))
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


def test_processes_share_a_folder(tmp_path):
    with ThreadPoolExecutor(3) as pool:
        found = list(pool.map(lambda _: drawn(tmp_path), range(3)))
    assert found[0] == found[1] == found[2]
