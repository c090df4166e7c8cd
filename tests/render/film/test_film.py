# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The film, filled by the kernels that the path tracer uses and by the reference's NumPy code."""

import itertools

import numpy as np
import pytest

from sdf_lights.jit import block_dtype, fill_table, kernel
from sdf_lights.render.film import HALF_BIT, LEAST_SAMPLES, NO_DEPTH, Film, half_count
from sdf_lights.render.kernels import film as accumulate
from sdf_lights.render.kernels import path
from sdf_lights.render.kernels.outputs import records
from sdf_lights.render.passes import BY_NAME, PASSES, Rule, data_width, is_light
from sdf_lights.render.scene import Camera, Scene
from sdf_lights.render.settings import Settings

ALL = tuple(item.name for item in PASSES if not is_light(item) and not data_width(item))
WIDTH, HEIGHT = 8, 6


def new_film(passes=ALL, border=None, width=WIDTH, height=HEIGHT, **settings):
    return Film(Scene(Camera(np.eye(4)), width, height, border=border, settings=Settings(**settings)), passes)


def random_samples(count, film, seed=0):
    """(count, pixels) records as the integrator fills them; two of three meet a surface."""
    rng = np.random.default_rng(seed)
    samples = np.zeros((count, film.width * film.height), path.SAMPLE)
    for name in (
        "combined",
        "lamps",
        "emission",
        "environment",
        "normal",
        "albedo",
        "diffuse_albedo",
        "position",
        "depth",
    ):
        samples[name] = rng.gamma(1.0, 1.0, samples[name].shape)
    samples["alpha"] = rng.random(samples.shape)
    samples["found"] = rng.random(samples.shape) < 2 / 3
    return samples


@kernel
def _add(block, workspace, samples, x0, y0, x1, y1, first):
    for y in range(y0, y1):
        for x in range(x0, x1):
            pixel = accumulate.pixel_index(block, x, y)
            if accumulate.is_active(block, pixel):
                for index in range(samples.shape[0]):
                    path.sample_table(workspace)[0] = samples[index, pixel]
                    accumulate.add_sample(block, workspace, pixel, first + index)


def add(film, samples, first=0, tiles=None):
    """Add samples ``first``, … in the order of ``tiles`` (x0, y0, x1, y1)."""
    tables = accumulate.pack_film(film)
    block = np.zeros(1, block_dtype({**accumulate.TABLES, **records.TABLES}, [*accumulate.SCALARS, *records.SCALARS]))
    for name, table in tables.items():
        fill_table(block, name, table)
    for name, value in accumulate.film_scalars(film).items():
        block[name] = value
    scratch = np.zeros(1, path.SAMPLE)
    workspace = np.zeros(1, block_dtype({"sample": path.SAMPLE}))
    fill_table(workspace, "sample", scratch)
    for tile in tiles or [film.window]:
        _add(block[0], workspace[0], samples, *tile, first)
    film.samples = first + len(samples)


def image(film, values):
    """(pixels, …) as (height, width, channels)."""
    return values.reshape(film.height, film.width, -1)


def test_passes_are_read_by_their_rule():
    film = new_film(exposure=2.5)
    samples = random_samples(7, film)
    samples["found"][0, ::2] = 0
    samples["found"][:, 3] = 0
    add(film, samples)
    found = samples["found"] != 0
    first = np.argmax(found, axis=0)
    seen = found.any(axis=0)[:, None]
    each = np.arange(found.shape[1])
    surface = {name: np.where(found[..., None], samples[name], 0.0) for name in ("normal", "albedo")}
    combined = np.concatenate([2.5 * samples["combined"].mean(axis=0), samples["alpha"].mean(axis=0)[:, None]], axis=1)
    expected = {
        "Combined": combined,
        "Noisy Image": combined,
        "SDF Lamps": 2.5 * samples["lamps"].mean(axis=0),
        "Emission": 2.5 * samples["emission"].mean(axis=0),
        "Environment": 2.5 * samples["environment"].mean(axis=0),
        "Sample Count": np.full((len(each), 1), 7),
        "Normal": surface["normal"].mean(axis=0),
        "Denoising Normal": surface["normal"].mean(axis=0),
        "Diffuse Color": samples["diffuse_albedo"].mean(axis=0),
        "Denoising Albedo": surface["albedo"].mean(axis=0),
        "Position": np.where(seen, samples["position"][first, each], 0.0),
        "Depth": np.where(seen, samples["depth"][first, each][:, None], NO_DEPTH),
    }
    assert set(expected) == set(ALL)
    for name, values in expected.items():
        value = film.read(name)
        assert value.dtype == np.float32 and value.flags.c_contiguous
        assert value.shape == (HEIGHT, WIDTH, len(BY_NAME[name].channels))
        np.testing.assert_allclose(value, image(film, values), rtol=1e-6, err_msg=name)
        np.testing.assert_array_equal(film.read(name, slice(1, 4)), value[1:4])


