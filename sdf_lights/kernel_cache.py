# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Compiled kernels on disk: a file each, whose checksum is verified before anything of it is read.

A file is written beside its place, flushed and renamed, so neither a second process nor a sudden end leaves half of
one. What is damaged, or could be another user's work, is deleted, and compiled again. A folder that cannot be written
costs the time to compile: ``problem`` says so, and nothing fails.
"""

from __future__ import annotations

import atexit
import functools
import hashlib
import os
import pathlib
import pickle
import shutil
import tempfile
import time

OLD_DAYS = 90.0  # without use, after which a version's kernels go
OLD_PARTS = 3600.0  # seconds after which nobody writes an unfinished file any more
MOST_BYTES = 512 << 20  # of all kernels; beyond, those go that were used least recently
MAGIC = b"SDF Lights kernel 1\n"
SUFFIX, UNFINISHED = ".kernel", ".part"
SHIPPED = pathlib.Path(__file__).resolve().parent / "compiled"  # in an extension whose zip was built with kernels
_DIGEST = hashlib.sha256().digest_size
_WRITABLE_BY_OTHERS = 0o022

_problems: list[str] = []


def problem() -> str:
    """One sentence about why kernels cannot be kept on disk; empty where they can."""
    return _problems[0] if _problems else ""


def note(folder: pathlib.Path, error: OSError) -> None:
    """Remember that ``folder`` cannot be written, for ``problem``."""
    why = error.strerror or type(error).__name__
    _problems.append(
        f"Compiled kernels cannot be kept in '{folder}' ({why}), so they are compiled again for each start: "
        "free some space, or set SDF_LIGHTS_CACHE to a folder that can be written."
    )


def cache_folder() -> pathlib.Path:
    """Folder for compiled kernels: ``SDF_LIGHTS_CACHE`` (set by the extension to its own user folder), or the user's cache
    folder."""
    root = os.environ.get("SDF_LIGHTS_CACHE")
    if root:
        return pathlib.Path(root)
    base = os.environ.get("XDG_CACHE_HOME") or os.environ.get("LOCALAPPDATA") or pathlib.Path.home() / ".cache"
    return pathlib.Path(base) / "sdf_lights"


@functools.cache
def writable_folder() -> pathlib.Path:
    """``cache_folder``, or a temporary one where that cannot be written."""
    folder = cache_folder()
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return folder
    except OSError as error:
        note(folder, error)
        temporary = pathlib.Path(tempfile.mkdtemp(prefix="sdf_lights-"))
        atexit.register(shutil.rmtree, temporary, ignore_errors=True)
        return temporary


class Files:
    """What was compiled of one function: in ``folder``, by names that begin with ``name``.

    Stands in for Numba's ``IndexDataCacheFile``: a key is anything whose ``repr`` says all that the result depends on, beside what
    the folder's name says already.
    """

    def __init__(self, folder: pathlib.Path, name: str, most: int | None = None, shipped: pathlib.Path | None = None):
        """``most``: bytes that the folder may take; beyond, what was used least recently goes. None: any number.
        ``shipped``: a folder of the extension, for what ``folder`` does not have."""
        self._folder, self._name, self._most, self._shipped = folder, name, most, shipped

    def load(self, key):
        """What was saved by this key, or None."""
        path = self.path(key)
        payload = _verified(path)
        if payload is None and self._shipped is not None:
            payload = _content(self._shipped / path.name)
        if payload is None:
            return None
        try:
            saved, data = pickle.loads(payload)
        except Exception:  # of another version of what is in it
            drop(path)
            return None
        if saved != repr(key):
            return None
        _mark_used(self._folder)
        if self._most is not None:
            _touch(path)
        return data

    def save(self, key, data) -> None:
        """Keep ``data``. Where that cannot be, ``problem`` says why."""
        from numba.core.serialize import dumps

        payload = dumps((repr(key), data))
        try:
            self._folder.mkdir(parents=True, exist_ok=True)
            _write(self.path(key), MAGIC + hashlib.sha256(payload).digest() + payload)
        except OSError as error:
            note(self._folder, error)
            return
        _tidy()
        if self._most is not None:
            _trim_once(self._folder, self._most)

    def forget(self, key) -> None:
        """Delete what is kept by this key."""
        drop(self.path(key))

    def flush(self) -> None:
        """Delete all that is kept of the function."""
        for path in self._folder.glob(f"{self._name}-*{SUFFIX}"):
            drop(path)

    def path(self, key) -> pathlib.Path:
        """The file of a key, whether it is there or not."""
        return self._folder / f"{self._name}-{hashlib.sha256(repr(key).encode()).hexdigest()[:24]}{SUFFIX}"


def _verified(path: pathlib.Path) -> bytes | None:
    """What a file holds after its checksum; a file that is not as this user's own process wrote it is deleted."""
    try:
        with open(path, "rb") as file:
            trusted = _is_own(os.fstat(file.fileno()))
            found = file.read() if trusted else b""
    except OSError:
        return None
    payload = _checked(found)
    if payload is None:
        drop(path)
    return payload


