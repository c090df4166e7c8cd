# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Plots of the report: error against time, and pictures beside their errors."""

from __future__ import annotations

import pathlib

import matplotlib
import numpy as np

matplotlib.use("Agg")

from matplotlib import pyplot
from matplotlib.colors import LogNorm
from matplotlib.ticker import LogLocator, NullFormatter
from PIL import Image, PngImagePlugin

from . import records
from .results import METHODS, METRICS, NUMBERS, RULES, Result

ERRORS = (0.01, 1.0)  # range of the false colours
DOTS = 90  # an inch


def _save(figure, path: pathlib.Path, source: Result | None) -> None:
    """``source``: what it was drawn from, if that is known."""
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=DOTS, metadata={"Software": None})
    pyplot.close(figure)
    # A palette makes files of noise a third as large.
    with Image.open(path) as picture:
        few = picture.convert("RGB").quantize(256, dither=Image.Dither.NONE)
    said = PngImagePlugin.PngInfo()
    if source is not None:
        said.add_text(records.KEY, records.of(source))
    few.save(path, optimize=True, pnginfo=said)


def against_time(result: Result, metric: str, path: pathlib.Path) -> bool:
    """Error against seconds, both logarithmic, a panel for each scene; bands reach from the best seed to the worst.

    False if nothing is known of the metric.
    """
    scenes = list(dict.fromkeys(row["scene"] for row in result.rows))
    curves = {}
    for scene in scenes:
        for method in METHODS:
            rows = sorted(result.of(scene=scene, method=method), key=lambda row: row["samples"])
            if rows and all(row.get(metric) is not None for row in rows):
                curves[scene, method] = rows
    if not curves:
        return False
    figure, panels = pyplot.subplots(
        1, len(scenes), figsize=(2.7 * len(scenes) + 0.6, 3.6), sharey=True, squeeze=False, layout="constrained"
    )
    for panel, scene in zip(panels[0], scenes):
        for method, (label, colour, marker) in METHODS.items():
            rows = curves.get((scene, method))
            if not rows:
                continue
            seconds = [row["seconds"] for row in rows]
            panel.fill_between(
                seconds,
                [row[f"{metric}_low"] for row in rows],
                [row[f"{metric}_high"] for row in rows],
                color=colour,
                alpha=0.2,
                linewidth=0.0,
            )
            panel.plot(seconds, [row[metric] for row in rows], color=colour, marker=marker, markersize=4, label=label)
        panel.set(xscale="log", yscale="log", title=scene, xlabel="seconds")
        panel.xaxis.set(
            major_locator=LogLocator(subs=(1.0, 3.0)), major_formatter="{x:g}", minor_formatter=NullFormatter()
        )
        panel.grid(True, which="both", alpha=0.15)
    panels[0, 0].set_ylabel(METRICS[metric])
    handles = {label: handle for panel in panels[0] for handle, label in zip(*panel.get_legend_handles_labels())}
    figure.legend(
        handles.values(),
        handles.keys(),
        loc="outside lower center",
        ncols=4 if len(scenes) > 3 else 2,
        frameon=False,
        fontsize=9,
    )
    _save(figure, path, result)
    return True


def crossings(result: Result, path: pathlib.Path) -> bool:
    """Evaluations on a ray by each rule, for the smooth cases; and the time of a ray against the number of parts.

    False if there is nothing to draw.
    """
    smooth = sorted((row for row in result.rows if row.get("smooth")), key=lambda row: row["evaluations"])
    curves = {}
    for row in result.rows:
        if "primitives" in row:
            curves.setdefault((row["operation"], row["spread"]), []).append((row["primitives"], row["ns_per_ray"]))
    if not smooth or not curves:
        return False
    figure, (left, right) = pyplot.subplots(1, 2, figsize=(12.0, 4.2), layout="constrained", width_ratios=(1.4, 1.0))
    places = np.arange(len(smooth))
    for key, label, colour, marker in RULES:
        left.scatter([row[key] for row in smooth], places, color=colour, marker=marker, label=label, zorder=2)
    left.set(
        xscale="log",
        xlabel="evaluations of the field on a ray",
        yticks=places,
        yticklabels=[row["case"] for row in smooth],
    )
    left.set_xlim(right=8.0 * left.get_xlim()[1])  # room for the legend
    left.legend(frameon=False, fontsize=9, loc="lower right")
    for (operation, spread), points in curves.items():
        count, nanoseconds = zip(*points)
        smooth_one = operation.startswith("smooth")
        right.plot(
            count,
            np.array(nanoseconds) / 1e3,
            color=RULES[0][2] if smooth_one else "#e08214",
            linestyle="-" if spread.startswith("as many") else ":",
            marker="o",
            markersize=4,
            label=f"{operation}, {spread}",
        )
    right.set(xscale="log", yscale="log", xlabel="primitives", ylabel="µs of a ray")
    right.legend(frameon=False, fontsize=9)
    for panel in (left, right):
        panel.grid(True, which="both", alpha=0.15)
    _save(figure, path, result)
    return True


