# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The text of the report. Every number in it is read from results; sentences that judge are chosen by them."""

from __future__ import annotations

import math
import pathlib

from .results import METHODS, METRICS, Result

OURS, PAPER = "CUT", "MIS"
PEERS = ("Cycles volume", "Cycles mesh light")
LIGHT = {"cycles_direct": ("Direct light", "direct"), "cycles_bounces": ("Four bounces", "bounces")}
DRAWN = (*LIGHT, "paper")  # results that have plots

INTRODUCTION = """\
# Speed against error

Written by `./scripts/report` from the results in [report](report). Above each part stands the command that measured it;
`./scripts/report --run` measures all of it again. [scripts/README.md](../scripts/README.md) says what each benchmark
measures and how. Scenes S1 to S5 are a stage with one lamp: a torus; the same, half sunk in the floor; a thin frame;
Menger's sponge; a stretched torus.

Of a picture x and its reference r with mean r̄, relMSE is the mean of (x − r)² / (r² + 0.01 r̄²) and MAPE that of
|x − r| / (r + 0.01 r̄), both scene-linear; FLIP is LDR-FLIP of both as sRGB, clipped.
"""

CURVES = """\
Lines are means of the seeds, bands reach from the best seed to the worst. Errors at the time that Cycles takes for its
most samples of the volume:
"""

MESH_LIGHTS = """\
A mesh light is another lamp: the same mesh, the same power, but light from its surface. It is judged by its own
converged picture, so its column tells how noisy it is, not how near it comes to the lamp; how far it is from that is in
the last two columns here.
"""

REFERENCES = """\
References are renders of other seeds, of the lamp by the paper's sampler, of the mesh light by Cycles. Their variance
is taken off relMSE; MAPE and FLIP still hold it. Means of the pictures, as a check of all of them:
"""

PAPER_SCENES = """\
The scenes of Huang et al. 2026 are not published; these are of the same kinds: a torus over a detailed mesh, a room
with five lamps of simple shapes, a kitchen with a fractal lamp, a corridor with an extruded sign. Direct light. Errors
depend on how much of a picture is hard, so ratios are compared: errors to those of projection sampling.
"""

PAPER_BSDF = """\
A ratio to BSDF samples is first of all how small the lamp is, seen from what it lights: our lamps are not the paper's.
"""

PAPER_COMPETITORS = """\
The paper's competitor is uniform sampling of the surface for its simple shapes, and of the bounding volume for its
fractal and its sign. Here that is a box, whose sides are those of the world. MAPE to that of projection sampling, of
pictures, and of pixels of as many samples at points that the camera sees, without occlusion. What sets these ratios
apart is distance: a ray's weight by projection differs less and less from that of others as the lamp gets smaller, seen from
what it lights, while the weight of a ray that grazes a surface, or passes through part of a box, stays what it is. In
pictures shadows and edges add an error that all techniques share, which brings ratios nearer to 1. How far the paper's
lamps are, and how much of its pictures is in their penumbrae, is not published.
"""


def number(value) -> str:
    """Three figures, or a dash."""
    if value is None:
        return "–"
    if isinstance(value, str):
        return value
    if 1000.0 <= abs(value) < 1e5:
        return f"{value:,.0f}"
    return f"{value:.3g}" if value == 0.0 or 1e-3 <= abs(value) < 1e5 else f"{value:.2e}"


def table(heads: list[str], rows: list[list]) -> str:
    lines = [heads, ["---"] * len(heads), *([number(value) for value in row] for row in rows)]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines) + "\n"


def listed(names: list[str]) -> str:
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"


def load(result: Result) -> str:
    """What it was measured on, and what else ran there."""
    machine = result.machine
    text = f"On {machine['cores']} cores of {machine['processor']}"
    busy = machine.get("load")
    if busy is None:
        return text + ".\n"
    text += f", with a load of {number(busy)} before the run"
    if busy <= 0.5 * machine["cores"]:
        return text + ", otherwise idle.\n"
    return (f"{text}: **other work ran beside it.**\n"
            "Times of renders are processor time by cores, which other work disturbs less than the clock.\n")


def settings(result: Result) -> str:
    rows = [row for row in result.rows if "method" in row]
    samples = sorted({row["samples"] for row in result.of(method=PEERS[0]) or rows})
    seeds = sorted({row["seeds"] for row in rows})
    return (f"{listed([str(count) for count in samples])} samples a pixel, {listed([str(count) for count in seeds])} "
            f"{'seed' if seeds == [1] else 'seeds'} a point. {load(result)}")


def heading(title: str, result: Result, about: str) -> list[str]:
    return [f"## {title}\n", f"    {result.command}\n", about]


def shown(paths: list[pathlib.Path], about: str, page: pathlib.Path) -> list[str]:
    """Links to the images that exist."""
    return [f"![{about}]({path.relative_to(page.parent).as_posix()})\n" for path in paths if path.is_file()]


