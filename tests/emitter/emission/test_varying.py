# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Emission that varies: its integral over volumes and along rays against closed forms, the power far away, its
cells."""

import math

import numpy as np
import pytest

from sdf_lights.emitter import lamps
from sdf_lights.emitter.arrays import Lamps
from sdf_lights.emitter.building import build, remarks
from sdf_lights.emitter.emission.varying import place_point
from sdf_lights.emitter.tree import interior, moments
from sdf_lights.jit import kernel
from sdf_lights.sdf.emission import EmissionExpression
from sdf_lights.sdf.emission_presets import presets
from sdf_lights.sdf.shapes import Box, BoxFrame, Capsule, Difference, Sphere, Torus, Union
from support.lamps.shapes_under_test import FIELDS, PLACEMENTS, moved, scaled, turned

SHIFTS = (np.arange(256) + 0.5) / 256


def emission(text, **values):
    return EmissionExpression(text).emission(values)


def glowing(shape, text, matrix=None, **about):
    return build.build_lamp("glow", shape, np.eye(4) if matrix is None else matrix, emission=emission(text), **about)


@kernel
def _radiances(blocks, origins, directions, t_min, t_max, u, spans):
    """(rays, shifts, 3)"""
    out = np.zeros((len(origins), len(u), 3))
    for i in range(len(origins)):
        o = (origins[i, 0], origins[i, 1], origins[i, 2])
        d = (directions[i, 0], directions[i, 1], directions[i, 2])
        count = lamps.trace(blocks[0], 0, o, d, spans)
        for j in range(len(u)):
            out[i, j] = lamps.radiance(blocks[0], 0, o, d, spans, count, t_min, t_max, u[j])
    return out


def radiances(lamp, origins, directions, t_min=0.0, t_max=np.inf, u=SHIFTS):
    return _radiances(
        lamp.blocks,
        np.asarray(origins, float),
        np.asarray(directions, float),
        t_min,
        t_max,
        np.asarray(u, float),
        lamp.spans,
    )


def rays(count=60, radius=0.45, seed=1):
    """Rays that start 3 m from the origin and pass it closer than ``radius``."""
    rng = np.random.default_rng(seed)
    directions = rng.standard_normal((count, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    aside = np.cross(directions, rng.standard_normal((count, 3)))
    aside *= radius * np.sqrt(rng.random((count, 1))) / np.linalg.norm(aside, axis=1, keepdims=True)
    return aside - 3.0 * directions, directions


# -- means over the volume ------------------------------------------------------------------------------------------

R, W = 0.5, 0.05
MEANS = {
    "height of a ball": (Sphere(R), "height", 0.5),
    "position": (Box((0.5, 0.3, 0.2)), "p.x + 1", 1.0),
    "1/r² of a ball": (Sphere(R), "1 / dot(p, p)", 3.0 / R**2),
    "skin of a ball": (  # ∫ 4π r² exp((r − R)/w) dr
        Sphere(R),
        f"exp(-depth / {W})",
        3.0 / R**3 * W * (R**2 - 2.0 * W * R + 2.0 * W**2 * (1.0 - math.exp(-R / W))),
    ),
    "depth in a capsule": (  # of a cylinder ∫ 2π r (a − r) dr, and of a ball
        Capsule(0.2, 0.5),
        "depth",
        (0.5 * math.pi * 0.2**3 / 3.0 + math.pi * 0.2**4 / 3.0) / Capsule(0.2, 0.5).volume(),
    ),
    "depth in a torus": (Torus(1.0, 0.3), "depth", 0.1),
    "one eighth": (Box(0.4), "step(0, p.x) * step(0, p.y) * step(0, p.z)", 0.125),
}


@pytest.mark.parametrize("name", MEANS)
def test_mean_over_the_volume(name):
    """Within the bound that is stated, and that is small."""
    shape, text, expected = MEANS[name]
    found = build.measured(shape, emission(text)).emission_moments
    assert found.error < 5e-3
    assert found.mean == pytest.approx(expected, rel=found.error)


def test_a_spot_is_found():
    """A bright ball of a two-thousandth of the volume, with an edge that no sampling resolves well."""
    found = build.measured(
        Union(Sphere(R), Box(0.2)), emission("step(length(p - (0.2, 0.1, 0)), 0.04)")
    ).emission_moments
    assert found.error < 0.02
    assert found.mean == pytest.approx((0.04 / R) ** 3, rel=found.error)


@pytest.mark.parametrize(
    "shape", [Sphere(R), Torus(0.7, 0.2), BoxFrame((0.6, 0.5, 0.4), 0.08), FIELDS["blob"]], ids=str
)
def test_cells_follow_the_emission(shape):
    """Masses are those of the emission, divide their parents', and come to the volume."""
    volume = build.volume_of(shape)[0]
    cells = build.measured(shape, emission("exp(4 * p.x) * (1 + 0.5 * sin(20 * p.y))")).emission_moments.cells
    assert cells["mass"][0] == pytest.approx(volume, rel=1e-9) and cells["volume"][0] == pytest.approx(volume, rel=1e-9)
    inner = cells[cells["first"] >= 0]
    left, right = cells[inner["first"]], cells[inner["first"] + 1]
    assert np.allclose(left["mass"] + right["mass"], inner["mass"], rtol=1e-9)
    moments = [part["mass"][:, None] * part["mass_centroid"] for part in (left, right, inner)]
    assert np.allclose(moments[0] + moments[1], moments[2], atol=1e-12 * volume)
    full = cells[(cells["first"] < 0) & (cells["state"] == 1)]
    size = (full["high"] - full["low"]).prod(axis=1)
    assert np.allclose(full["volume"], size)
    middle = 0.5 * (full["low"] + full["high"]) + 0.5 * np.add(*shape.bounds())
    at = np.exp(4 * middle[:, 0]) * (1 + 0.5 * np.sin(20 * middle[:, 1]))
    ratio = full["mass"] / size / at
    assert ratio.std() < 0.1 * ratio.mean()


