# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What every test has: the repository on the import path and a folder for compiled kernels that stays between runs."""

import contextlib
import importlib.util
import os
import pathlib
import subprocess
import sys
from collections.abc import Callable, Iterator

import pytest

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None

REPOSITORY = pathlib.Path(__file__).resolve().parents[1]

for folder in (str(REPOSITORY / "scripts"), str(REPOSITORY)):
    if folder not in sys.path:
        sys.path.insert(0, folder)

import host  # noqa: E402  (found on the path set above)

# Inverting a 4 × 4 matrix wakes OpenBLAS's other threads in Blender's older NumPy: ten times the work, and where the
# cores are busy a wait of milliseconds. It reads this when NumPy is first imported.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

# Programs of the GPU take long to compile in software, and tests run each of them for moments. So LLVM leaves them as
# they are: a third less time.
os.environ.setdefault("GALLIVM_PERF", "nopt")

# Kernels compiled by the tests stay in the checkout: a run never sees, or fills, the user's own cache.
os.environ.setdefault("SDF_LIGHTS_CACHE", str(REPOSITORY / "build" / "kernels"))


@contextlib.contextmanager
def _locked(path: pathlib.Path) -> Iterator[None]:
    """No other process is in a block with the lock of the same ``path``."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("w") as lock:
        if fcntl is not None:
            fcntl.flock(lock, fcntl.LOCK_EX)
        yield


def pytest_sessionstart(session):
    """Where tests run in several processes, kernels are compiled before: each would otherwise compile the same ones."""
    if not getattr(session.config.option, "numprocesses", None) or hasattr(session.config, "workerinput"):
        return
    from sdf_lights.render.cpu.background import NEEDED

    if importlib.util.find_spec("numba"):
        command = [sys.executable, "-m", "sdf_lights.render.cpu.precompile"]
        options = dict(cwd=REPOSITORY, stdout=subprocess.DEVNULL)
        for process in [subprocess.Popen([*command, *groups], **options) for groups in NEEDED]:
            process.wait()


@pytest.fixture(scope="session")
def shared(tmp_path_factory) -> Callable[[str, Callable[[pathlib.Path], None]], pathlib.Path]:
    """``shared(name, make)`` is a file that ``make(path)`` has written, once for all processes of tests."""
    folder = tmp_path_factory.getbasetemp()
    folder = folder.parent if "PYTEST_XDIST_WORKER" in os.environ else folder

    def file(name: str, make: Callable[[pathlib.Path], None]) -> pathlib.Path:
        path = folder / name
        with _locked(path.with_suffix(".lock")):
            if not path.is_file():
                make(path)
        return path

    return file


@pytest.fixture(scope="session")
def blender_command() -> list[str]:
    """Command that opens a Blender with a window; arguments follow it. The test is skipped where there is none. Its
    kernels are compiled: two processes of tests would otherwise compile the same ones at once."""
    command = host.windowed_blender()
    if command is None:
        pytest.skip(host.NO_WINDOW)
    session = REPOSITORY / "tests" / "blender" / "kernels_session.py"
    with _locked(pathlib.Path(os.environ["SDF_LIGHTS_CACHE"]) / "compiling.lock"):
        subprocess.run([*command, "--background", "--factory-startup", "--python", session], check=True, timeout=900)
    return command


@pytest.fixture
def openvdb(monkeypatch, tmp_path_factory):
    """OpenVDB's module: Blender's, or Debian's alone of all that Debian has. The test is skipped where there is
    none."""
    folder = tmp_path_factory.mktemp("openvdb")
    for path in pathlib.Path("/usr/lib/python3/dist-packages").glob("pyopenvdb*.so"):
        (folder / path.name).symlink_to(path)
    monkeypatch.syspath_prepend(str(folder))
    importlib.invalidate_caches()
    for name in ("openvdb", "pyopenvdb"):
        try:
            return importlib.import_module(name)
        except ImportError:
            pass
    pytest.skip("needs OpenVDB for this Python: apt-get install python3-openvdb, of Debian 12 with Python 3.11")


_exit_codes: list[int] = []


def pytest_sessionfinish(session, exitstatus):
    _exit_codes.append(int(exitstatus))


@pytest.hookimpl(trylast=True)
def pytest_unconfigure(config):
    """End here where a test has loaded Blender: the destructors of its Python module can hang."""
    if "bpy" in sys.modules and _exit_codes:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(_exit_codes[0])
