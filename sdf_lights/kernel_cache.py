# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Compiled kernels on disk: one file each, whose checksum is verified before its content is read.

A file is written under a temporary name, flushed and renamed, so a second process or a crash never leaves half a file.
A damaged file, or one that could be another user's work, is deleted and compiled again: ``refused`` says so. If the
folder cannot be written, only compile time is lost: ``problem`` says so, and nothing fails.
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

OLD_DAYS = 90.0  # without use, after which the kernels of a version are removed
OLD_PARTS = 3600.0  # seconds after which an unfinished file counts as abandoned
MOST_BYTES = 512 << 20  # of all kernels; above it, the least recently used are removed
MAGIC = b"SDF Lights kernel 2\n"
SUFFIX, UNFINISHED = ".kernel", ".part"
SHIPPED = pathlib.Path(__file__).resolve().parent / "compiled"  # in an extension whose zip was built with kernels
_DIGEST = hashlib.sha256().digest_size
_WRITABLE_BY_OTHERS = 0o022

_problems: list[str] = []
_refused: list[pathlib.Path] = []


def problem() -> str:
    """One sentence with the reason why kernels cannot be kept on disk; empty if they can."""
    return _problems[0] if _problems else ""


def refused() -> str:
    """One sentence about files that were not used since the last call; empty if there were none."""
    found = list(_refused)
    _refused.clear()
    if not found:
        return ""
    return (
        f"{len(found)} damaged or foreign {'file' if len(found) == 1 else 'files'} of compiled kernels in "
        f"'{found[0].parent}' {'was' if len(found) == 1 else 'were'} not used; the kernels have been compiled again."
    )


def note(folder: pathlib.Path, error: OSError) -> None:
    """Record for ``problem`` that ``folder`` cannot be written."""
    why = error.strerror or type(error).__name__
    _problems.append(
        f"Compiled kernels cannot be kept in '{folder}' ({why}), so they are compiled again for each start: "
        "free some space, or set SDF_LIGHTS_CACHE to a folder that can be written."
    )


def cache_folder() -> pathlib.Path:
    """Folder for compiled kernels: ``SDF_LIGHTS_CACHE`` (set by the extension to its own user folder), or the user's
    cache folder."""
    root = os.environ.get("SDF_LIGHTS_CACHE")
    if root:
        return pathlib.Path(root)
    base = os.environ.get("XDG_CACHE_HOME") or os.environ.get("LOCALAPPDATA") or pathlib.Path.home() / ".cache"
    return pathlib.Path(base) / "sdf_lights"


@functools.cache
def writable_folder() -> pathlib.Path:
    """``cache_folder``, or a temporary folder if it cannot be written."""
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
    """The compiled code of one function: in ``folder``, under names that begin with ``name``.

    A key is anything whose ``repr`` contains everything that the result
    depends on, except what the folder's name already contains.
    """

    def __init__(self, folder: pathlib.Path, name: str, most: int | None = None, shipped: pathlib.Path | None = None):
        """``most``: bytes that the folder may take; above it, the least recently used files are removed. None: no
        limit. ``shipped``: a folder of the extension with files that ``folder`` lacks."""
        self._folder, self._name, self._most, self._shipped = folder, name, most, shipped

    def load(self, key):
        """The data saved under this key, or None."""
        path = self.path(key)
        payload = _verified(path)
        if payload is None and self._shipped is not None:
            payload = _content(self._shipped / path.name)
        if payload is None:
            return None
        try:
            saved, data = pickle.loads(payload)
        except Exception:  # written by another version of a library
            drop(path)
            return None
        if saved != repr(key):
            return None
        _mark_used(self._folder)
        if self._most is not None:
            _touch(path)
        return data

    def save(self, key, data) -> None:
        """Save ``data``. If that fails, ``problem`` gives the reason."""
        payload = pickle.dumps((repr(key), data))
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
        """Delete the data of this key."""
        drop(self.path(key))

    def flush(self) -> None:
        """Delete all data of the function."""
        for path in self._folder.glob(f"{self._name}-*{SUFFIX}"):
            drop(path)

    def path(self, key) -> pathlib.Path:
        """The path of a key's file, whether it exists or not."""
        return self._folder / f"{self._name}-{hashlib.sha256(repr(key).encode()).hexdigest()[:24]}{SUFFIX}"


