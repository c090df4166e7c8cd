# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The report: its sentences follow from its numbers, whatever they are."""

import dataclasses
import hashlib
import json
import re

import numpy as np
import pytest
from reporting import page, prose, race, records, results, sampling_sections, sections

DOCS = results.REPOSITORY / "docs"

MACHINE = dict(processor="Some Processor", cores=2, load=0.1)


def raced(volume: float = 0.5, mesh: float | None = 0.1, machine=MACHINE, flip: bool = True) -> results.Result:
    """Two scenes; errors of Cycles in S2 are those given, where ours are 0.01."""
    rows = []
    for scene in ("S1", "S2"):
        errors = {"CUT": 0.01, "MIS": 0.02, "Cycles volume": 0.5, "Cycles mesh light": 0.1}
        if scene == "S2":
            errors |= {"Cycles volume": volume, "Cycles mesh light": mesh}
        metrics = ("rel_mse", "mape", "flip") if flip else ("rel_mse", "mape")
        rows.append(
            dict(
                scene=scene,
                bounces=0,
                seconds=1.0,
                samples=64,
                reference=0.05,
                surface_reference=0.02,
                surface_mape=0.2,
                surface_mean_ratio=0.94,
            )
            | {f"{metric} {name}": value for metric in metrics for name, value in errors.items()}
        )
        for method, error in errors.items():
            for samples in (4, 16, 64):
                row = dict(
                    scene=scene,
                    bounces=0,
                    method=method,
                    samples=samples,
                    seeds=8,
                    seconds=samples / 64.0,
                    clock=1.0,
                    mean_ratio=1.001,
                    mean_ratio_error=0.001,
                )
                value = (error or 1.0) * 64.0 / samples
                for metric in ("rel_mse", "mape", "flip"):
                    known = metric in metrics
                    row |= {
                        metric: value if known else None,
                        f"{metric}_low": 0.9 * value if known else None,
                        f"{metric}_high": 1.1 * value if known else None,
                    }
                rows.append(row)
    return results.Result("cycles_direct", "./scripts/bench cycles --bounces 0", {}, rows, machine)


def test_where_we_lose_is_said():
    text = race.verdict(raced(mesh=0.004))
    assert "mesh light is better** in S2 by relMSE (0.4 times our error)" in text
    assert "emission volume is better nowhere" in text
    assert "is better nowhere" not in race.verdict(raced(volume=0.001, mesh=0.001)).split("paper's sampler")[0]


def test_what_is_not_known_is_a_dash():
    text = race.equal_time(raced(mesh=None, flip=False))
    assert "FLIP" not in text
    assert re.search(r"\| S2 .*relMSE .*\| – \|\n", text)


def test_preparation_is_told_and_left_out():
    """Renders of the fixture take 1 s for 64 samples and nothing before; here Cycles takes half a second more."""
    result = raced()
    for row in result.rows:
        if row.get("method") == "Cycles volume":
            row["seconds"] += 0.5
    text = race.preparation(result)
    assert "| S1 | 1 | 0 | 0 | 0.5 | 0 | 2 | 50 | 10 |" in text
    assert race.preparation(results.Result("cycles_direct", "", {}, [result.rows[0]], MACHINE)) == ""


def test_a_busy_machine_is_told():
    assert "otherwise idle" in prose.load(raced())
    assert "other work ran beside it" in prose.load(raced(machine=MACHINE | dict(load=4.0)))


def test_limits_that_do_not_hold_are_named():
    rows = [
        dict(case="stretch", measures="error of rays", figure=0.5, limit=0.1, holds=False),
        dict(case="shells", measures="wrong crossings", figure=0.0, limit=0.0, holds=True),
        dict(case="broken", measures="time", figure=None, limit=None, holds=False, error="it stopped"),
    ]
    text = "\n".join(sections.hard(results.Result("hard", "./scripts/bench hard", {}, rows, MACHINE)))
    assert "**Limits that do not hold: stretch and broken.**" in text
    assert "| stretch | error of rays | 0.5 | 0.1 | **fails** |" in text
    assert "| broken | time | – | – | **fails** |" in text
    assert "All limits hold.\n" in sections.hard(results.Result("hard", "", {}, rows[1:2], MACHINE))


