# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The recipes of docs/python.md run, each as a script of its own."""

import pathlib
import re

import pytest

from sdf_lights import jit

TEXT = (pathlib.Path(__file__).resolve().parents[1] / "docs" / "python.md").read_text(encoding="utf-8")
RECIPES = dict(re.findall(r"^## (.+?)\n.*?^```python\n(.*?)^```", TEXT, re.MULTILINE | re.DOTALL))

pytestmark = pytest.mark.skipif(not jit.AVAILABLE, reason="Numba is not installed")


def test_there_are_ten():
    assert len(RECIPES) == 10


@pytest.mark.parametrize("title", RECIPES)
def test_recipe(title, tmp_path, monkeypatch, request):
    if "OpenVDB" in title:
        request.getfixturevalue("openvdb")
    monkeypatch.chdir(tmp_path)
    exec(compile(RECIPES[title], f"docs/python.md, {title}", "exec"), {"__name__": "__main__"})
