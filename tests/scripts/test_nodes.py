# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Nodes and materials beside Cycles: which cases there are, how pictures are judged, and what is told."""

import math

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")

import bench  # noqa: E402
from benchmarks import node_cases, node_limits, node_pictures, node_recipes, nodes  # noqa: E402
from benchmarks.materials import MATERIALS  # noqa: E402

RNG = np.random.default_rng(1)


def case_row(**changes) -> dict:
    return (
        dict(
            case="Math Value",
            node="ShaderNodeMath",
            place="value",
            mean_difference=0.0,
            p99=0.0,
            mean_doubt=0.0,
            p99_doubt=0.0,
            explained="",
            error="",
            warning="",
        )
        | changes
    )


def material_row(**changes) -> dict:
    return dict(material="oak", mean_difference=0.01, samples_ratio=1.0, error_time_ratio=1.0, error="") | changes


@pytest.fixture(scope="module")
def cases():
    bpy.ops.wm.read_factory_settings(use_empty=True)
    return node_cases.cases()


def test_every_node_of_this_blender_has_a_case(cases):
    covered = {case.node for case in cases} | set(node_recipes.LEFT_OUT) | node_cases.ABSTRACT
    there = {name for name in dir(bpy.types) if name.startswith("ShaderNode")}
    assert there - covered == set()


@pytest.mark.parametrize(
    "node, setting",
    [
        ("ShaderNodeMath", "operation"),
        ("ShaderNodeVectorMath", "operation"),
        ("ShaderNodeMix", "blend_type"),
        ("ShaderNodeTexNoise", "noise_type"),
        ("ShaderNodeTexVoronoi", "feature"),
        ("ShaderNodeTexSky", "sky_type"),
        ("ShaderNodeBsdfPrincipled", "subsurface_method"),
        ("ShaderNodeVolumeScatter", "phase"),
    ],
)
def test_every_mode_has_a_case(cases, node, setting):
    with node_cases.scratch() as tree:
        first = getattr(tree.nodes.new(node), setting)
    seen = set()
    for case in cases:
        if case.node == node:
            chosen = dict(case.modes) | dict(
                node_cases.settings_of(node_recipes.RECIPES[node].variants.get(case.variant, {}))
            )
            seen.add(chosen.get(setting, first))
    assert seen >= {item.identifier for item in getattr(bpy.types, node).bl_rna.properties[setting].enum_items}


def test_names_are_different_and_say_what_is_looked_at(cases):
    names = [case.name for case in cases]
    assert len(set(names)) == len(names)
    assert "Math LOGARITHM Value" in names and "TexVoronoi 2D CHEBYCHEV F2 Distance" in names