def test_hard_cases_say_how_certain_and_how_slow_they_are():
    rows = [
        dict(
            case="shells",
            kind="rays",
            measures="wrong",
            figure=0.0,
            limit=0.0,
            holds=True,
            rays=20000.0,
            too_fine_to_judge=0.25,
        ),
        dict(
            case="noise",
            kind="cost",
            measures="time",
            figure=5.1,
            limit=10.0,
            holds=True,
            hard_ns_per_sample=510.0,
            easy_ns_per_sample=100.0,
            published_time_ratio=2.5,
        ),
    ]
    text = "\n".join(sections.hard(results.Result("hard", "", {}, rows, MACHINE)))
    assert "| shells | wrong | 0 | 0 |  | 20,000 | 0.25 |" in text
    assert "| noise | 510 | 100 | 5.1 | 2.5 |" in text


def test_what_was_not_measured_is_told():
    hard = results.Result("hard", "", {}, [], MACHINE)
    text = "".join(page.lacking({"cycles_direct": raced(flip=False), "hard": hard}))
    assert (
        "Not measured: cycles_bounces, corridor, kinds, grids, paper, estimators, intervals, throughput and scaling."
        in text
    )
    assert "FLIP of `cycles_direct` was not measured." in text
    assert page.lacking(dict.fromkeys(results.RUNS, raced())) == []


def test_hard_cases_stand_under_their_kind():
    rows = [
        dict(case=name, kind=kind, measures="what", figure=0.0, limit=1.0, holds=True)
        for name, kind in (("far", "light"), ("leak", "faces"), ("new", "unheard of"))
    ]
    parts = sections.hard(results.Result("hard", "", {}, rows, MACHINE))
    titles = [part for part in parts if part.startswith("###")]
    assert titles == [f"### {sections.HARD['light'][0]}\n", f"### {sections.HARD['faces'][0]}\n", "### Others\n"]


def test_every_kind_of_hard_case_is_told():
    pytest.importorskip("bpy")
    from benchmarks.hard_cases import CASES

    assert {case.kind for case in CASES.values()} == set(sections.HARD)


@pytest.mark.parametrize("variance, said", [(0.0101, "more than a tenth"), (0.0099, "at most a tenth")])
def test_references_that_are_not_good_enough_are_named(variance, said):
    sentence = prose.reached([dict(scene="S1", reference=0.005), dict(scene="S2", reference=variance)])
    assert said in sentence
    assert "S1" not in sentence and ("S2 (0.1" in sentence) == (variance > 0.01)


def crossings(wrong: float) -> results.Result:
    rules = ("evaluations", "published_evaluations", "published_coarse_evaluations", "spheres_evaluations")
    rows = [
        dict(
            case=name,
            certified=True,
            smooth=smooth,
            rays=1000,
            wrong=wrong,
            published_wrong=0.0,
            published_coarse_wrong=0.25,
            spheres_wrong=0.0,
            **dict.fromkeys(rules, 20.0),
        )
        for name, smooth in (("ring", True), ("sponge", False))
    ]
    rows += [dict(spread="as dense", operation="union", primitives=n, ns_per_ray=100.0 * n) for n in (1, 10)]
    return results.Result("intervals", "./scripts/bench intervals", dict(rays_certified=2000), rows, MACHINE)


def growth() -> results.Result:
    rows = [
        dict(curve="lamps", count=count, made_by="CPU", samples=16.0, seconds=1e-3 * count, each=1e-3, start=start)
        for count, start in ((1, 0.1), (10, -1e-4))
    ]
    return results.Result("scaling", "./scripts/bench scaling", dict(time_ratio_1000_to_10_lamps=10.0), rows, MACHINE)


def test_crossings_and_scaling_have_a_plot_and_their_tables(tmp_path):
    pytest.importorskip("matplotlib")
    import report

    found = {"intervals": crossings(0.0), "scaling": growth()}
    images = tmp_path / "images"
    report.draw(found, images, tmp_path)
    text = page.text(found, images, tmp_path / "report.md")
    assert "no ray has a wrong number of crossings" in text and "| ring | 20 | 20 | 20 | 20 | 1 |" in text
    assert "| sponge | 0 | 0 | 0.25 | 0 |" in text
    assert "| lamps | 10 | 16 | 0.001 | 0.01 | -1.00e-04 |" in text
    links = re.findall(r"\]\((images/[^)]+)\)", text)
    assert links == ["images/report_intervals.png", "images/report_scaling.png"]
    assert all((tmp_path / link).is_file() for link in links)


def test_rays_that_are_wrong_are_told(tmp_path):
    parts = sections.intervals(crossings(0.5), tmp_path, tmp_path / "page.md")
    assert any("rays are wrong in ring and sponge" in part for part in parts)


