# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A small scene for each feature of Cycles beside shader nodes, by both engines: means, parts of pictures, passes.

A scene is made for Cycles. Ours takes its settings, as it does when an artist switches the engine.
"""

from __future__ import annotations

import argparse
import functools
import pathlib
import tempfile

import host
import numpy as np

from .isolation import Isolated
from .progress import Progress
from .resume import Parts

HELP = "a small scene for each feature of Cycles, by both engines: differences of pictures and passes"
BRIEF = dict(features=["sun"])
SAMPLES, QUICK_SAMPLES, SEEDS = 64, 16, 4
MORE = 4  # times as many samples must show a difference again: few samples do not know how bright rare ones are
LIMIT = 0.01  # of the difference of means
MATTES = ("Crypto", "Noisy", "Denoising")  # beginnings of names of passes that have no mean to compare
# Before Blender 5.1, Cycles' color of rough glass ignores the roughness; ours is that of later versions.
SMOOTH_REFRACTION, CURED = ("Transmission Color", "TransCol"), (5, 1, 0)
DOCUMENT = host.REPOSITORY / "docs" / "cycles.md"
SHEET = host.REPOSITORY / "docs" / "images" / "features.jpg"
BEGIN, END = "<!-- features: made by scripts/bench features --document -->", "<!-- end of features -->"
COLUMNS = 6  # of the contact sheet


def arguments(parser) -> None:
    parser.add_argument("--features", type=lambda text: text.split(","), help="names with commas between")
    parser.add_argument(
        "--sheet", type=pathlib.Path, metavar="FILE", help="write a contact sheet: Cycles left, ours right"
    )
    parser.add_argument(
        "--document",
        action="store_true",
        help="write the table and the sheet of docs/cycles.md; with --features, their rows alone",
    )


def run(options) -> tuple[dict, list[dict]]:
    from . import feature_scenes

    names = options.features or list(feature_scenes.FEATURES)
    for name in names:
        if name not in feature_scenes.FEATURES:
            raise SystemExit(f"bench features: there is no '{name}': choose from {', '.join(feature_scenes.FEATURES)}")
    progress, parts, rows = Progress(len(names)), Parts(options), []
    shared = Isolated()
    given = argparse.Namespace(quick=options.quick, device=options.device)
    for name in names:
        progress.show(name)
        rows += parts.of(name, functools.partial(_rows, name, given, shared))
        progress.step()
    shared.close()
    if options.sheet:
        _write_sheet(options.sheet, names)
    parts.finish()
    progress.close()
    if options.document:
        _write_sheet(SHEET, feature_scenes.FEATURES)
        _write_document(rows, keep=bool(options.features))
    return summary_of(rows), rows


def summary_of(rows: list[dict]) -> dict:
    known = [row for row in rows if not row["error"]]
    return dict(
        features=len({row["feature"] for row in rows}),
        features_failed=len(rows) - len(known),
        features_over_one_percent=sum(map(differs, known)),
        features_worst_mean_difference=max((row["mean_difference"] for row in known), default=None),
    )


def complaints(rows: list[dict]) -> list[str]:
    """A sentence for each feature that could not be rendered or that differs, from the rows of all benchmarks."""
    said = []
    for row in rows:
        if "feature" in row and row["error"]:
            said.append(f"{row['feature']}: {row['error'].rstrip('.')}.")
        elif "feature" in row and differs(row):
            what, name = ("its mean", "mean") if row["mean_difference"] > LIMIT else ("a part of it", "block")
            difference = 100.0 * abs(row[f"{name}_difference"])
            said.append(f"{row['feature']}, {row['pass']}: {what} differs by {difference:.2g} %.")
    return said


def differs(row: dict) -> bool:
    """Whether a pass that was rendered differs, and nobody knows why."""
    is_known = bool(row["error"]) or row.get("is_known", False)
    return not is_known and (row["mean_difference"] > LIMIT or row["is_beyond_noise"])


def _rows(name: str, options, shared: Isolated) -> list[dict]:
    try:
        return shared.call(measure, name, options)
    except RuntimeError as error:
        return [{"feature": name, "pass": "", "error": str(error)}]


def measure(name: str, options) -> list[dict]:
    """A row for each pass of the feature that counts. Where one differs, by ``MORE`` times as many samples."""
    samples = QUICK_SAMPLES if options.quick else SAMPLES
    rows = _measured(name, options.device, samples)
    return _measured(name, options.device, MORE * samples) if any(map(differs, rows)) else rows


def _measured(name: str, device: str, samples: int) -> list[dict]:
    import bpy

    from . import feature_scenes
    from .node_pictures import CYCLES, ENGINES

    feature = feature_scenes.FEATURES[name]
    scene, made = feature_scenes.build(name), {}
    scene.cycles.samples = samples
    for scene.render.engine in ENGINES:
        bpy.ops.sdf_lights.cycles_settings_copy()
        scene.sdf_lights.device, scene.sdf_lights.guided_samples = device, False
        for seed in range(SEEDS):
            scene.cycles.seed = scene.sdf_lights.seed = seed + 1
            for key, pixels in _passes(scene, feature).items():
                made.setdefault(key, {}).setdefault(scene.render.engine, []).append(pixels)
    rows = []
    for key, pictures in made.items():
        theirs = np.array(pictures.pop(CYCLES, []))
        ours = np.array(next(iter(pictures.values()), []))
        row = {"feature": name, "pass": key, "error": ""}
        if len(theirs) and theirs.shape == ours.shape:
            row |= _difference(theirs, ours)
            row["is_known"] = key in SMOOTH_REFRACTION and bpy.app.version < CURED
            _keep(name, key, theirs.mean(0), ours.mean(0))
        elif len(theirs):
            row["error"] = f"the pass {key} is missing" if not len(ours) else f"the pass {key} has other channels"
        else:
            continue  # a pass of ours alone
        rows.append(row)
    return rows


def _passes(scene, feature) -> dict[str, np.ndarray]:
    """Passes of a render, (height, width, channels): the picture alone, unless all of them count."""
    import bpy

    from support import openexr

    settings = scene.render.image_settings
    if hasattr(settings, "media_type"):  # since 5.0, where it limits the formats
        settings.media_type = "MULTI_LAYER_IMAGE"
    settings.file_format, settings.color_depth = "OPEN_EXR_MULTILAYER", "32"
    with tempfile.TemporaryDirectory() as folder:
        scene.render.filepath = str(pathlib.Path(folder) / "picture.exr")
        bpy.ops.render.render(write_still=True)
        found = openexr.read_passes(next(pathlib.Path(folder).iterdir()))
    passes = openexr.lit(found[feature.layer or bpy.context.view_layer.name])
    return {
        name: pixels.astype(float)
        for name, pixels in passes.items()
        if name == "Combined" or (feature.all_passes and not name.startswith(MATTES))
    }


def _difference(theirs: np.ndarray, ours: np.ndarray) -> dict:
    """Of pictures (seeds, height, width, channels): the greatest difference of a channel's mean, relative to the
    brightest one, without its possible noise; and whether a part of the picture differs by more than noise."""
    from .fuzz import difference_of

    low = min(theirs.min(), 0.0)
    means = [picture.mean((1, 2)) - low for picture in (theirs, ours)]
    noise = sum(mean.var(0, ddof=1) / len(mean) for mean in means) ** 0.5
    light = max(float(means[0].mean(0).max()), 1e-9)
    found = np.abs(means[1].mean(0) - means[0].mean(0))
    parts = difference_of(theirs - low, ours - low)
    return dict(
        mean_difference=float(np.max(np.maximum(found - 2.0 * noise, 0.0)) / light),
        mean_doubt=float(noise.max() / light),
        block_difference=parts.block,
        block_errors=parts.block_errors,
        is_beyond_noise=bool(parts.is_beyond_noise),
    )


# -- contact sheet and document ----------------------------------------------------------------------------------------


def _path(name: str, key: str) -> pathlib.Path:
    folder = host.REPOSITORY / "build" / "features"
    folder.mkdir(parents=True, exist_ok=True)
    return folder / f"{name} {key}.npz"


def _keep(name: str, key: str, cycles: np.ndarray, ours: np.ndarray) -> None:
    np.savez_compressed(_path(name, key), cycles=cycles.astype(np.float32), ours=ours.astype(np.float32))


def _shown(pair: list[np.ndarray], is_light: bool) -> np.ndarray:
    """Two pictures side by side as display values; data are scaled to their range."""
    import contact_sheet

    both = np.concatenate([pixels[::-1] for pixels in pair], axis=1)
    both = both[..., :3] if both.shape[-1] >= 3 else np.repeat(both[..., :1], 3, axis=-1)
    if not is_light:
        both = both - min(both.min(), 0.0)
        finite = both[both < 1e9]  # the depth of nothing is infinite
        bright = float(np.quantile(finite, 0.98)) or float(finite.max(initial=0.0))
        both = both / max(bright, 1e-9)
    return contact_sheet.srgb(np.clip(both, 0.0, 1.0))


def _pictures(names) -> list[tuple[str, str]]:
    """Features of these names, with the passes whose pictures are on disk."""
    from . import feature_scenes

    order, found = list(feature_scenes.FEATURES), []
    for file in _path("", "").parent.glob("*.npz"):
        # One name may begin another one.
        name = max((name for name in order if file.stem.startswith(f"{name} ")), key=len, default=None)
        if name in names:
            found.append((name, file.stem.removeprefix(f"{name} ")))
    return sorted(found, key=lambda pair: (order.index(pair[0]), pair[1] != "Combined", pair[1]))


def _write_sheet(path: pathlib.Path, names) -> None:
    import contact_sheet

    from .feature_scenes.stage import SIZE

    cells = []
    for name, key in _pictures(names):
        with np.load(_path(name, key)) as kept:
            pair = [kept[picture].astype(float) for picture in ("cycles", "ours")]
        shown = _shown(pair, key == "Combined")
        cell = np.full((SIZE, 2 * SIZE, 3), 0.09)
        cell[: shown.shape[0], : shown.shape[1]] = shown[:SIZE, : 2 * SIZE]
        text = name if key == "Combined" else f"{name}: {key}"
        cells.append(np.concatenate([cell, contact_sheet.caption(text, cell.shape[1])]))
    if cells:
        contact_sheet.write(path, contact_sheet.sheet(cells, COLUMNS))


def _write_document(rows: list[dict], keep: bool) -> None:
    """Write the table of docs/cycles.md. ``keep``: other features keep their lines."""
    from . import feature_scenes

    before, begin, rest = DOCUMENT.read_text(encoding="utf-8").partition(BEGIN)
    old, end, after = rest.partition(END)
    if not (begin and end):
        raise ValueError(f"{DOCUMENT.name} lacks the marks of features.")
    lines = ["| what | scene | difference of means |", "|---|---|---|"]
    for feature in feature_scenes.FEATURES.values():
        title = f"| {feature.group}: {feature.name} |"
        own = [row for row in rows if row["feature"] == feature.name and not row["error"]]
        if own:
            worst = max(own, key=lambda row: row["mean_difference"])
            of = f" in {len(own)} passes" if len(own) > 1 else ""
            lines.append(
                f"{title} {feature.about} "
                f"| {100.0 * worst['mean_difference']:.2f} % ± {100.0 * worst['mean_doubt']:.2f} %{of} |"
            )
        elif keep:
            lines += [line for line in old.splitlines() if line.startswith(title)]
    DOCUMENT.write_text("\n".join([before + BEGIN, *lines, END]) + after, encoding="utf-8")
