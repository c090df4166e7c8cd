# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Compiles and runs programs of the GPU that ``bench programs --keep-programs FOLDER`` has kept. It needs NumPy and
moderngl, but no Blender.

    python scripts/benchmarks/program_session.py FOLDER [--forms FORM,…] [--processes N]

prints a JSON object for each program and form. Each has a process of its own: compilers work at the same time, and the
dispatches take turns.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import os
import pathlib
import re
import subprocess
import sys
import time
from collections.abc import Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor

import numpy as np

SAMPLES = 32, 8  # of a thread in a dispatch
LONGEST = 2.0  # seconds of a dispatch; a slower device takes fewer samples
WARM_UP = 0.5  # seconds of dispatches, at least two of them: a card that was idle may begin slowly
TEXTURE_BITS = 14
LOCK = "busy"
UNCACHED = {"__GL_SHADER_DISK_CACHE": "0", "MESA_SHADER_CACHE_DISABLE": "true"}  # drivers keep programs on disk
OWN_BUFFER = 5  # a free binding
ARRAYS = 6, 7  # bindings of the arrays of threads, as in thread_arrays.py

# --- forms of a program -----------------------------------------------------------------------------------------------

# Functions that are called from several places, of which compilers make a copy for each.
CALLED = "lamps_trace_parts", "lamps_trace", "hit_scene", "scattering_evaluate", "terminator_light_start"


def as_it_is(source: str) -> str:
    return source


def calls(source: str) -> str:
    """With functions that a program can choose when it runs, so that a compiler keeps one copy of each."""
    for name in CALLED:
        found = re.search(rf"^(\w+) {name}\(([^;{{]*?)\)\s*\{{", source, re.MULTILINE)
        if found:
            kind, parameters = found.groups()
            text = (
                f"subroutine {kind} Kind_{name}({parameters});\n"
                f"subroutine uniform Kind_{name} {name};\n"
                f"subroutine(Kind_{name}) {kind} only_{name}({parameters})\n{{"
            )
            source = source[: found.start()] + text + source[found.end() :]
    return source


def walks_in_buffer(source: str) -> str:
    """With the nodes that wait while a ray goes through the hierarchy in a buffer, as in ``thread_arrays.py``."""
    declared, parts, after = "int waiting[STACK];", [], 0
    assert source.count(declared) == 1
    head, source = source.split(declared)
    for found in re.finditer(r"\bwaiting\[", source):
        end = _bracket(source, found.end())
        parts += [source[after : found.start()], f"walks[WALK({source[found.end() : end]})]"]
        after = end + 1
    buffer = (
        f"layout(std430, binding = {OWN_BUFFER}) buffer Walks {{ int walks[]; }};\n"
        "#define WALK(place) ((place) * int(gl_NumWorkGroups.x * uint(GROUP)) + int(gl_GlobalInvocationID.x))\n"
    )
    return "".join([head, buffer, *parts, source[after:]])


def _bracket(source: str, start: int) -> int:
    """The place of the bracket that closes one before ``start``."""
    depth = 1
    for place in range(start, len(source)):
        depth += {"[": 1, "]": -1}.get(source[place], 0)
        if not depth:
            return place
    raise ValueError("a bracket is not closed")


AS_IT_IS = "as it is"
FORMS = {AS_IT_IS: as_it_is, "calls": calls, "walks in a buffer": walks_in_buffer}

# --- one program ------------------------------------------------------------------------------------------------------


def _context():
    import moderngl

    try:
        return moderngl.create_context(standalone=True, require=430, backend="egl")
    except Exception:  # each platform's driver has errors of its own
        return moderngl.create_context(standalone=True, require=430)


def _defined(source: str, name: str) -> int:
    return int(re.findall(rf"^#define {name} (\d+)$", source, re.MULTILINE)[0])


@contextlib.contextmanager
def turn(folder: pathlib.Path) -> Iterator[None]:
    """Wait until no other process runs dispatches."""
    while True:
        try:
            os.close(os.open(folder / LOCK, os.O_CREAT | os.O_EXCL))
            break
        except FileExistsError:
            time.sleep(0.02)
    try:
        yield
    finally:
        (folder / LOCK).unlink()