def _content(path: pathlib.Path) -> bytes | None:
    """What a file of the extension itself holds after its checksum: it is trusted as the extension's Python is."""
    try:
        return _checked(path.read_bytes())
    except OSError:
        return None


def _checked(found: bytes) -> bytes | None:
    """What follows a checksum that is right."""
    start = len(MAGIC) + _DIGEST
    payload = found[start:]
    if found[: len(MAGIC)] == MAGIC and found[len(MAGIC) : start] == hashlib.sha256(payload).digest():
        return payload
    return None


def _is_own(status: os.stat_result) -> bool:
    """Whether only this user, or the system's, can have written a file. Windows has its rights by the folder."""
    if not hasattr(os, "getuid"):
        return True
    return status.st_uid in (os.getuid(), 0) and not status.st_mode & _WRITABLE_BY_OTHERS


def drop(path: pathlib.Path) -> None:
    """Delete a file, if it is there and can be deleted."""
    try:
        path.unlink(missing_ok=True)
    except OSError:
        pass


def _write(path: pathlib.Path, content: bytes) -> None:
    """Replace a file in one step, by one that only this user can read."""
    handle, part = tempfile.mkstemp(suffix=UNFINISHED, dir=path.parent)
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        os.replace(part, path)
    except BaseException:
        drop(pathlib.Path(part))
        raise


def _version_folder(folder: pathlib.Path) -> pathlib.Path | None:
    """The folder directly below the cache's that a folder is in: of one version of some sources."""
    root = writable_folder()
    return root / folder.relative_to(root).parts[0] if root in folder.parents else None


@functools.cache
def _mark_used(folder: pathlib.Path) -> None:
    """Note once in a process that kernels of this version are in use."""
    version = _version_folder(folder)
    if version is not None:
        _touch(version)


def _touch(path: pathlib.Path) -> None:
    """Note that a file or folder is used now."""
    try:
        os.utime(path)
    except OSError:
        pass


@functools.cache
def _tidy() -> None:
    """Once in a process that compiles, remove what is old."""
    tidy(writable_folder(), time.time())


@functools.cache
def _trim_once(folder: pathlib.Path, most: int) -> None:
    """``trim``, once in a process that compiles."""
    trim(folder, most)


def trim(folder: pathlib.Path, most: int) -> None:
    """Remove files of a folder that were used least recently, until all take ``most`` bytes."""
    used = []
    for path in folder.glob(f"*{SUFFIX}"):
        try:
            status = path.stat()
        except OSError:  # which another process has removed
            continue
        used.append((status.st_mtime, status.st_size, path))
    total = 0
    for _, size, path in sorted(used, reverse=True):
        total += size
        if total > most:
            drop(path)


def tidy(root: pathlib.Path, now: float, most: int = MOST_BYTES) -> None:
    """Remove versions that were not used for ``OLD_DAYS``, then those used least recently, until all take ``most`` bytes, and
    what was left unfinished.

    ``now`` is in seconds since the epoch, as the times of files are.
    """
    total = 0
    try:
        versions = [(path.stat().st_mtime, path) for path in root.iterdir() if path.is_dir() and not path.is_symlink()]
    except OSError:
        return
    for used, path in sorted(versions, reverse=True):
        total += sum(_size(file) for file in path.rglob("*"))
        # What is in use now stays, however large.
        if used < now - 86_400.0 and (total > most or used < now - 86_400.0 * OLD_DAYS):
            shutil.rmtree(path, ignore_errors=True)
            continue
        for part in path.rglob(f"*{UNFINISHED}"):  # of processes that were ended while they wrote
            if _age(part, now) > OLD_PARTS:
                drop(part)


def size(root: pathlib.Path) -> int:
    """Bytes of all that is kept in a folder for compiled kernels."""
    return sum(map(_size, root.rglob(f"*{SUFFIX}")))


def clear(root: pathlib.Path) -> None:
    """Delete all kernels in a folder, and nothing else that may be there."""
    for path in root.rglob(f"*{SUFFIX}"):
        drop(path)


def _age(path: pathlib.Path, now: float) -> float:
    try:
        return now - path.stat().st_mtime
    except OSError:
        return 0.0


def _size(path: pathlib.Path) -> int:
    try:
        return path.stat().st_size if path.is_file() else 0
    except OSError:
        return 0
