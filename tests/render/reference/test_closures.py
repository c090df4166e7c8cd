# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Lobes of the reference: sampling against pdf, reciprocity, energy. Seeds are fixed; confidence 0.9999 each."""

import numpy as np
import pytest

from sdf_lights.render.reference.albedo_tables import Table, cosine_axis, ior_axis
from sdf_lights.render.reference.closures import (
    DIELECTRIC,
    F82,
    NONE,
    Diffuse,
    Microfacet,
    OrenNayar,
    Sheen,
    Translucent,
    dielectric,
)
from sdf_lights.render.reference.vectors import normalize
from support.chi2 import chi2_sphere
from tests.render.shading.surfaces import refracts

N = normalize(np.array([[0.3, -0.4, 0.8]]))
WO = normalize(np.array([[0.1, 0.6, 0.7]]))


def build(name, count, n=N):
    normal, white = np.tile(n, (count, 1)), np.ones((count, 3))

    def ggx(roughness, ior, term, transmits, **more):
        return Microfacet(
            white,
            normal,
            alpha=np.full(count, roughness**2),
            ior=np.full(count, ior),
            term=term,
            transmits=transmits,
            **more,
        )

    f0 = np.full((count, 3), 0.04)
    return {
        "diffuse": lambda: Diffuse(white, normal),
        "translucent": lambda: Translucent(white, normal),
        "oren_nayar": lambda: OrenNayar(white, normal, color=white, roughness=np.full(count, 0.7)),
        "sheen": lambda: Sheen(white, normal, a=np.full(count, 0.6), b=np.full(count, -0.2)),
        "mirror": lambda: ggx(0.5, 1.0, NONE, False),
        "metal": lambda: ggx(0.7, 1.0, F82, False, f0=f0 * 20, tint=white * 0.5),
        "coat": lambda: ggx(0.4, 1.5, DIELECTRIC, False, f0=f0),
        "glass": lambda: ggx(0.5, 1.5, DIELECTRIC, True, f0=f0, reflection=white, transmission=white),
        "glass inside": lambda: ggx(0.5, 1 / 1.5, DIELECTRIC, True, f0=f0, reflection=white, transmission=white),
        "refraction": lambda: ggx(0.6, 1.3, NONE, True),
    }[name]()


NAMES = [
    "diffuse",
    "translucent",
    "oren_nayar",
    "sheen",
    "mirror",
    "metal",
    "coat",
    "glass",
    "glass inside",
    "refraction",
]


@pytest.mark.parametrize("name", NAMES)
def test_samples_follow_the_pdf(name):
    rng = np.random.Generator(np.random.Philox(11))

    def sample(u):
        lobe, wo = build(name, len(u)), np.tile(WO, (len(u), 1))
        wi, _, probability, singular = lobe.sample(rng, wo)
        assert not singular.any()
        # A direction below the surface is given up.
        return np.where((lobe.evaluate(wo, wi)[1] > 0.0)[:, None] & (probability > 0.0)[:, None], wi, np.nan)

    def pdf(directions):
        lobe = build(name, len(directions))
        density = lobe.evaluate(np.tile(WO, (len(directions), 1)), directions)[1]
        if getattr(lobe, "transmits", False):
            density = np.where(refracts(WO[0], directions, N[0], lobe.ior[0]), density, 0.0)
        return density

    axis = -N[0] if name in ("translucent", "refraction") else N[0]
    result = chi2_sphere(sample, pdf, n=60_000, seed=3, confidence=0.9999, axis=axis)
    assert result.passed, result


@pytest.mark.parametrize("name", ["diffuse", "oren_nayar", "mirror", "metal", "coat", "glass"])
def test_reflection_is_reciprocal(name):
    rng = np.random.default_rng(4)
    wo, wi = (normalize(rng.normal(size=(500, 3)) + 2 * N) for _ in range(2))
    lobe = build(name, 500)
    above = (wo @ N[0] > 0.05) & (wi @ N[0] > 0.05)
    forward = lobe.evaluate(wo, wi)[0] / (wi @ N[0])[:, None]
    backward = lobe.evaluate(wi, wo)[0] / (wo @ N[0])[:, None]
    np.testing.assert_allclose(forward[above], backward[above], rtol=1e-9, atol=1e-12)


