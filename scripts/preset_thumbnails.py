# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Renders the pictures of the lamp presets, which Blender shows when one is chosen, into their folder."""

from __future__ import annotations

import argparse
import pathlib
import sys

REPOSITORY = pathlib.Path(__file__).resolve().parent.parent
sys.path[:0] = [str(REPOSITORY), str(REPOSITORY / "scripts"), str(REPOSITORY / "sdf_lights" / "blender")]

import contact_sheet  # noqa: E402
from presets import presets  # noqa: E402  (the package around it needs Blender)

from sdf_lights.sdf import emission_presets  # noqa: E402
from sdf_lights.sdf.builtin_colors import blackbody  # noqa: E402
from sdf_lights.sdf.emission import Emission, EmissionExpression  # noqa: E402
from sdf_lights.sdf.expression import evaluate  # noqa: E402


def preset_emission(preset) -> Emission:
    known = emission_presets.presets().get(preset.emission)
    expression = EmissionExpression(known.text if known else preset.emission)
    return expression.emission(
        {name: tuple(value) if isinstance(value, list) else value for name, value in preset.emission_values.items()}
    )


def main(arguments: list[str]) -> None:
    parser = argparse.ArgumentParser(prog="preset_thumbnails", description=__doc__)
    parser.add_argument("names", nargs="*", metavar="PRESET", help="names of presets; default: all")
    parser.add_argument("--samples", type=int, default=24, help="samples per pixel (24)")
    parser.add_argument("--size", type=int, default=96, help="width and height in pixels (96)")
    options = parser.parse_args(arguments)
    known = presets()
    for name in options.names:
        if name not in known:
            parser.error(f"there is no preset {name!r}: choose from {', '.join(known)}")
    for name in options.names or known:
        preset = known[name]
        print(name, file=sys.stderr)
        color = blackbody(preset.temperature) if preset.temperature else preset.color
        image = contact_sheet.picture(
            evaluate(preset.expression), color, options.size, options.size, options.samples, preset_emission(preset)
        )
        contact_sheet.write(preset.picture, image)


if __name__ == "__main__":
    main(sys.argv[1:])
