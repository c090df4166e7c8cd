# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""IES files: intensities as in Cycles, in every direction; values at the angles of the file; errors in words."""

import math

import numpy as np
import pytest

from sdf_lights.render import ies
from tests.render.ies_files import ALL, BROKEN, FILES, ies_file
from tests.render.sky.panoramas import FULL, blender_version, panoramas

WATTS = 4.0 * math.pi / 177.83


def intensities(text, directions, repeats_ends=True):
    values = ies.numbers_of(text, repeats_ends)
    return np.array([ies.intensity(values, 0, tuple(d)) for d in np.asarray(directions, float)])


def test_as_in_cycles(tmp_path):
    cases = [["ShaderNodeTexIES", {"mode": "INTERNAL", "ies": text}, FULL] for text in FILES.values()]
    for name, (directions, theirs) in zip(FILES, panoramas(cases, tmp_path)):
        ours = intensities(FILES[name], directions, blender_version() >= (5, 0))
        assert theirs.max() > 0.0
        np.testing.assert_allclose(ours, theirs[:, 0], rtol=1e-4, atol=1e-4 * theirs.max(), err_msg=name)


def test_broken_files_as_in_cycles(tmp_path):
    # It reserves memory for as many angles as a file names, so not those of wrong counts.
    names = [name for name in BROKEN if "counts" not in name]
    cases = [["ShaderNodeTexIES", {"mode": "INTERNAL", "ies": BROKEN[name]}, (*FULL[:4], 4, 2)] for name in names]
    for name, (_, theirs) in zip(names, panoramas(cases, tmp_path)):
        np.testing.assert_allclose(theirs, ies.WITHOUT_FILE, err_msg=name)


@pytest.mark.parametrize("name", BROKEN)
def test_a_broken_file_is_told_of(name):
    with pytest.raises(ies.IESError, match="^(it|its|nothing) "):
        ies.numbers_of(BROKEN[name])


def test_the_values_of_the_file_are_met():
    text = ies_file(1, ALL, list(range(0, 361, 45)), factor=1.0)
    values = np.array([[float(entry) for entry in line.split()] for line in text.splitlines()[7:]])
    vertical, horizontal = np.radians(ALL[1:-1]), np.radians(np.arange(0, 360, 45) + 1e-7)
    for row, turn in enumerate(horizontal):
        # Down is −z; the turn is from −y to −x.
        d = np.stack([-np.sin(vertical) * np.sin(turn), -np.sin(vertical) * np.cos(turn), -np.cos(vertical)], -1)
        np.testing.assert_allclose(intensities(text, d), 0.9 * 0.8 * WATTS * values[row, 1:-1], rtol=1e-4)


def test_nothing_shines_beyond_the_angles_of_the_file():
    text = FILES["C, quadrant"]
    assert intensities(text, [(0.3, 0.2, 0.1)]) == 0.0
    assert intensities(text, [(0.3, 0.2, -0.1)]) > 0.0


def test_odd_directions_and_tables_are_harmless():
    odd = [(0.0, 0.0, 0.0), (0.0, 0.0, 1.0), (0.0, 0.0, -1.0), (0.0, -1.0, 0.0), (1e200, 0.0, 0.0)]
    texts = list(FILES.values()) + [ies_file(1, [90], [0]), ies_file(1, [0, 0, 90, 90], [0, 0, 360])]
    for text in texts:
        found = intensities(text, odd)
        assert (found >= 0.0).all() and np.isfinite(found).all()
