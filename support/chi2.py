# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""χ² test that a sampler of directions produces the density of its pdf.

from support.chi2 import chi2_sphere
result = chi2_sphere(sample, pdf, n=100_000, seed=1)
assert result.passed, result
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import stats


@dataclass(frozen=True)
class Chi2Result:
    """Outcome of the test. ``integral`` is ∫pdf over the sphere by the same quadrature as the expected counts."""

    p_value: float
    statistic: float
    degrees: int
    integral: float
    integral_error: float
    lost: int  # samples that were not a unit vector: they count in no bin
    confidence: float

    @property
    def passed(self) -> bool:
        return self.p_value > 1.0 - self.confidence


def chi2_sphere(
    sample_fn_batch,
    pdf_fn_batch,
    n: int,
    seed: int,
    confidence: float = 0.999,
    *,
    dimensions: int = 3,
    axis=(0.0, 0.0, 1.0),
    bins: tuple[int, int] = (16, 16),
    quadrature: int = 12,
    quantiles: tuple[float, float] = (0.0, 1.0),
    least: float | None = None,
) -> Chi2Result:
    """Compare counts of sampled directions in bins of (cos θ, φ) around ``axis`` with the integral of the pdf there.

    ``sample_fn_batch(u)`` maps (n, dimensions) uniform numbers to (n, 3) unit vectors. A row that is not finite or not
    of unit length is a sample that the sampler gave up, so the pdf must integrate to the rest.
    ``pdf_fn_batch(directions)`` maps (m, 3) unit vectors to (m,) densities per solid angle.

    The edges in cos θ are quantiles of a pilot run, so narrow distributions fill the bins as well as wide ones; point
    ``axis`` at the light. If it is known that no sample has a cos θ below ``least``, that is an edge, too.

    Expected counts come from quadrature² jittered points per bin, and the variance of that estimate is added to the
    Poisson variance of the counts. Bins that expect fewer than five samples are pooled. A correct sampler fails with
    probability 1 − ``confidence``: keep the seed fixed, and raise the confidence with the number of tests.
    """
    rng = np.random.default_rng(seed)
    frame = _frame(np.asarray(axis, float))

    pilot, _ = _polar(sample_fn_batch(rng.random((max(2000, n // 20), dimensions))), frame)
    inner = np.quantile(pilot, np.linspace(*quantiles, bins[0] + 1))
    edges = np.unique(np.concatenate(([-1.0, -1.0 if least is None else least], inner, [1.0])))
    columns = np.linspace(-np.pi, np.pi, bins[1] + 1)

    cosine, phi = _polar(sample_fn_batch(rng.random((n, dimensions))), frame)
    observed = np.histogram2d(cosine, phi, (edges, columns))[0].ravel()

    mass, variance = _integrate(pdf_fn_batch, edges, columns, frame, quadrature, rng)
    expected = n * mass
    noise = expected + n * n * variance

    order = np.argsort(expected)
    pooled = []
    pool = np.zeros(3)
    for index in order:
        pool += (observed[index], expected[index], noise[index])
        if pool[1] >= 5.0:
            pooled.append(pool)
            pool = np.zeros(3)
    if pool[0] + pool[1] > 0.0:
        if pooled:
            pooled[-1] = pooled[-1] + pool
        else:
            pooled.append(pool)
    o, e, v = np.array(pooled).T
    statistic = float(np.sum((o - e) ** 2 / np.maximum(v, 1e-300)))
    degrees = max(len(o) - 1, 1)
    return Chi2Result(
        p_value=float(stats.chi2.sf(statistic, degrees)),
        statistic=statistic,
        degrees=degrees,
        integral=float(mass.sum()),
        integral_error=float(np.sqrt(variance.sum())),
        lost=n - len(cosine),
        confidence=confidence,
    )


def sphere_integral(pdf_fn_batch, n: int, seed: int, axis=(0.0, 0.0, 1.0), cosine=(-1.0, 1.0)) -> tuple[float, float]:
    """∫pdf dω over the part of the sphere with cos θ around ``axis`` in ``cosine``, and its standard error.

    Jittered: about n points, one in each cell of a square grid in (cos θ, φ), twice.
    """
    rng = np.random.default_rng(seed)
    side = max(int(np.sqrt(n / 2)), 1)
    frame = _frame(np.asarray(axis, float))
    edges = np.linspace(cosine[0], cosine[1], side + 1)
    columns = np.linspace(-np.pi, np.pi, side + 1)
    halves = [_integrate(pdf_fn_batch, edges, columns, frame, 1, rng)[0] for _ in range(2)]
    # The difference of two independent estimates in each cell gives that cell's variance.
    return float(sum(h.sum() for h in halves) / 2), float(np.sqrt(np.sum((halves[0] - halves[1]) ** 2)) / 2)


def _frame(axis: np.ndarray) -> np.ndarray:
    """Rotation whose rows are an orthonormal basis with ``axis`` last."""
    axis = axis / np.linalg.norm(axis)
    other = np.eye(3)[np.argmin(np.abs(axis))]
    first = np.cross(other, axis)
    first /= np.linalg.norm(first)
    return np.stack([first, np.cross(axis, first), axis])


def _polar(directions: np.ndarray, frame: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    directions = np.asarray(directions, float)
    with np.errstate(invalid="ignore"):
        square = np.sum(directions**2, axis=1)
        directions = directions[np.abs(square - 1.0) < 1e-4]
    local = directions @ frame.T
    return np.clip(local[:, 2], -1.0, 1.0), np.arctan2(local[:, 1], local[:, 0])


def _integrate(pdf, edges, columns, frame, per_side, rng) -> tuple[np.ndarray, np.ndarray]:
    """Integral of the pdf over each bin, and the variance of that estimate."""
    rows, sectors = len(edges) - 1, len(columns) - 1
    shape = (rows, sectors, per_side, per_side)
    u = (np.arange(per_side)[:, None] + rng.random(shape)) / per_side
    v = (np.arange(per_side)[None, :] + rng.random(shape)) / per_side
    height, width = np.diff(edges), np.diff(columns)
    z = edges[:-1, None, None, None] + u * height[:, None, None, None]
    phi = columns[None, :-1, None, None] + v * width[None, :, None, None]
    sine = np.sqrt(np.maximum(1.0 - z * z, 0.0))
    local = np.stack([sine * np.cos(phi), sine * np.sin(phi), z], axis=-1).reshape(-1, 3)
    local /= np.linalg.norm(local, axis=1, keepdims=True)
    values = np.asarray(pdf(local @ frame), float).reshape(rows * sectors, per_side**2)
    area = np.outer(height, width).ravel()
    # The spread over the whole bin overstates the error of a jittered mean. A quarter of the variance of neighbours'
    # differences is a good estimate: it is the remaining spread within a stratum.
    spread = np.zeros(len(values))
    if per_side > 1:
        grid = values.reshape(-1, per_side, per_side)
        across = np.mean(np.diff(grid, axis=1) ** 2, axis=(1, 2)) + np.mean(np.diff(grid, axis=2) ** 2, axis=(1, 2))
        spread = across / 4.0 / per_side**2
    return values.mean(axis=1) * area, spread * area**2