def test_rates_stand_beside_those_of_cycles():
    rows = [
        dict(engine=engine, bounces=0, surfaces=kind, samples_per_second=rate, slowest=rate, fastest=rate, mean=0.5)
        for kind, engine, rate in (
            ("plain", "SDF Lights", 300.0),
            ("plain", "Cycles", 100.0),
            ("coated", "SDF Lights", 50.0),
            ("coated", "Cycles", 25.0),
        )
    ] + [dict(start="F12 again", seconds=0.5)]
    text = "\n".join(sections.throughput(results.Result("throughput", "./scripts/bench throughput", {}, rows, MACHINE)))
    assert "| 0 | plain | SDF Lights | 300 | 300 | 300 | 3 | 0.5 |" in text
    assert "| 0 | coated | SDF Lights | 50 | 50 | 50 | 2 | 0.5 |" in text and "| F12 again | 0.5 |" in text


def test_samplers_at_points_stand_side_by_side():
    rows = [
        dict(case="torus, above", group="far", technique=name, ns=ns, error_64=error, gain_64=4.0, gain_256=5.0)
        for name, ns, error in (("mis", 100.0, 0.1), ("cut", 200.0, 0.01))
    ]
    text = "\n".join(
        sampling_sections.estimators(results.Result("estimators", "./scripts/bench estimators", {}, rows, MACHINE))
    )
    assert "| torus, above | far | 0.1 | 0.01 | 100 | 200 | 4 | 5 |" in text


def test_what_results_come_to_is_said_where_all_of_it_is_known():
    known = dict(hard_cases=74, hard_cases_failed=1)
    found = {
        "hard": results.Result("hard", "", known, [], MACHINE),
        "scaling": results.Result("scaling", "", dict(time_ratio_1000_to_10_lamps=4.0), [], MACHINE),
    }
    assert page.sentences(found) == ["- Hard cases: 1 of 74 limits do not hold.\n"]
    assert page.sentences({}) == []


def test_scenes_where_the_papers_sampler_is_better_are_named(tmp_path):
    def scene(name, ratio, worst):
        paper = "MIS / CUT"
        return {
            "scene": name,
            "bounces": 0,
            "seconds": 0.5,
            paper: ratio,
            f"worst_999 {paper}": 1.5,
            f"worst_mean {paper}": worst,
            f"worst {paper}": 3.0,
            "MIS guided / CUT": 1.25,
            "reference": 0.01,
        }

    def section(*rows):
        return "\n".join(
            sampling_sections.lamps(results.Result("lamps", "./scripts/bench lamps", {}, [*rows], MACHINE))
        )

    text = section(scene("S1", 4.0, 2.0) | {"cycles": 500.0}, scene("haze", 0.9, 0.8))
    assert "| S1 | 0 | 0.5 | 4 | 1.25 | 1.5 | 2 | 3 | 500 | – | – | 0.1 |" in text
    assert (
        "better** in haze with 0 bounces by relMSE (0.9 times our error) and haze with 0 bounces by the greatest"
        in text
    )
    assert "better nowhere" in section(scene("S1", 4.0, 2.0))
    again = results.Result("lamps_again", "./scripts/bench lamps", {}, [scene("S1", 4.0, 2.0), dict(seeds=20)], MACHINE)
    assert "## Some scenes with 20 seeds" in page.text({"lamps_again": again}, tmp_path, tmp_path / "report.md")


def test_numbers_have_three_figures():
    assert [prose.number(value) for value in (1234.5, 12.345, 0.012345, 1.2e-7, 0.0, None, "text")] == [
        "1,234",
        "12.3",
        "0.0123",
        "1.20e-07",
        "0",
        "–",
        "text",
    ]


def test_the_page_has_its_command_beside_every_figure(tmp_path):
    pytest.importorskip("matplotlib")  # ./scripts/report installs it
    import report

    images, kept = tmp_path / "docs" / "images", tmp_path / "kept"
    kept.mkdir()
    pictures = {name: np.full((8, 8, 3), 0.5) for name in ("CUT", "Cycles volume", "Cycles mesh light", "reference")}
    np.savez(kept / "S1 0.npz", **pictures)
    found = {
        "cycles_direct": raced(),
        "throughput": results.Result(
            "throughput", "./scripts/bench throughput", dict(samples_per_second_ratio_to_cycles=2.0), [], MACHINE
        ),
    }
    report.draw(found, images, kept)
    text = page.text(found, images, tmp_path / "docs" / "report.md")
    for line in (
        "    ./scripts/bench cycles --bounces 0",
        "    ./scripts/bench throughput",
        "| `samples_per_second_ratio_to_cycles` | 2 |",
        "## Error against time: direct light",
    ):
        assert line in text
    links = re.findall(r"\]\((images/[^)]+)\)", text)
    assert len(links) == 4 and all((tmp_path / "docs" / link).is_file() for link in links)