def test_a_node_that_nothing_is_known_about_is_fed_by_its_sockets(monkeypatch):
    """As one of a later Blender is."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    monkeypatch.delitem(node_recipes.RECIPES, "ShaderNodeHueSaturation")
    (case,) = (case for case in node_cases.cases() if case.node == "ShaderNodeHueSaturation")
    from scenery.materials import Graph

    socket = case.build(Graph("New"))
    assert socket.identifier == "Color"
    assert sum(item.is_linked for item in socket.node.inputs) >= 3


def test_there_are_forty_materials_of_many_nodes():
    assert len(MATERIALS) == 40


def test_equal_pictures_do_not_differ():
    picture = RNG.random((24, 24, 3))
    found = node_pictures.difference_of([picture], [picture])
    assert (found.mean, found.p99) == (0.0, 0.0)


def test_differences_are_relative_to_the_greater_of_value_and_mean():
    theirs = np.full((24, 24, 3), 2.0)
    theirs[:12] = 0.0
    assert node_pictures.difference_of([theirs + 0.01], [theirs]).mean == pytest.approx(0.5 * (0.01 / 2.0 + 0.01 / 1.0))


def test_a_black_picture_may_be_a_little_off():
    black = np.zeros((24, 24, 3))
    assert node_pictures.difference_of([black + 1e-5], [black]).mean == pytest.approx(1e-5 / node_pictures.DARK)


def test_noise_is_no_difference_but_a_difference_is_found_in_noise():
    shade = np.full((64, 64, 3), 0.5)

    def noisy(offset):
        return [shade + offset + 0.05 * RNG.standard_normal(shade.shape) for _ in range(node_pictures.SEEDS)]

    same = node_pictures.difference_of(noisy(0.0), noisy(0.0))
    assert same.mean - same.mean_doubt < node_limits.LIMIT and same.p99 - same.p99_doubt < node_limits.LIMIT
    off = node_pictures.difference_of(noisy(0.025), noisy(0.0))
    assert off.mean - off.mean_doubt > node_limits.LIMIT


def test_cases_are_rendered_again_while_noise_leaves_them_in_doubt():
    shade = np.full((32, 32, 3), 0.5)

    def doubtful(noise, offset):
        pictures = {
            engine: [shade + shift + noise * RNG.standard_normal(shade.shape) for _ in range(node_pictures.SEEDS)]
            for engine, shift in ((node_pictures.CYCLES, 0.0), (node_pictures.OURS, offset))
        }
        return node_pictures.Pair(node_cases.Case("ShaderNodeValue"), pictures).doubtful

    assert not doubtful(0.02, 0.0)  # noise is small, and all there is
    assert doubtful(0.5, 0.0)  # noise is coarse
    assert doubtful(0.02, 0.006)  # there is something, near the limit
    assert not doubtful(0.02, 0.1)  # it is far over the limit


def test_summary_of_nodes():
    rows = [
        case_row(),
        case_row(mean_difference=0.02),
        case_row(p99=0.5, explained="another model"),
        case_row(mean_difference=0.02, mean_doubt=0.015),
        case_row(mean_difference=None, p99=None, error="It stopped."),
    ]
    assert nodes.summary_of(rows) == dict(nodes=1, node_cases=5, nodes_over_one_percent=2, nodes_explained=1)


def test_summary_of_materials():
    rows = [
        material_row(),
        material_row(mean_difference=0.03, samples_ratio=0.25, error_time_ratio=4.0),
        material_row(mean_difference=None),
    ]
    found = nodes.summary_of(rows)
    assert found == pytest.approx(
        dict(
            materials=3,
            materials_failed=1,
            materials_worst_mean_difference=0.03,
            samples_ratio_to_cycles_geomean=0.5,
            samples_ratio_to_cycles_min=0.25,
            error_time_ratio_to_cycles_geomean=2.0,
        )
    )


def test_what_differs_is_named_with_what_our_engine_said():
    rows = [
        case_row(),
        case_row(case="Gamma Color", mean_difference=0.5, p99=0.7, warning="Gamma is not supported."),
        case_row(case="Sky", p99=0.5, explained="another model"),
        material_row(),
        dict(ratio="of another benchmark"),
    ]
    assert nodes.complaints(rows) == ["Gamma Color: differs by 50 %, 99th percentile 70 %. Gamma is not supported."]


def test_arguments():
    options = bench.parse(["nodes", "--parts", "values,materials", "--like", "Oak, math", "--quick"])
    assert options.parts == ["values", "materials"] and options.like == ["oak", "math"] and options.quick
    assert bench.options_of("nodes", bench.parse(["all", "--quick"])).parts == ["values"]
    assert bench.parse(["nodes"]).parts is None


def test_a_part_that_is_not_known_gets_the_known_ones(capsys):
    with pytest.raises(SystemExit):
        bench.parse(["nodes", "--parts", "lights"])
    assert "choose from values, lit, worlds, materials" in capsys.readouterr().err


def test_the_table_has_a_line_for_each_node():
    from benchmarks import node_sheets

    text = node_sheets.table(
        [
            case_row(),
            case_row(case="Math SINE Value", mean_difference=0.02, p99=0.03),
            case_row(case="Gamma Color", node="ShaderNodeGamma", mean_difference=None, p99=None),
        ]
    )
    assert "| Math | 2 | 2.00 % | 3.00 % | Math SINE Value |  |" in text
    assert "| Gamma | 1 | failed | failed |" in text


def test_a_node_that_stops_our_engine_is_found_and_the_others_are_compared(monkeypatch):
    """The engine refuses one material of a grid of five."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    cases = [
        case
        for case in node_cases.cases()
        if case.node == "ShaderNodeSeparateXYZ" or case.name == "Value Value" or case.name == "RGB Color"
    ]
    from benchmarks import pictures

    def render():
        if bpy.context.scene.render.engine != "CYCLES" and any(
            slot.material.name == "RGB Color" for thing in bpy.data.objects for slot in thing.material_slots
        ):
            raise RuntimeError("Error: there is no colour\n")
        size = bpy.context.scene.render
        return pictures.Picture(np.ones((size.resolution_y, size.resolution_x, 3)), 0.0, 0.0)

    monkeypatch.setattr(pictures, "render", render)
    pairs = {pair.case.name: pair for pair in node_pictures.render_all(cases, 1)}
    assert len(pairs) == 5 and pairs["RGB Color"].error == "there is no colour"
    assert all(pair.difference().mean == 0.0 for name, pair in pairs.items() if name != "RGB Color")
    assert (
        math.isclose(pairs["Value Value"].row()["light_ours"], 1.0)
        and pairs["RGB Color"].row()["mean_difference"] is None
    )