def test_a_steep_emission_is_resolved_in_a_single_box():
    cells = build.measured(Box(0.5), emission("exp(-40 * length(p - (0.5, 0.5, 0.5)))")).emission_moments.cells
    leaves = cells[cells["first"] < 0]
    brightest = leaves[np.argsort(leaves["mass"] / leaves["volume"])[-8:]]
    assert np.all(brightest["low"] > 0.4) and (brightest["high"] - brightest["low"]).max() < 0.07
    assert leaves["volume"].max() == pytest.approx(0.125**3)


def test_uniform_cells_have_their_volume_as_mass():

    cells = moments.cells(interior.tree(Torus(0.7, 0.2)), 1.0)
    assert np.array_equal(cells["mass"], cells["volume"])
    assert np.array_equal(cells["mass_centroid"], cells["centroid"])


# -- along rays -----------------------------------------------------------------------------------------------------


def test_the_change_of_variable():
    assert place_point(0.0) == (0.0, 0.0) and place_point(1.0) == (1.0, 0.0)
    s, h = np.linspace(0.05, 0.95, 19), 1e-6
    for x in s:
        assert (place_point(x + h)[0] - place_point(x - h)[0]) / (2 * h) == pytest.approx(place_point(x)[1], rel=1e-6)


def test_linear_emission_along_rays():
    """The chord times the emission at its middle; each shift alone is that to a few thousandths."""
    lamp = Lamps(glowing(Sphere(0.5), "1 + p.z", density=2.0))
    o, d = rays()
    spans = [lamp.trace(a, b) for a, b in zip(o, d)]
    assert all(len(rows) == 1 for rows in spans)
    c, h = np.concatenate(spans).T
    expected = 2.0 * 2.0 * h * (1.0 + o[:, 2] + c * d[:, 2])
    found = radiances(lamp, o, d)[..., 0]
    assert np.allclose(found.mean(axis=1), expected, rtol=1e-9)
    assert np.abs(found / expected[:, None] - 1.0).max() < 0.01