# --- error against time -----------------------------------------------------------------------------------------------

def ratios(result: Result, method: str) -> list[tuple[str, str, float]]:
    """Scene, measure, and the error of a method to ours, at equal time, where both are known."""
    return [(row["scene"], label, row[f"{metric} {method}"] / row[f"{metric} {OURS}"])
            for metric, label in METRICS.items() for row in result.rows
            if row.get(f"{metric} {method}") is not None and row.get(f"{metric} {OURS}")]


def verdict(result: Result) -> str:
    """Where we lose, and by how much; where we do not, the least that is won."""
    sentences = []
    for method in (*PEERS, PAPER):
        found = ratios(result, method)
        if not found:
            continue
        who = METHODS[method][0].split(" (")[0]
        lost = [f"{scene} by {metric} ({number(ratio)} times our error)"
                for scene, metric, ratio in found if ratio < 1.0]
        scene, metric, least = min(found, key=lambda one: one[2])
        sentences.append(
            f"**{who} is better** in {listed(lost)}." if lost else
            f"{who} is better nowhere; it comes closest in {scene} by {metric}, with {number(least)} times our error.")
    return "\n".join(f"- {sentence}" for sentence in sentences) + "\n"


def equal_time(result: Result) -> str:
    """Errors at equal time, a row for each scene and measure, with ratios to ours."""
    names = (OURS, PAPER, *PEERS)
    rows = []
    for row in result.rows:
        for metric, label in METRICS.items():
            values = [row.get(f"{metric} {name}") for name in names]
            if any(value is not None for value in values):
                rows.append([row["scene"], row["seconds"], label, *values,
                             *(value / values[0] if None not in (value, values[0]) else None for value in values[1:])])
    return table(["scene", "seconds", "measure", *(METHODS[name][0] for name in names), "paper's sampler / ours",
                  "volume / ours", "mesh light / ours"], rows)


def references(result: Result) -> str:
    """What is known of the references, and of how mesh lights differ."""
    columns = {
        "scene": "scene", "reference": "variance of the reference / least relMSE judged",
        "surface_reference": "the same of the mesh light", "surface_mape": "mesh light's picture: MAPE",
        "surface_mean_ratio": "and mean, to the volume's"}
    rows = [[row[key] for key in columns] for row in result.rows if "surface_reference" in row]
    if not rows:
        return ""
    largest = math.sqrt(max(max(row[1:3]) for row in rows))
    return (f"{MESH_LIGHTS}\n{table(list(columns.values()), rows)}\nThe standard error of a reference is at most "
            f"{number(largest)} of the least error that it judges.\n{REFERENCES}")


def means(result: Result) -> str:
    """Whether the methods agree: the largest deviation of the mean of each, at the most samples of the ladder."""
    # There are renders of more samples, at equal time.
    rows, most = [], max(row["samples"] for row in result.rows if "method" not in row)
    for method, (label, *_) in METHODS.items():
        found = result.of(method=method, samples=most)
        if found:
            worst = max(found, key=lambda row: abs(row["mean_ratio"] - 1.0))
            error = worst["mean_ratio_error"]
            rows.append([label, worst["scene"], f"{100.0 * (worst['mean_ratio'] - 1.0):+.2f} %",
                         None if error is None else f"{100.0 * error:.2f} %"])
    return table(["method", "scene", "largest deviation of a picture's mean", "its standard error"], rows)


def race(result: Result, images: pathlib.Path, page: pathlib.Path) -> list[str]:
    """Section on error against time."""
    name = result.name
    strips = shown(
        sorted(images.glob(f"report_pictures_{name}_*.png")), "Renders at equal time, and their errors", page)
    return [
        *heading(f"Error against time: {LIGHT[name][0].lower()}", result, settings(result)),
        *(link for metric, label in METRICS.items() for link in shown(
            [images / f"report_{name}_{metric}.png"], f"{label} against seconds, by scene and method", page)),
        CURVES, equal_time(result), verdict(result), references(result), means(result),
        *(["Renders at equal time, one seed each, with the relative error of each pixel below:\n"] if strips else []),
        *strips]


# --- the paper --------------------------------------------------------------------------------------------------------

def efficiencies(result: Result) -> dict[str, list[float]]:
    """Of cuts to projection sampling and to the paper's sampler, by scene."""
    found = {}
    for scene in dict.fromkeys(row["scene"] for row in result.rows):
        cost = {row["method"]: row["rel_mse"] * row["seconds"] for row in result.of(scene=scene) if "method" in row}
        found[scene] = [cost[method] / cost[OURS] for method in ("PROJECTION", PAPER)]
    return found


def slower(result: Result) -> str:
    """Where cuts do not pay."""
    lost = [f"{scene} to {name} ({number(ratio)})" for scene, found in efficiencies(result).items()
            for name, ratio in zip(("projection sampling", "the paper's sampler"), found) if ratio < 1.0]
    return f"**Cuts lose** in {listed(lost)}.\n" if lost else "Cuts pay in all of them.\n"