def test_table_of_passes():
    for item in PASSES:
        assert len(item.channels) in (1, 3, 4) and len(set(item.channels)) == len(item.channels)
        assert (item.source is None) == (item.rule is Rule.COUNT)
        assert not item.description.endswith(".")
    assert len(BY_NAME) == len(PASSES) and PASSES[0].name == "Combined" and PASSES[0].switch is None


def test_memory_is_only_for_passes_in_use():
    film = new_film(())
    assert film.passes == ("Combined",)
    assert {name for name, sums in film.sums.items() if sums.size} == {
        "combined",
        "half",
        "scattered",
        "scattered_half",
    }
    add(film, random_samples(3, film))
    assert np.all(film.count == 3)
    denoised = new_film((), denoise=True)
    assert denoised.sums["albedo"].size and denoised.sums["normal"].size


def test_the_sums_do_not_depend_on_the_order_of_tiles_or_batches():
    tiles = [(x, y, min(x + 3, WIDTH), min(y + 4, HEIGHT)) for y in range(0, HEIGHT, 4) for x in range(0, WIDTH, 3)]
    films = [new_film() for _ in range(3)]
    samples = random_samples(20, films[0])
    add(films[0], samples)
    add(films[1], samples, tiles=tiles[::-1])
    for first, last in itertools.pairwise((0, 1, 2, 9, 20)):
        add(films[2], samples[first:last], first, tiles)
    for film in films[1:]:
        for name in ALL:
            assert film.read(name).tobytes() == films[0].read(name).tobytes()
        assert film.noise() == films[0].noise()


def test_passes_that_a_back_end_lacks_are_named():
    (told,) = new_film(("Depth", "UV", "Diffuse Direct")).beyond("The GPU")
    assert told.startswith("The GPU leaves these passes black: UV, Diffuse Direct; ")
    assert new_film(("Depth", "Emission", "Environment")).beyond("The GPU") == []


def test_border():
    """A film of the border alone holds the same as that part of the whole frame."""
    whole, part = new_film(), new_film(border=(2, 1, 7, 5))
    assert (part.width, part.height, part.window) == (5, 4, (2, 1, 7, 5))
    samples = random_samples(4, whole)
    add(whole, samples)
    add(part, np.ascontiguousarray(samples.reshape(4, HEIGHT, WIDTH)[:, 1:5, 2:7]).reshape(4, -1))
    for name in ALL:
        np.testing.assert_array_equal(part.read(name), whole.read(name)[1:5, 2:7])


@pytest.mark.parametrize("value, kind", [(np.nan, "NaN"), (np.inf, "infinite"), (-np.inf, "infinite")])
def test_samples_that_are_not_finite_are_left_out_and_named(value, kind):
    film = new_film(border=(1, 1, 8, 6))
    samples = random_samples(4, film)
    assert film.discarded_report() is None
    samples["combined"][2, 9, 1] = value
    samples["combined"][3, 9, 0] = value
    samples["alpha"][1, 3] = value
    add(film, samples)
    assert np.isfinite(film.read("Combined")).all() and np.all(film.count == 4)
    np.testing.assert_allclose(film.read("Combined")[1, 2, :3], samples["combined"][:2, 9].sum(axis=0) / 4, rtol=1e-6)
    report = film.discarded_report()
    assert report.startswith(f"3 {kind} samples") and "pixel (3, 2)" in report


def test_alpha_stays_in_range():
    film = new_film(())
    samples = random_samples(1, film)
    samples["alpha"][:] = np.linspace(-1.0, 2.0, samples.size)
    add(film, samples)
    assert film.read("Combined")[..., 3].min() == 0.0 and film.read("Combined")[..., 3].max() == 1.0


def test_half_count():
    bits = (np.arange(5 * HALF_BIT) & HALF_BIT) != 0
    counts = np.arange(len(bits) + 1)
    np.testing.assert_array_equal(half_count(counts), np.concatenate([[0], np.cumsum(bits)]))


def test_noise_is_the_error_of_independent_samples():
    """The estimate against the true mean absolute error, 2.5 % being 4 standard errors for 4096 pixels."""
    film = new_film((), width=64, height=64)
    samples = random_samples(4 * LEAST_SAMPLES, film)
    samples["combined"] += 1.0
    add(film, samples[: LEAST_SAMPLES - 1])
    assert film.noise() is None
    add(film, samples[LEAST_SAMPLES - 1 :], LEAST_SAMPLES - 1)
    true = np.abs(film.read("Combined")[..., :3] - 2.0).mean() / 2.0
    assert film.noise() == pytest.approx(true, rel=0.025)


def test_noise_of_a_stratified_pattern_is_neither_hidden_nor_much_exaggerated():
    """An integrand over two padded sets, as light that is scattered once is: estimate 0.9 to 1.25 times the error."""
    from sdf_lights.render.kernels.samplers import get_2d, pixel_seed

    film = new_film((), width=48, height=48)
    count = 8 * LEAST_SAMPLES
    samples = np.zeros((count, 48 * 48), path.SAMPLE)
    for y, x in np.ndindex(48, 48):
        seed = pixel_seed(x, y, 0)
        for index in range(count):
            a, b = get_2d(index, seed, 0), get_2d(index, seed, 1)
            samples["combined"][index, 48 * y + x] = 1.0 if a[0] + b[1] < 0.8 and b[0] < a[1] + 0.3 else 0.0
    add(film, samples)
    picture = film.read("Combined")[..., 0].astype(float)
    true = np.abs(picture - picture.mean()).mean() / picture.mean()
    assert 0.9 < film.noise() / true < 1.25