def test_one_over_r_squared_along_rays():
    """∫ dt / (b² + t²) = (2/b) atan(h/b)."""
    lamp = Lamps(glowing(Sphere(0.5), "1 / dot(p, p)", density=1.0))
    o, d = rays()
    c, h = np.concatenate([lamp.trace(a, b) for a, b in zip(o, d)]).T
    b = np.linalg.norm(o + c[:, None] * d, axis=1)
    found = radiances(lamp, o, d)[..., 1]
    assert np.allclose(found.mean(axis=1)[b > 0.05], (2.0 / b * np.arctan(h / b))[b > 0.05], rtol=1e-6)


def test_parts_of_a_ray():
    """A surface inside the lamp divides the integral."""
    lamp = Lamps(glowing(Torus(0.6, 0.3), "exp(-depth / 0.05) * (1, p.x + 1, height)"))
    o, d = rays()
    whole = radiances(lamp, o, d).mean(axis=1)
    parts = sum(radiances(lamp, o, d, *limits).mean(axis=1) for limits in ((0.0, 2.9), (2.9, 3.05), (3.05, np.inf)))
    assert np.allclose(parts, whole, rtol=1e-3, atol=1e-9 * whole.max())
    assert np.array_equal(radiances(lamp, o, d, 9.0), np.zeros((len(o), len(SHIFTS), 3)))


@pytest.mark.parametrize("placement", [name for name in PLACEMENTS if name not in ("far", "stretched")])
def test_a_placed_lamp_keeps_its_emission(placement):
    """A density stays that of the shape's own space, under every affine map."""
    matrix = PLACEMENTS[placement]
    here = Lamps(glowing(Union(Sphere(0.5), Box(0.3)), "(1 + p.x) * exp(-depth / 0.1)", density=1.0))
    there = Lamps(glowing(Union(Sphere(0.5), Box(0.3)), "(1 + p.x) * exp(-depth / 0.1)", matrix, density=1.0))
    o, d = rays(20)
    origins, ways = o @ matrix[:3, :3].T + matrix[:3, 3], d @ matrix[:3, :3].T
    stretch = np.linalg.norm(ways, axis=1)
    found = radiances(there, origins, ways / stretch[:, None]).mean(axis=1) / stretch[:, None]
    assert np.allclose(found, radiances(here, o, d).mean(axis=1), rtol=2e-3)


@pytest.mark.parametrize(
    "text", [presets()[name].text for name in presets()] + ["exp(-depth / 0.004)"], ids=[*presets(), "thin skin"]
)
@pytest.mark.parametrize(
    "shape",
    [Sphere(0.5), Torus(0.5, 0.15), Difference(Box(0.4), Sphere(0.5)), FIELDS["blob"]],
    ids=["ball", "torus", "difference", "field"],
)
def test_noise_of_an_estimate_is_small(shape, text):
    """The standard deviation by the shift of the points, against the light of the rays: twice what is aimed at, as
    these are other rays than those that the number of points was found by."""
    if not emission(text).varies:
        return
    lamp = Lamps(glowing(shape, text))
    found = radiances(lamp, *rays(200), u=SHIFTS[::16])[..., 0]
    assert found.min() >= 0.0
    assert math.sqrt(found.var(axis=1).mean()) < 0.04 * math.sqrt((found.mean(axis=1) ** 2).mean())


@pytest.mark.parametrize("text", [presets()[name].text for name in presets()], ids=list(presets()))
@pytest.mark.parametrize("shape", [Torus(0.5, 0.2), FIELDS["blob"]], ids=["torus", "field"])
def test_power_is_that_of_a_point_light_far_away(shape, text):
    """∫ L dω = P/4π/d², whatever the emission. Within 4.5 standard errors and what the integral is known to."""
    lamp = Lamps(glowing(shape, text, turned(0.4, 0) @ scaled(1.0, 1.5, 0.7), power=40.0))
    x = np.array([0.0, 3e4, 0.0])
    directions = lamp.sample(x, np.random.default_rng(2).random((40_000, 3)))
    light = radiances(lamp, np.broadcast_to(x, directions.shape).copy(), directions, u=SHIFTS[8::32]).mean(axis=1)
    weight = light.mean(axis=1) / lamp.pdf(x, directions)
    error = 4.5 * weight.std() / math.sqrt(len(weight)) / weight.mean() + float(lamp.row["emission_error"]) + 1e-4
    assert error < 0.05
    assert weight.mean() == pytest.approx(40.0 / (4.0 * math.pi) / 3e4**2, rel=error)
    assert lamp.row["power"] == pytest.approx(40.0, rel=1e-12)


