# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Contact sheets of node cases and materials, Cycles left and ours right, and the table of all nodes."""

from __future__ import annotations

import hashlib
import pathlib

import contact_sheet
import host
import numpy as np

SIDE, MATERIAL_SIDE = 88, 96  # pixels a side of a picture on a sheet
COLUMNS, MOST = 8, 160  # pairs side by side, and on one sheet
DOCUMENT, DOCUMENT_COLUMNS = host.REPOSITORY / "docs" / "materials.md", 5
START, END = (
    "<!-- materials: made by ./scripts/bench nodes --parts materials --document -->",
    "<!-- end of materials -->",
)


def _path(name: str) -> pathlib.Path:
    folder = host.REPOSITORY / "build" / "node_sheets"
    folder.mkdir(parents=True, exist_ok=True)
    return folder / (hashlib.sha256(name.encode()).hexdigest()[:20] + ".npz")


def keep(name: str, cycles: np.ndarray, ours: np.ndarray) -> None:
    """Store the pictures of a case until all are there: a run may be interrupted."""
    np.savez_compressed(_path(name), cycles=cycles.astype(np.float32), ours=ours.astype(np.float32))


def join(folder: pathlib.Path, groups: dict[str, list], materials: list[str]) -> list[pathlib.Path]:
    """Write a sheet for each part of a run, from the pictures of ``keep``; long ones in several files."""
    folder.mkdir(parents=True, exist_ok=True)
    written = []
    named = {part: [case.name for case in cases] for part, cases in groups.items()} | dict(materials=materials)
    for part, names in named.items():
        side = MATERIAL_SIDE if part == "materials" else SIDE
        cells = [_cell(name, side) for name in names if _path(name).is_file()]
        for number, start in enumerate(range(0, len(cells), MOST)):
            written.append(folder / f"{part}{f'-{number + 1}' if len(cells) > MOST else ''}.png")
            contact_sheet.write(written[-1], contact_sheet.sheet(cells[start : start + MOST], COLUMNS))
    return written


def document(rows: list[dict], summary: dict) -> None:
    """Write the pictures and the table of all materials into the documents."""
    cells = [_cell(row["material"], MATERIAL_SIDE) for row in rows if _path(row["material"]).is_file()]
    contact_sheet.write(DOCUMENT.parent / "images" / "materials.jpg", contact_sheet.sheet(cells, DOCUMENT_COLUMNS))
    before, mark, rest = DOCUMENT.read_text(encoding="utf-8").partition(START)
    _, closing, after = rest.partition(END)
    if not (mark and closing):
        raise ValueError(f"{DOCUMENT.name} lacks the marks of the table of materials.")
    text = f"{before}{START}\n{materials_table(rows, summary)}{END}{after}"
    DOCUMENT.write_text(text, encoding="utf-8")


def materials_table(rows: list[dict], summary: dict) -> str:
    """Markdown: a line for each material, with its comparison with Cycles."""
    from . import machine

    about = machine.describe()
    lines = [
        f"Blender {about['blender']}, {about['processor']}, {about['cores']} cores at a load of {about.get('load', '?')}, "
        f"{rows[0].get('samples')} samples a pixel. "
        f"The worst mean difference is {_percent(summary.get('materials_worst_mean_difference'))}. Samples a second are "
        f"{summary.get('samples_ratio_to_cycles_geomean', 0.0):.2f} × Cycles' in the geometric mean, "
        f"{summary.get('samples_ratio_to_cycles_min', 0.0):.2f} × at least; Cycles' error × time is "
        f"{summary.get('error_time_ratio_to_cycles_geomean', 0.0):.2f} × ours.",
        "",
        "| material | nodes | difference of the mean | samples a second | Cycles' error × time to ours |",
        "|---|---|---|---|---|",
    ]
    for row in rows:
        name = row["material"].replace("_", " ")
        if row["mean_difference"] is None:
            lines.append(f"| {name} | {row['nodes'] or ''} | {row['error']} | | |")
        else:
            lines.append(
                f"| {name} | {row['nodes']} | {_percent(row['mean_difference'])} | {row['samples_ratio']:.2f} × "
                f"| {row['error_time_ratio']:.2f} × |"
            )
    return "\n".join(lines) + "\n"


def _cell(name: str, side: int) -> np.ndarray:
    with np.load(_path(name)) as file:
        both = [file[key].astype(float)[::-1] for key in ("cycles", "ours")]
    # The same range of values for both: from the least below 0 to the brightest, unless that is just a highlight.
    low = min(min(picture.min() for picture in both), 0.0)
    high = max(np.quantile(both[0], 0.98), 1.0)
    shown = np.concatenate([_resized((picture - low) / (high - low), side) for picture in both], axis=1)
    shown = contact_sheet.srgb(np.clip(shown, 0.0, 1.0))
    return np.concatenate([shown, contact_sheet.caption(name.replace("_", " "), shown.shape[1])])


def _resized(picture: np.ndarray, side: int) -> np.ndarray:
    """A square of the nearest pixels; every second column of a panorama."""
    rows, columns = (
        np.minimum((np.arange(side) + 0.5) * size / side, size - 1).astype(int) for size in picture.shape[:2]
    )
    return picture[rows][:, columns]


def table(rows: list[dict]) -> str:
    """Markdown: a line for each node, with the worst of its cases."""
    import bpy

    nodes: dict[str, list[dict]] = {}
    for row in rows:
        if "p99" in row:
            nodes.setdefault(row["node"], []).append(row)
    lines = [
        f"Made by `./scripts/bench nodes --table`, with Blender {bpy.app.version_string}.",
        "",
        "| node | cases | worst mean difference | worst 99th percentile | case | |",
        "|---|---|---|---|---|---|",
    ]
    for name in sorted(nodes, key=_label):
        known = [row for row in nodes[name] if row["mean_difference"] is not None]
        worst = max(nodes[name], key=lambda row: _worst(row))
        mean = max((row["mean_difference"] for row in known), default=None)
        p99 = max((row["p99"] for row in known), default=None)
        note = worst["explained"] or worst["error"]
        lines.append(
            f"| {_label(name)} | {len(nodes[name])} | {_percent(mean)} | {_percent(p99)} | {worst['case']} | {note} |"
        )
    return "\n".join(lines) + "\n"


def _worst(row: dict) -> float:
    return float("inf") if row["mean_difference"] is None else max(row["mean_difference"], row["p99"])


def _percent(part: float | None) -> str:
    return "failed" if part is None else f"{100.0 * part:.2f} %"


def _label(node: str) -> str:
    """The name in Blender's menus."""
    import bpy

    kind = getattr(bpy.types, node, None)
    return kind.bl_rna.name if kind is not None else node
