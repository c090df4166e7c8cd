# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Compares samplers of directions to a lamp at points: error times time, without occlusion.

The errors are those of pixels of 64 and 256 samples, relative to the light there, with Owen-scrambled Sobol numbers for
all techniques. The baseline is the paper's sampler with the same numbers: projection and BSDF samples combined by the
balance heuristic.
"""

from __future__ import annotations

import functools
import math

import numpy as np
from scipy.stats import qmc

from sdf_lights.sdf.shapes import Box, BoxFrame, Difference, Sphere, Torus, Transformed
from sdf_lights.sdf.shapes.blends import SmoothUnion
from sdf_lights.sdf.shapes.fractals import MengerSponge
from support.rivals import baselines
from support.rivals.baselines import DIMENSIONS, EVEN, SHELL_EMISSION, LampBlock, Technique

from .resume import in_parts

HELP = "error times time of samplers of directions to a lamp, at points"

DOWN = (0.0, 0.0, -1.0)
SPP = (64, 256)


def _moved(x: float, y: float, z: float) -> np.ndarray:
    matrix = np.eye(4)
    matrix[:3, 3] = x, y, z
    return matrix


TORUS = Torus(1.0, 0.35)
FRAME = BoxFrame((0.6, 0.5, 0.4), 0.08)
CSG = Difference(Torus(1.0, 0.35), Transformed(Box((0.5, 0.5, 0.5)), _moved(1.0, 0.0, 0.0)))
SHELL = Difference(Sphere(0.8), Sphere(0.77))
BLOB = SmoothUnion(
    Transformed(Sphere(0.4), _moved(-0.4, 0.0, 0.0)), Transformed(Sphere(0.3), _moved(0.3, 0.1, 0.0)), radius=0.3
)
MENGER = MengerSponge(0.5, 3.0)

AT_POINTS = (Technique.POINT, Technique.RIS, Technique.RADIAL)  # for uniform emission

CASES = (  # name, group, shape, point, normal, emission
    ("torus, above", "far", TORUS, (0.4, 0.2, 1.6), DOWN, None),
    ("torus, inside", "inside", TORUS, (1.0, 0.0, 0.1), DOWN, None),
    ("torus, above, shell", "varying", TORUS, (0.4, 0.2, 1.6), DOWN, SHELL_EMISSION),
    ("torus, inside, shell", "varying", TORUS, (1.0, 0.0, 0.1), DOWN, SHELL_EMISSION),
    ("torus, on the surface", "inside", TORUS, (1.0, 0.0, 0.3501), DOWN, None),
    ("torus, 0.25 above", "near", TORUS, (1.0, 0.0, 0.6), DOWN, None),
    ("torus, z = 10", "far", TORUS, (0.4, 0.2, 10.0), DOWN, None),
    ("torus, 0.01 below its top", "inside", TORUS, (1.0, 0.0, 0.34), DOWN, None),
    ("frame, above", "thin", FRAME, (0.3, 0.2, 1.2), DOWN, None),
    ("frame, 0.1 from a bar", "near", FRAME, (0.6, 0.1, 0.5), DOWN, None),
    ("frame, centre", "thin", FRAME, (0.0, 0.0, 0.0), (0.0, 0.287, 0.958), None),
    ("notched torus, above", "far", CSG, (0.4, 0.2, 1.6), DOWN, None),
    ("notched torus, near", "near", CSG, (0.0, 1.0, 0.6), DOWN, None),
    ("shell, above", "thin", SHELL, (0.2, 0.1, 1.5), DOWN, None),
    ("shell, near", "thin", SHELL, (0.0, 0.0, 0.9), DOWN, None),
    ("blob, above", "far", BLOB, (0.1, 0.2, 1.2), DOWN, None),
    ("blob, near", "near", BLOB, (-0.4, 0.0, 0.5), DOWN, None),
    ("Menger sponge, above", "far", MENGER, (0.1, 0.2, 1.3), DOWN, None),
    ("Menger sponge, near", "near", MENGER, (0.1, 0.2, 0.6), DOWN, None),
)


@functools.cache
def _block(shape, emission) -> LampBlock:
    return LampBlock(shape, np.eye(4), emission=emission, surface=True)


def _numbers(spp: int, repeats: int) -> np.ndarray:
    """(repeats · spp, DIMENSIONS): independently scrambled sets of a Sobol sequence."""
    return np.concatenate(
        [qmc.Sobol(DIMENSIONS, scramble=True, rng=np.random.default_rng(seed)).random(spp) for seed in range(repeats)]
    )


def _errors(found: np.ndarray, truth: float) -> list[float]:
    """Relative RMSE of pixels of ``SPP`` samples."""
    pixels = [found.reshape(-1, SPP[-1])[:, :spp].mean(axis=1) for spp in SPP]
    return [float(np.sqrt(np.mean((values / truth - 1.0) ** 2))) for values in pixels]


def _time(technique, block, x, n, shell, repeats: int, count: int) -> float:
    """ns of processor time for a vertex: the least of several runs, which is disturbed least."""
    numbers = np.random.default_rng(1).random((count, DIMENSIONS))
    runs = [baselines.values(technique, block.blocks, 0, x, n, numbers, shell)[1] for _ in range(repeats)]
    return 1e9 * min(runs) / count


def measure(name: str, group: str, shape, x, n, emission, options) -> list[dict]:
    """Rows of one case, for each technique."""
    numbers = _numbers(SPP[-1], 8 if options.quick else 64)
    count, repeats = (1000, 2) if options.quick else (4000, options.repeats or 5)
    plain = np.random.default_rng(2).random((len(numbers), DIMENSIONS))
    block, shell = _block(shape, emission), EVEN
    n = np.asarray(n) / np.linalg.norm(n)
    found, spent, rows = {}, {}, []
    for technique in Technique:
        if technique in AT_POINTS and emission is not None:
            continue
        found[technique] = baselines.values(technique, block.blocks, 0, x, n, numbers, shell)[0]
        spent[technique] = _time(technique, block, x, n, shell, repeats, count)
    truth = min(
        (found[t] for t in (Technique.MIS, Technique.CUT)),
        key=lambda values: values.reshape(-1, SPP[-1]).mean(axis=1).var(),
    ).mean()
    reference = _errors(found[Technique.MIS], truth)
    for technique, values in found.items():
        errors = _errors(values, truth)
        variance = float(np.var(baselines.values(technique, block.blocks, 0, x, n, plain, shell)[0]))
        gain = [
            (before / max(after, 1e-7)) ** 2 * spent[Technique.MIS] / spent[technique]
            for before, after in zip(reference, errors)
        ]
        rows.append(
            dict(
                case=name,
                group=group,
                technique=technique.name.lower(),
                variance=variance,
                ns=spent[technique],
                error_64=errors[0],
                error_256=errors[1],
                gain_64=gain[0],
                gain_256=gain[1],
            )
        )
    return rows


def run(options) -> tuple[dict, list[dict]]:
    rows = [row for part in in_parts(CASES, lambda *case: measure(*case, options), options) for row in part]
    gains = {
        row["case"]: (row["group"], math.sqrt(row["gain_64"] * row["gain_256"]))
        for row in rows
        if row["technique"] == Technique.CUT.name.lower()
    }
    logs = {name: math.log(gain) for name, (group, gain) in gains.items()}
    hard = [logs[name] for name, (group, _) in gains.items() if group in ("near", "thin", "varying")]
    summary = dict(
        efficiency_gain_geomean=math.exp(np.mean(list(logs.values()))),
        efficiency_gain_near_thin_varying_geomean=math.exp(np.mean(hard)),
        efficiency_gain_min=math.exp(min(logs.values())),
    )
    return summary, rows