def test_colours_keep_their_relations():
    lamp = glowing(Box(0.5), "ramp(p.x, -0.5, (1, 0, 0), 0.5, (0, 0, 3))", power=8.0, color=(1.0, 1.0, 0.5))
    red, green, blue = lamp.row["emission"][0] * 4.0 * math.pi * lamp.row["volume"][0]
    assert green == 0.0
    assert (red, blue) == pytest.approx((8.0 * 0.5 / (2.0 / 3.0), 0.5 * 8.0 * 1.5 / (2.0 / 3.0)), rel=1e-3)
    assert lamp.row["power"][0] == pytest.approx((red + blue) / 3.0)


def test_emission_that_does_not_vary_is_a_colour():
    lamp = glowing(Sphere(0.5), "t = slider(2000, 800, 9000)\n3 * blackbody(t)", power=10.0)
    plain = build.build_lamp("plain", Sphere(0.5), np.eye(4), power=10.0)
    assert lamp.row["glow"][0] == -1 and lamp.emission is None
    assert lamp.row["emission"].mean() == pytest.approx(plain.row["emission"].mean())
    assert lamp.row["emission"][0, 0] > 3.0 * lamp.row["emission"][0, 1]
    bright = glowing(Sphere(0.5), "(2, 1, 0)", density=3.0)
    assert np.allclose(bright.row["emission"], (6.0, 3.0, 0.0))


def test_lamps_share_code_but_not_numbers():
    text = "w = slider(0.1, 0.01, 1)\nexp(-depth / w)"
    built = [
        build.build_lamp("a", Sphere(0.5), moved(x=2.0 * i), emission=emission(text, w=w), density=1.0)
        for i, w in enumerate((0.05, 0.5))
    ]
    assert len({int(lamp.glow["address"][0]) for lamp in built}) == 1
    both = Lamps(*built)
    assert both.tables["lamps"]["glow"].tolist() == [0, 1]
    swapped = Lamps(*built[::-1])
    o, d = np.array([[0.0, 0.1, -3.0], [2.0, 0.1, -3.0]]), np.array([[0.0, 0.0, 1.0]] * 2)
    first, second = radiances(both, o[:1], d[:1]).mean(), radiances(swapped, o[1:], d[1:]).mean()
    assert first == pytest.approx(radiances(Lamps(built[0]), o[:1], d[:1]).mean(), rel=1e-12)
    assert second > 3.0 * first


@pytest.mark.parametrize(
    "text, message",
    [
        ("-depth", "emission is zero or undefined everywhere"),
        ("0", "emission is zero or undefined everywhere"),
        ("sqrt(-1 - depth)", "emission is zero or undefined everywhere"),
    ],
)
def test_dark_lamps_are_refused(text, message):
    with pytest.raises(build.LampError, match=f"Lamp “glow”: its {message}"):
        glowing(Torus(0.5, 0.2), text)


def test_an_emission_without_the_color_of_its_light():
    with pytest.raises(build.LampError, match="shares no color component"):
        glowing(Torus(0.5, 0.2), "(0, depth, 0)", color=(1.0, 0.0, 1.0))


def test_what_counts_as_zero_is_said():
    built = glowing(Box(0.5), "p.x + 0.25")
    (remark,) = remarks.doubts([built])
    assert "Lamp “glow”: its emission is negative in 2" in remark
    assert built.emission.emission_moments.mean == pytest.approx(0.75**2 / 2.0, rel=2e-3)
    (remark,) = remarks.doubts([glowing(Box(0.5), "1 / max(p.x, 0)")])
    assert "undefined or infinite in " in remark
    assert remarks.doubts([glowing(Box(0.5), "depth")]) == []
