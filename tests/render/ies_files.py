# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""IES files of every kind, with values drawn at random."""

import numpy as np


def ies_file(kind, vertical, horizontal, seed=1, tilt="TILT=NONE", separator=" ", factor=2.0):
    values = np.random.default_rng(seed).uniform(1.0, 100.0, (len(horizontal), len(vertical))).round(2)
    numbers = [f"1 -1 {factor} {len(vertical)} {len(horizontal)} {kind} 2 0.1 0.2 0.3", "0.9 0.8 30"]
    rows = [vertical, horizontal, *values]
    return "\n".join(
        [
            "IESNA:LM-63-1995",
            "[TEST] made up",
            tilt,
            *numbers,
            *(separator.join(f"{entry:g}" for entry in row) for row in rows),
            "",
        ]
    )


ALL = list(range(0, 181, 20))
FILES = {
    "C, all": ies_file(1, ALL, list(range(0, 361, 45))),
    "C, symmetric about the axis": ies_file(1, ALL, [0]),
    "C, quadrant": ies_file(1, [0, 10, 30, 60, 90], [0, 20, 90], separator=", "),
    "C, half": ies_file(1, [30, 60, 120, 150], [0, 50, 100, 180]),
    "C, from 90 to 270": ies_file(1, ALL, [90, 135, 180, 225, 270]),
    "C, without 360": ies_file(1, ALL, list(range(0, 360, 60))),
    "C, upwards": ies_file(1, [90, 120, 180], [0, 90, 180, 270, 360]),
    "A, mirrored": ies_file(3, [-90, -30, 0, 45, 90], [0, 30, 60, 90]),
    "A, all": ies_file(3, [-40, 0, 40], [-90, -20, 0, 50, 90]),
    "B, mirrored": ies_file(2, [0, 20, 50, 90], [0, 30, 90]),
    "B, all": ies_file(2, [-90, -30, 0, 45, 90], [-60, 0, 60, 90]),
    "tilt": ies_file(1, ALL, [0, 90, 180, 270, 360], tilt="TILT=INCLUDE\n1\n3\n0 45 90\n1.0 0.9 0.8"),
}
BROKEN = {
    "nothing": "",
    "no tilt": "IESNA\n1 2 3",
    "ends at the tilt": "IESNA\nTILT=NONE",
    "cut off": FILES["C, all"][:200],
    "a word": FILES["C, all"].replace("0.9 0.8", "0.9 high"),
    "type": FILES["C, all"].replace(" 10 9 1 ", " 10 9 4 "),
    "counts": FILES["C, all"].replace(" 10 9 1 ", " 999999999 9 1 "),
    "negative counts": FILES["C, all"].replace(" 10 9 1 ", " -3 9 1 "),
}