class Run:
    """A compiled program with the data of its scene."""

    def __init__(self, context, program, data, source: str):
        self._context, self.program = context, program
        self._group = _defined(source, "GROUP")
        self._images = "#define IMAGES\n" in source  # how triangles are read: see packed_scene.py
        self.size, self.count = int(data["size"]), len(data["pixels"])
        uniforms = data["uniforms"]
        self._uniforms = self._buffer(uniforms)
        self._sums = self._buffer(np.zeros(self.size * self.count, np.float32))
        self._pixels = self._buffer(np.concatenate([[0], data["pixels"]]).astype(np.uint32))
        lengths = self._buffer(np.zeros(2 * max(int(data["lamps"]), 1), np.float32))
        threads = -(-self.count // self._group) * self._group
        arrays = context.buffer(reserve=4 * max(int(data["thread_words"]), 1) * threads)
        walks = context.buffer(reserve=4 * _defined(source, "STACK") * threads)
        words, second = self._buffer(data["words"]), self._buffer(data["second"])
        self._buffers = {0: words, 1: self._sums, 2: self._pixels, 3: lengths, 4: second, OWN_BUFFER: walks}
        self._buffers |= dict.fromkeys(ARRAYS, arrays)
        self._textures = [self._texture(data[name]) for name in ("nodes", "items")]
        for name in ("film_place", "film_seed", "film_offset"):
            if name in program:
                value = data[name].tolist()
                program[name] = tuple(value) if isinstance(value, list) else value

    def _buffer(self, array: np.ndarray):
        return self._context.buffer(np.ascontiguousarray(array).view(np.uint8).reshape(-1))

    def _texture(self, array: np.ndarray):
        width = 1 << TEXTURE_BITS
        words = np.zeros((-(-array.nbytes // (16 * width)), width, 4), np.uint32)
        words.reshape(-1)[: array.nbytes // 4] = np.ascontiguousarray(array).view(np.uint32).reshape(-1)
        return self._context.texture((width, len(words)), 4, words, dtype="u4")

    def dispatch(self, threads: int, samples: int) -> float:
        """Seconds of one dispatch from the first sample on."""
        self._uniforms.bind_to_uniform_block(0)
        for binding, buffer in self._buffers.items():
            buffer.bind_to_storage_buffer(binding)
        for unit, texture in enumerate(self._textures):
            if self._images:
                texture.bind_to_image(unit, read=True, write=False)
            else:
                texture.use(unit)
        self._sums.clear()
        self._context.finish()
        started = time.perf_counter()
        self.program["work"] = 0, threads, 0, samples
        self.program.run(-(-threads // self._group))
        self._context.finish()
        return time.perf_counter() - started

    def transfers(self) -> tuple[float, float]:
        """Seconds to clear the sums of all pixels, and to read them after a short dispatch, as renders do after each
        batch of samples; the second time, because drivers move buffers that are read."""
        for _ in range(2):
            started = time.perf_counter()
            self._sums.clear()
            self._context.finish()
            cleared = time.perf_counter() - started
            self.dispatch(self.count, 1)
            started = time.perf_counter()
            self._sums.read()
            read = time.perf_counter() - started
        return cleared, read

    @property
    def finished(self) -> bool:
        return not np.frombuffer(self._pixels.read(4), np.uint32)[0]

    def picture(self) -> np.ndarray:
        """(pixels, 3): the means of the last dispatch."""
        sums = np.frombuffer(self._sums.read(), np.float32).reshape(self.size, self.count).astype(np.float64)
        return (sums[:3] / np.maximum(sums[7], 1.0)).T  # as packed_scene.film_places has it


def run_one(folder: pathlib.Path, name: str, form: str, dispatches: bool = True) -> dict:
    """Compile a program in a form, and time dispatches."""
    row = dict(program=name, form=form)
    source = FORMS[form]((folder / f"{name}.glsl").read_text(encoding="utf-8"))
    context, data = _context(), np.load(folder / f"{name}.npz")
    started = time.perf_counter()
    try:
        program = context.compute_shader(source)
    except Exception as error:
        lines = [line for line in str(error).splitlines() if "error" in line.lower()]
        return row | dict(problem=(lines or [str(error)])[0][:200])
    seconds = time.perf_counter() - started
    run = Run(context, program, data, source)
    row["compile_seconds"] = seconds + run.dispatch(1, 1)  # some drivers compile only now
    if not dispatches:
        program.release()
        context.release()  # a driver may write what it keeps only now
        return row
    row["thread_words"] = int(data["thread_words"])
    with turn(folder):
        one = run.dispatch(run.count, 1)
        most = max(int(LONGEST / one), 1)
        for samples in SAMPLES:
            samples = min(samples, most)
            seconds: list[float] = []
            while len(seconds) < 2 or sum(seconds) < WARM_UP:
                seconds.append(run.dispatch(run.count, samples))
            row[f"samples_per_second_{samples}"] = run.count * samples / min(seconds)
            row.setdefault("samples_per_second_at_first", run.count * samples / seconds[0])
        picture = run.picture()
        row |= dict(mean=float(picture.mean()), finished=run.finished)
        row["clear_seconds"], row["read_seconds"] = run.transfers()
    np.save(folder / f"{name} {form}.npy", picture)
    return row


# --- all of them ------------------------------------------------------------------------------------------------------


def _names(folder: pathlib.Path) -> list[str]:
    """The programs in a folder, the largest first: they take longest."""
    paths = sorted(folder.glob("*.glsl"), key=lambda path: (-path.stat().st_size, path.name))
    return [path.stem for path in paths]


def _work(folder: pathlib.Path, name: str, form: str, *more: str, **environment: str) -> dict:
    """``run_one`` in a process of its own."""
    command = [sys.executable, __file__, str(folder), "--one", name, form, *more]
    done = subprocess.run(command, capture_output=True, text=True, env={**os.environ, **environment})
    if done.returncode:
        (folder / LOCK).unlink(missing_ok=True)  # of a driver that has ended the process
        problem = (done.stderr.strip().splitlines() or [f"ends with {done.returncode}"])[-1]
        return dict(program=name, form=form, problem=problem)
    return json.loads(done.stdout.splitlines()[-1])


def fill_cache(folder: pathlib.Path, processes: int) -> None:
    """Compile all programs in a folder, so that the driver finds them on disk later."""
    with ThreadPoolExecutor(processes) as pool:
        list(pool.map(lambda name: _work(folder, name, AS_IT_IS, "--compile"), _names(folder)))


def run_all(folder: pathlib.Path, forms: Iterable[str], processes: int) -> list[dict]:
    """A row for each program in the folder and each form. ``difference``: of a form's picture from that of the program
    as it is, relative to its mean."""
    (folder / LOCK).unlink(missing_ok=True)
    jobs = [(name, form) for name in _names(folder) for form in forms]
    with ThreadPoolExecutor(processes) as pool:
        rows = list(pool.map(lambda job: _work(folder, *job, **UNCACHED), jobs))
    for row in rows:
        paths = [folder / f"{row['program']} {form}.npy" for form in (AS_IT_IS, row["form"])]
        if "problem" not in row and all(path.is_file() for path in paths):
            first, second = (np.load(path) for path in paths)
            row["difference"] = float(np.abs(first - second).mean() / np.abs(first).mean())
    return rows


def main() -> None:
    parser = argparse.ArgumentParser(description="Compiles and runs programs of the GPU.")
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--forms", default=",".join(FORMS), help="of each program, separated by commas")
    parser.add_argument("--processes", type=int, default=os.cpu_count() or 1, help="that compile at the same time")
    parser.add_argument("--one", nargs=2, metavar=("PROGRAM", "FORM"), help="only this")
    parser.add_argument("--compile", action="store_true", help="without dispatches")
    options = parser.parse_args()
    if options.one:
        print(json.dumps(run_one(options.folder, *options.one, not options.compile)), flush=True)
        if not options.compile:
            os._exit(0)  # destructors of some drivers take long
        return
    for row in run_all(options.folder, options.forms.split(","), options.processes):
        print(json.dumps(row), flush=True)


if __name__ == "__main__":
    main()