def test_a_case_that_ends_the_process_is_found_and_the_others_are_compared(monkeypatch):
    from types import SimpleNamespace

    from benchmarks import node_rows

    cases = [
        case
        for case in node_cases.cases()
        if case.node in {"ShaderNodeSeparateXYZ", "Light of a color", "World of noise"}
        or case.name in {"Value Value", "RGB Color"}
    ]
    runs = []

    def run(batch, wish, rows, told):
        runs.append(len(batch))
        for group in node_pictures.groups(batch):
            if any(case.name in {"RGB Color", "World of noise"} for case in group):
                return "The process ended with SIGSEGV"
            rows |= {case.name: node_pictures.Pair(case).row() for case in group}
        return "The process ended with code 0"

    monkeypatch.setattr(node_rows, "_run", run)
    options = SimpleNamespace(device="CPU", fresh=False, sheets=None)
    rows = node_rows.rows_of(cases, 1, 1, options, lambda text: None)
    assert [row["case"] for row in rows] == [case.name for case in cases] and len(rows) == 7
    assert {row["case"]: row["error"] for row in rows if row["error"]} == {
        "RGB Color": "The process ended with SIGSEGV.",
        "World of noise": "The process ended with SIGSEGV.",
    }
    assert max(runs[1:]) < len(cases)


def test_the_process_of_cases_gives_their_rows_and_tells_how_it_ended():
    from benchmarks import node_rows

    rows = {}
    wish = dict(samples=1, rounds=1, device="there is none", fresh=False, sheets=False)
    ended = node_rows._run([SimpleCase("RGB Color")], wish, rows, lambda text: None)
    assert ended.startswith("The process ended with ") and not rows


class SimpleCase:
    def __init__(self, name):
        self.name = name


def test_differences_beside_jumps_are_explained():
    case = node_cases.Case("ShaderNodeValue")
    theirs = np.ones((32, 32, 3))
    ours = theirs.copy()
    ours[3, :20] = 2.0
    pair = node_pictures.Pair(case, {node_pictures.CYCLES: [theirs], node_pictures.OURS: [ours]})
    assert nodes.over(pair.row()) and pair.row()["explained"] == ""
    pair.change = np.zeros_like(theirs)
    assert pair.row()["explained"] == ""
    pair.change[3, :20] = 1.0
    assert pair.row()["explained"] == node_pictures.JUMPS