def paper(result: Result, images: pathlib.Path, page: pathlib.Path) -> list[str]:
    """Section on the paper's scenes."""
    found = [row for row in result.rows if "competitor" in row]
    pictures = [
        [row["scene"], label, *(row[key.format(metric)] for key in (
            "paper_{}_bsdf_to_projection", "{}_bsdf_to_projection", "{}_mis_to_projection", "{}_cut_to_projection"))]
        for row in found for metric, label in METRICS.items() if metric != "rel_mse"]
    competitors = []
    for row in found:
        other = "surface" if row["competitor"] == "surface area" else "bounding"
        for name, label in (("surface", "surface"), ("bounding", "bounding box")):
            published = [row[f"paper_{metric}_competitor_to_projection"] if name == other else None
                         for metric in ("mape", "flip")]
            competitors.append([
                row["scene"], label, published[0], row.get(f"mape_{name}_to_projection"), published[1],
                row.get(f"flip_{name}_to_projection"), row.get(f"points_{name}_to_projection")])

    def of_methods(column: str) -> str:
        methods = ("BSDF", "BOUNDING", "SURFACE", "PROJECTION", PAPER, OURS)
        rows = [[row["scene"], *(next((known[column] for known in result.of(scene=row["scene"], method=method)), None)
                                 for method in methods)] for row in found]
        return table(["scene", "BSDF", "bounding box", "surface", "projection", "paper's sampler", "cuts"], rows)

    return [
        *heading("The scenes of the paper", result, settings(result)), PAPER_SCENES,
        table(["scene", "measure", "BSDF / projection: paper", "here", "paper's sampler with MIS / projection",
               "cuts / projection"], pictures),
        PAPER_BSDF, PAPER_COMPETITORS,
        table(["scene", "competitor", "MAPE / projection: paper", "here", "FLIP / projection: paper", "here",
               "MAPE / projection, at points"], competitors),
        "Equal samples hide what a sample costs. Efficiency is 1 / (relMSE × seconds), here of cuts to others:\n",
        table(["scene", "cuts / projection", "cuts / paper's sampler"],
              [[scene, *values] for scene, values in efficiencies(result).items()]),
        slower(result), "MAPE of the pictures:\n", of_methods("mape"), "Their seconds:\n", of_methods("seconds"),
        *shown(sorted(images.glob("report_pictures_paper_*.png")), "Renders of equal samples, and their errors", page)]


# --- the rest ---------------------------------------------------------------------------------------------------------

def hard(result: Result) -> list[str]:
    """Section of cases with limits."""
    rows = [row for row in result.rows if "measures" in row]
    failed = [row["case"] for row in rows if not row["holds"]]
    return [
        *heading("Hard cases", result, load(result)),
        f"**Limits that do not hold: {listed(failed)}.**\n" if failed else "All limits hold.\n",
        table(["case", "what is measured", "figure", "limit", ""],
              [[row["case"], row["measures"], row["figure"], row["limit"], "" if row["holds"] else "**fails**"]
               for row in rows])]


def figures(result: Result) -> list[str]:
    """Section of a benchmark's summary."""
    rows = [[f"`{name}`", value] for name, value in result.summary.items()]
    return [*heading(f"`bench {result.name}`", result, load(result)), table(["figure", "value"], rows)]


def overview(results: dict[str, Result]) -> list[str]:
    """Geometric means over all scenes."""
    rows = [[light, label, *(results[name].summary.get(f"{metric}_ratio_{peer.lower().replace(' ', '_')}_{key}_{kind}")
                             for peer in PEERS for kind in ("equal_time", "equal_samples"))]
            for name, (light, key) in LIGHT.items() if name in results for metric, label in METRICS.items()]
    if not rows:
        return []
    return ["Cycles' error to ours, geometric means over the scenes; above 1, ours is less:\n",
            table(["", "measure", "volume, equal time", "volume, equal samples", "mesh light, equal time",
                   "mesh light, equal samples"], rows)]


def machines(results: dict[str, Result]) -> str:
    keys = list(dict.fromkeys(key for result in results.values() for key in result.machine))
    return table(["result", *keys], [[name, *(str(result.machine.get(key, "–")) for key in keys)]
                                     for name, result in results.items()])


def write(results: dict[str, Result], images: pathlib.Path, page: pathlib.Path) -> None:
    """The page, from results and the plots that are in ``images``."""
    parts = [INTRODUCTION, *overview(results)]
    for name, result in results.items():
        if name in LIGHT:
            parts += race(result, images, page)
        elif name == "paper":
            parts += paper(result, images, page)
        else:
            parts += hard(result) if name == "hard" else figures(result)
    parts += ["## Machine\n", machines(results)]
    page.write_text("\n".join(part for part in parts if part), encoding="utf-8")