def noisy_pixels(film, count, noisy):
    """Constant light, but pixels of ``noisy`` (indices) bright in the second half of each 16 samples only."""
    samples = np.zeros((count, film.width * film.height), path.SAMPLE)
    samples["combined"] = 1.0
    samples["combined"][:, noisy] = np.where((np.arange(count) & HALF_BIT) != 0, 1.5, 0.5)[:, None, None]
    return samples


def test_adaptive_sampling_goes_on_around_noisy_pixels():
    film = new_film(())
    centre = 2 * WIDTH + 4
    add(film, noisy_pixels(film, LEAST_SAMPLES, [centre]))
    assert film.update_active(0.01)
    active = image(film, film.active)[..., 0]
    expected = np.zeros((HEIGHT, WIDTH))
    expected[1:4, 3:6] = 1
    np.testing.assert_array_equal(active, expected)
    add(film, noisy_pixels(film, 4, [centre]), LEAST_SAMPLES)
    np.testing.assert_array_equal(image(film, film.count)[..., 0], LEAST_SAMPLES + 4 * expected)
    # Noise elsewhere, later, does not wake a pixel that has stopped; without noise all stop.
    film.sums["half"][:] = 0.0
    assert film.update_active(0.01)
    np.testing.assert_array_equal(image(film, film.active)[..., 0], expected)
    assert not film.update_active(1e9)


def test_adaptive_sampling_waits_for_an_estimate():
    film = new_film(())
    add(film, noisy_pixels(film, LEAST_SAMPLES - 1, []))
    assert film.update_active(1.0) and film.active.all()


def test_threshold_is_of_the_exposed_picture():
    dark, bright, brighter = (new_film((), exposure=exposure) for exposure in (0.01, 1.0, 10.0))
    for film in (dark, bright, brighter):
        add(film, noisy_pixels(film, LEAST_SAMPLES, range(WIDTH * HEIGHT)))
    # The sum of RGB is 3 and its error 1.5: |I − A| / √I where that exposed is below 1, else |I − A| / I.
    error = 0.01 * 1.5 / (0.01 * 3.0) ** 0.5
    assert dark.update_active(0.99 * error) and not dark.update_active(1.01 * error)
    for film in (bright, brighter):
        assert film.update_active(0.495) and not film.update_active(0.505)


def test_variances_are_those_of_the_picture():
    film = new_film((), width=64, height=64, exposure=2.0)
    samples = random_samples(2 * LEAST_SAMPLES, film)
    samples["combined"] = samples["combined"][..., :1]  # grey
    samples["divided"] = samples["branches"] = 0
    add(film, samples)
    expected = 3.0 * film.exposure**2 / len(samples)  # of numbers whose variance is 1
    for estimate in film.variances():
        assert estimate.shape == (64, 64)
        assert estimate.mean() == pytest.approx(expected, rel=0.1)


def test_an_unlit_picture_has_no_noise_and_stops():
    film = new_film(())
    samples = np.zeros((LEAST_SAMPLES, WIDTH * HEIGHT), path.SAMPLE)
    add(film, samples)
    assert film.noise() == 0.0 and not film.update_active(0.01)


def test_denoised_picture_replaces_combined_only():
    film = new_film()
    add(film, random_samples(2, film))
    noisy = film.read("Combined")
    film.replace_combined(np.full((HEIGHT, WIDTH, 3), 0.25, np.float32))
    assert np.all(film.read("Combined")[..., :3] == 0.25)
    np.testing.assert_array_equal(film.read("Combined")[..., 3], noisy[..., 3])
    np.testing.assert_array_equal(film.read("Noisy Image"), noisy)


def test_reference_adds_the_same():
    from sdf_lights.render.reference.paths import Samples
    from sdf_lights.render.reference.renderer import ReferenceRenderer

    films = [new_film(), new_film()]
    samples = random_samples(20, films[0])
    samples["combined"][4, 5] = np.nan
    samples["combined"][5, 6] = np.inf
    samples["depth"] = 0.0
    samples["position"] = 0.0
    add(films[0], samples)
    renderer = ReferenceRenderer(Scene(Camera(np.eye(4)), WIDTH, HEIGHT), films[1])
    pixel, index = np.tile(np.arange(WIDTH * HEIGHT), 20), np.repeat(np.arange(20), WIDTH * HEIGHT)
    same = Samples(samples.size)
    for name in vars(same).keys() & set(samples.dtype.names):
        getattr(same, name)[:] = samples.ravel()[name]
    renderer._add(pixel, index, same)
    for name in ALL:
        np.testing.assert_allclose(films[1].read(name), films[0].read(name), rtol=1e-6, err_msg=name)
    np.testing.assert_array_equal(films[1].discarded, films[0].discarded)
    assert films[1].noise() == pytest.approx(films[0].noise(), rel=1e-12)