def scaling(result: Result, path: pathlib.Path) -> bool:
    """Seconds over each growing number of a scene, both logarithmic. False if there are none."""
    names = list(dict.fromkeys(row["curve"] for row in result.rows))
    if not names:
        return False
    figure, panels = pyplot.subplots(
        1, len(names), figsize=(2.7 * len(names) + 0.6, 3.4), squeeze=False, layout="constrained"
    )
    for panel, name in zip(panels[0], names):
        rows = result.of(curve=name)
        counts = [row["count"] for row in rows]
        panel.plot(
            counts,
            [row["seconds"] for row in rows],
            color="#1f6fb4",
            marker="o",
            markersize=4,
            label="samples, at equal error",
        )
        started = [(row["count"], row["start"]) for row in rows if row["start"] > 0.0]
        if started:
            panel.plot(
                *zip(*started),
                color="#878787",
                marker="x",
                markersize=4,
                linestyle=":",
                label="before the first sample",
            )
        panel.set(xscale="log", yscale="log", title=NUMBERS.get(name, name), xlabel="number")
        panel.grid(True, which="both", alpha=0.15)
    panels[0, 0].set_ylabel("seconds")
    handles = {label: handle for panel in panels[0] for handle, label in zip(*panel.get_legend_handles_labels())}
    figure.legend(handles.values(), handles.keys(), loc="outside lower center", ncols=2, frameon=False, fontsize=9)
    _save(figure, path, result)
    return True


def _shown(pixels: np.ndarray) -> np.ndarray:
    """sRGB of scene-linear pixels, row 0 at the top."""
    x = np.clip(pixels[::-1], 0.0, 1.0)
    return np.where(x <= 0.0031308, 12.92 * x, 1.055 * x ** (1.0 / 2.4) - 0.055)


def _error(pixels: np.ndarray, reference: np.ndarray) -> np.ndarray:
    """Mean over the channels of |x − r| / (r + 0.01 r̄), as in MAPE, row 0 at the top."""
    return (np.abs(pixels - reference) / (reference + 0.01 * reference.mean())).mean(axis=2)[::-1]


def pictures(file: pathlib.Path, methods: list[str], path: pathlib.Path, source: Result | None = None) -> list[str]:
    """A reference and renders in a row, with false-colour errors below them; returns the shown methods.

    ``source``: the result that the renders belong to, if that is known.
    """
    with np.load(file) as kept:
        images = {name: kept[name].astype(float) for name in kept.files}
    known = [method for method in methods if method in images]
    figure, panels = pyplot.subplots(
        2, len(known) + 1, figsize=(2.0 * (len(known) + 1) + 0.9, 4.4), squeeze=False, layout="constrained"
    )
    panels[0, 0].imshow(_shown(images["reference"]))
    panels[0, 0].set_title("reference", fontsize=9)
    for column, method in enumerate(known, 1):
        own = "reference of the mesh light"
        truth = images[own if method == "Cycles mesh light" and own in images else "reference"]
        panels[0, column].imshow(_shown(images[method]))
        panels[0, column].set_title(METHODS[method][0].replace(": ", ":\n"), fontsize=9)
        shown = panels[1, column].imshow(
            np.clip(_error(images[method], truth), *ERRORS), norm=LogNorm(*ERRORS), cmap="inferno"
        )
    for panel in panels.flat:
        panel.set_axis_off()
    figure.colorbar(shown, ax=panels[:, -1], label="relative error", shrink=0.8)
    _save(figure, path, source)
    return known