def test_refraction_is_reciprocal_up_to_the_square_of_the_index():
    """f(wo → wi) / η_i² = f(wi → wo) / η_o² (Veach 1997, equation 5.14), the normal turning with the side."""
    rng = np.random.default_rng(5)
    wo, wi = normalize(rng.normal(size=(500, 3)) + 2 * N), normalize(rng.normal(size=(500, 3)) - 2 * N)
    keep = (wo @ N[0] > 0.05) & (wi @ N[0] < -0.05)
    outside, inside = build("glass", 500), build("glass inside", 500, -N)
    forward = outside.evaluate(wo, wi)[0] / np.abs(wi @ N[0])[:, None]
    backward = inside.evaluate(wi, wo)[0] / np.abs(wo @ N[0])[:, None]
    assert (forward[keep] > 0.0).any()
    np.testing.assert_allclose(forward[keep] / 1.5**2, backward[keep], rtol=1e-9, atol=1e-12)


def albedo(name_or_lobe, wo, count=40_000):
    """(mean, standard error) of the directional albedo, by the lobe's own sampling."""
    lobe = build(name_or_lobe, count) if isinstance(name_or_lobe, str) else name_or_lobe
    wo = np.tile(wo, (count, 1))
    wi, _, probability, _ = lobe.sample(np.random.Generator(np.random.Philox(12)), wo)
    value, pdf = lobe.evaluate(wo, wi)
    values = np.where((pdf > 0.0) & (probability > 0.0), value[:, 0] / np.where(pdf > 0.0, pdf, 1.0), 0.0)
    return values.mean(), values.std() / np.sqrt(count)


@pytest.mark.parametrize("name, expected", [("diffuse", 1.0), ("translucent", 1.0), ("sheen", 1.0)])
def test_lossless_lobes_lose_nothing(name, expected):
    mean, error = albedo(name, WO)
    assert abs(mean - expected) <= 4.4 * error + 1e-9


def test_oren_nayar_keeps_the_energy_of_white():
    """Its average albedo is a fit of OpenPBR (5.6 for an integral), good to a few thousandths."""
    mean, error = albedo("oren_nayar", WO)
    assert abs(mean - 1.0) < 4.4 * error + 3e-3


@pytest.mark.parametrize("roughness, cosine", [(0.3, 0.3), (0.7, 0.7), (1.0, 0.2)])
def test_albedo_tables_hold_what_the_lobes_reflect(roughness, cosine):
    """``render.tables`` was made by other code; interpolation is good to a few thousandths."""
    count, table = 40_000, Table()
    normal, white = np.tile([0.0, 0.0, 1.0], (count, 1)), np.ones((count, 3))
    wo = np.array([[np.sqrt(1 - cosine**2), 0.0, cosine]])
    x = cosine_axis(np.array([cosine])), np.array([roughness])
    black, z = np.zeros((count, 3)), ior_axis(np.array([1.5]))

    def lobe(ior, term, transmits, **more):
        return Microfacet(
            white,
            normal,
            alpha=np.full(count, roughness**2),
            ior=np.full(count, ior),
            term=term,
            transmits=transmits,
            **more,
        )

    glass = dict(f0=black + 0.04, reflection=white, transmission=white)
    cases = {
        table("reflection", *x)[0]: lobe(1.0, NONE, False),
        table("dielectric", z, *x)[0]: lobe(1.5, DIELECTRIC, False, f0=black),
        table("schlick", *x)[0]: lobe(1.0, F82, False, f0=black, tint=white),
        table("glass", z, *x)[0]: lobe(1.5, DIELECTRIC, True, **glass),
        table("glass_inside", z, *x)[0]: lobe(1 / 1.5, DIELECTRIC, True, **glass),
    }
    for expected, case in cases.items():
        mean, error = albedo(case, wo)
        assert abs(mean - expected) < 4.4 * error + 4e-3


def test_fresnel_at_known_angles():
    r, t = dielectric(np.array([1.0, np.cos(np.arctan(1.5)), 0.0, 0.3]), np.array([1.5, 1.5, 1.5, 1 / 1.5]))
    brewster = 0.5 * np.sin(2 * np.arctan(1.5) - np.pi / 2) ** 2  # only s-polarised light is reflected
    np.testing.assert_allclose(r, [0.04, brewster, 1.0, 1.0], rtol=1e-12)
    assert t[0] == 1.0 and t[3] == 0.0