def _verified(path: pathlib.Path) -> bytes | None:
    """The content of a file after its checksum. A file that does not look like the work of this user's own process is
    deleted."""
    try:
        with open(path, "rb") as file:
            trusted = _is_own(os.fstat(file.fileno()))
            found = file.read() if trusted else b""
    except OSError:
        return None
    payload = _checked(found)
    if payload is None:
        _refused.append(path)
        drop(path)
    return payload


def _content(path: pathlib.Path) -> bytes | None:
    """The content of a file of the extension itself after its checksum: it is trusted like the extension's Python
    code."""
    try:
        return _checked(path.read_bytes())
    except OSError:
        return None


def _checked(found: bytes) -> bytes | None:
    """The data after a valid checksum."""
    start = len(MAGIC) + _DIGEST
    payload = found[start:]
    if found[: len(MAGIC)] == MAGIC and found[len(MAGIC) : start] == hashlib.sha256(payload).digest():
        return payload
    return None


def _is_own(status: os.stat_result) -> bool:
    """Whether only this user, or the system's, can have written a file. On Windows, the folder sets the permissions."""
    if not hasattr(os, "getuid"):
        return True
    return status.st_uid in (os.getuid(), 0) and not status.st_mode & _WRITABLE_BY_OTHERS


def drop(path: pathlib.Path) -> None:
    """Delete a file, if it exists and can be deleted."""
    try:
        path.unlink(missing_ok=True)
    except OSError:
        pass


def _write(path: pathlib.Path, content: bytes) -> None:
    """Replace a file atomically by one that only this user can read."""
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
    """The folder directly below the cache's that contains a folder: that of one version of some sources."""
    root = writable_folder()
    return root / folder.relative_to(root).parts[0] if root in folder.parents else None


@functools.cache
def _mark_used(folder: pathlib.Path) -> None:
    """Record once per process that kernels of this version are in use."""
    version = _version_folder(folder)
    if version is not None:
        _touch(version)


def _touch(path: pathlib.Path) -> None:
    """Record that a file or folder is used now."""
    try:
        os.utime(path)
    except OSError:
        pass


@functools.cache
def _tidy() -> None:
    """Remove old files, once per process that compiles."""
    tidy(writable_folder(), time.time())


@functools.cache
def _trim_once(folder: pathlib.Path, most: int) -> None:
    """Call ``trim``, once per process that compiles."""
    trim(folder, most)


def trim(folder: pathlib.Path, most: int) -> None:
    """Remove the least recently used files of a folder until all take at most ``most`` bytes."""
    used = []
    for path in folder.glob(f"*{SUFFIX}"):
        try:
            status = path.stat()
        except OSError:  # another process has removed it
            continue
        used.append((status.st_mtime, status.st_size, path))
    total = 0
    for _, size, path in sorted(used, reverse=True):
        total += size
        if total > most:
            drop(path)


def tidy(root: pathlib.Path, now: float, most: int = MOST_BYTES) -> None:
    """Remove versions unused for ``OLD_DAYS``, then the least recently used ones until all take at most ``most`` bytes,
    and unfinished files.

    ``now`` is in seconds since the epoch, like file times.
    """
    total = 0
    try:
        versions = [(path.stat().st_mtime, path) for path in root.iterdir() if path.is_dir() and not path.is_symlink()]
    except OSError:
        return
    for used, path in sorted(versions, reverse=True):
        total += sum(_size(file) for file in path.rglob("*"))
        # The version in use stays, however large it is.
        if used < now - 86_400.0 and (total > most or used < now - 86_400.0 * OLD_DAYS):
            shutil.rmtree(path, ignore_errors=True)
            continue
        for part in path.rglob(f"*{UNFINISHED}"):  # of processes that ended while they wrote
            if _age(part, now) > OLD_PARTS:
                drop(part)


def size(root: pathlib.Path) -> int:
    """Bytes of all files in a folder for compiled kernels."""
    return sum(map(_size, root.rglob(f"*{SUFFIX}")))


def clear(root: pathlib.Path) -> None:
    """Delete all kernels in a folder, and no other files."""
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
