# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Arguments of the benchmarks: what they become, and what is said where they are wrong."""

import pathlib
import subprocess
import sys

import pytest

pytest.importorskip("bpy")

import bench
from benchmarks import scaling


def test_lists_are_of_known_names():
    options = bench.parse(["lamps", "--only", "S2,gloss", "--samplers", "MIS,BSDF", "--bounces", "4", "--no-cycles"])
    assert options.only == ["S2", "gloss"] and options.samplers == ["MIS", "BSDF"]
    assert options.bounces == 4 and not options.cycles


@pytest.mark.parametrize("arguments", [[], *([name] for name in (*bench.benchmarks.NAMES, "all"))], ids="".join)
def test_every_benchmark_has_help(arguments, capsys):
    with pytest.raises(SystemExit) as left:
        bench.parse([*arguments, "--help"])
    assert left.value.code == 0 and "usage: bench" in capsys.readouterr().out


def test_all_has_the_arguments_of_each():
    options = bench.parse(["all", "--quick"])
    assert options.samplers == ["CUT", "MIS"] and options.curves == list(scaling.CURVES)
    assert len(options.modules) > 4


def test_all_of_them_quick_are_parts_of_each_unless_something_else_is_given():
    options = bench.parse(["all", "--quick"])
    assert bench.options_of("scaling", options).curves == scaling.BRIEF["curves"] != options.curves
    assert bench.options_of("lamps", options).only == ["S1"] and bench.options_of("cycles", options).only == ["S4"]
    assert bench.options_of("lamps", bench.parse(["all", "--quick", "--only", "S2"])).only == ["S2"]
    assert bench.options_of("scaling", bench.parse(["all"])).curves == options.curves
    assert bench.options_of("scaling", bench.parse(["scaling", "--quick"])).curves == options.curves


@pytest.mark.parametrize(
    "arguments, sentence",
    [
        (["lamps", "--only", "S1,S9"], "there is no 'S9': choose from S1, S2"),
        (["lamps", "--samplers", "cut"], "there is no 'cut': choose from CUT"),
        (["scaling", "--curves", "doors"], "there is no 'doors': choose from lamps"),
    ],
)
def test_a_name_that_is_not_known_gets_the_known_ones(arguments, sentence, capsys):
    with pytest.raises(SystemExit):
        bench.parse(arguments)
    assert sentence in capsys.readouterr().err


def test_it_starts_as_a_program():
    program = pathlib.Path(bench.__file__)
    run = subprocess.run([sys.executable, program, "all", "--help"], capture_output=True, text=True, cwd=program.root)
    assert run.returncode == 0 and "usage: bench" in run.stdout, run.stderr