def test_a_metric_that_nothing_is_known_of_has_no_plot(tmp_path):
    pytest.importorskip("matplotlib")
    from reporting import plots

    assert not plots.against_time(raced(flip=False), "flip", tmp_path / "plot.png")
    assert not (tmp_path / "plot.png").exists()


def test_a_plot_of_other_results_does_not_stay(tmp_path):
    pytest.importorskip("matplotlib")
    import report

    for flip in (True, False):
        report.draw({"cycles_direct": raced(flip=flip)}, tmp_path, tmp_path)
        assert (tmp_path / "report_cycles_direct_flip.png").is_file() == flip
    assert (tmp_path / "report_cycles_direct_mape.png").is_file()


def test_the_committed_page_and_images_are_of_the_committed_results():
    found = results.read()
    assert page.text(found, DOCS / "images", DOCS / "report.md") == (DOCS / "report.md").read_text(encoding="utf-8")
    unknown, others = records.compared(found, DOCS / "images")
    assert not others, "draw them again: ./scripts/report"
    # Only renders that were not measured with their hashes may be of nobody knows what.
    for name in unknown:
        result, scene = re.fullmatch(r"report_pictures_(.+)_([^_]+)\.png", name).groups()
        assert not found[result].renders(scene), f"{name}: draw it again, where its renders are"


def test_images_say_what_they_were_drawn_from(tmp_path, capsys):
    pytest.importorskip("matplotlib")
    import report

    pictures = {name: np.full((8, 8, 3), 0.5) for name in ("CUT", "Cycles volume", "reference")}
    for scene in ("S1", "S2"):
        np.savez(tmp_path / f"{scene} 0.npz", **pictures)
    result = raced()
    result.rows[0]["renders"] = hashlib.sha256((tmp_path / "S1 0.npz").read_bytes()).hexdigest()
    report.draw({result.name: result}, tmp_path, tmp_path)
    one, two = (tmp_path / f"report_pictures_cycles_direct_{scene}.png" for scene in ("S1", "S2"))
    assert records.read(one) == records.read(tmp_path / "report_cycles_direct_mape.png") == records.of(result)
    assert records.read(two) is None
    assert records.compared({result.name: result}, tmp_path) == ([two.name], [])
    text = page.drawn({result.name: result}, tmp_path)
    assert two.name in text and one.name not in text

    # Of other numbers than the images, and with other renders than those that are kept.
    later = dataclasses.replace(result, rows=[row | dict(seconds=2.0) for row in result.rows])
    later.rows[0]["renders"] = "those of another run"
    assert one.name in records.compared({result.name: later}, tmp_path)[1]
    assert "**These are of other results:**" in page.drawn({result.name: later}, tmp_path)
    report.draw({result.name: later}, tmp_path, tmp_path)
    assert "S1 0.npz holds other renders" in capsys.readouterr().err
    assert records.compared({result.name: later}, tmp_path) == ([two.name], [one.name])


def test_the_hash_of_a_result_is_that_of_what_was_measured():
    assert raced().digest == raced().digest
    assert raced().digest != raced(volume=0.4).digest


def test_results_are_read_in_the_order_of_the_page(tmp_path):
    for name in ("throughput", "other", "cycles_direct"):
        (tmp_path / f"{name}.json").write_text(json.dumps(dict(command="c", summary={}, rows=[], machine={})))
    (tmp_path / "unfinished.json").write_text("{}")
    assert list(results.read(tmp_path)) == ["cycles_direct", "throughput", "other"]


def test_every_run_is_a_call_that_bench_understands():
    pytest.importorskip("bpy")
    import bench

    for name, arguments in results.RUNS.items():
        assert bench.parse(arguments).name == arguments[0], name


def test_a_summary_shows_the_same_with_less():
    pytest.importorskip("matplotlib")
    import report
    from reporting import summaries

    result = raced()
    result.rows[0]["renders"] = "of a file"
    for row in result.rows:
        row["unread"] = 1.0
    summary = summaries.summarised(result, report.draw)
    shown = [page.text({result.name: one}, DOCS, DOCS / "report.md") for one in (result, summary)]
    assert shown[0] == shown[1]
    assert summary.digest == result.digest and summary.renders("S1") == {"of a file"}
    assert len(summary.rows) == len(result.rows) and not any("unread" in row for row in summary.rows)


def test_a_summary_is_read_as_it_was_written(tmp_path):
    summary = dataclasses.replace(raced(), full_digest="a hash")
    results.write(summary, tmp_path)
    assert results.read(tmp_path) == {summary.name: summary}


def test_the_repository_keeps_summaries_alone():
    assert all(result.full_digest for result in results.read().values()), "./scripts/report --keep writes them"
