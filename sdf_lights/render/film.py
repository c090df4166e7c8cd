# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The film: the sums of the samples of every pixel, their noise, and the passes read from them."""

from __future__ import annotations

import dataclasses

import numpy as np

from .passes import BY_NAME, CATCHER_SUMS, DATA_SUMS, Pass, Rule, data_width, is_light, matte_of
from .scene import Scene, catches_shadows
from .settings import START_BRANCHES, CausticPaths

# Values that a pixel sums for each pass. "half" sums half of the samples of "combined", to estimate the noise.
CHANNELS = {
    "combined": 4,
    "half": 3,
    "lamps": 3,
    "emission": 3,
    "environment": 3,
    "normal": 3,
    "albedo": 3,
    "diffuse_albedo": 3,
    "position": 3,
    "depth": 1,
    "scattered": 3,
    "scattered_half": 3,
    "scattered_lamps": 3,
}
# If paths split, these hold the part before the split. Others hold the contributions of branches, one term for each
# branch: samples with many branches carry more information.
SCATTERED = {"combined": "scattered", "half": "scattered_half", "lamps": "scattered_lamps"}

# Light of paths that have hit a shadow catcher, among the sums of light.
CAUGHT_LIGHT = "caught light"

# Depth of a pixel that sees nothing, as in Cycles.
NO_DEPTH = 1e10
# A sample belongs to "half" if this bit of its index is set: every second block of 8. Each block is a stratified point
# set by itself, like the whole, so the halves differ by as much as the error. Odd and even samples are each less well
# stratified than the whole, and overestimate the error up to 2.5 times for light that is scattered once.
HALF_BIT = 8
# Smallest number of samples that gives two halves of equal size.
LEAST_SAMPLES = 2 * HALF_BIT

# Kinds of samples that are not finite; each pixel has a count of each.
DISCARDED = ("NaN", "infinite")
# Of a pixel: the picture, its guides, light seen directly, the rest, both that and the picture denoised, and the
# result.
DENOISED_BYTES = 4 * (4 + 7 * 3)
CAUSTIC_BYTES = 2 * 3 * 8  # of a pixel: the sums of caustic paths, and the picture of a set
DIVIDED, SQUARES = 5, 4  # sums about the cost of branches, and the scatter of samples
GREATEST = float(np.finfo(np.float32).max)  # largest number for a pixel of a pass


def half_count(count: np.ndarray) -> np.ndarray:
    """How many (pixels,) of the first ``count`` samples of each pixel belong to "half"."""
    return count // (2 * HALF_BIT) * HALF_BIT + np.maximum(count % (2 * HALF_BIT) - HALF_BIT, 0)


def bytes_of_a_pixel(scene: Scene, passes: tuple[str, ...] = ()) -> int:
    """Memory of a film per pixel, including data during sampling and the copies of its passes in Blender."""
    film = Film(dataclasses.replace(scene, border=(0, 0, 1, 1)), passes)
    arrays = [*vars(film).values(), *film.sums.values()]
    held = sum(array.nbytes for array in arrays if isinstance(array, np.ndarray))
    earlier = film.count.nbytes + film.sums["combined"].nbytes  # copies at the last decision, see ``earlier``
    denoising = DENOISED_BYTES if scene.settings.denoise else 0
    denoising += CAUSTIC_BYTES if scene.settings.caustic_paths is not CausticPaths.NEVER else 0
    return held + earlier + denoising + sum(4 * len(item.channels) for item in map(film._table.get, film.passes))


def _placed(widths: dict[str, int]) -> tuple[dict[str, int], int]:
    """The first column of each in one array, and the number of columns."""
    ends = np.cumsum([0, *widths.values()])
    return dict(zip(widths, ends.tolist())), int(ends[-1])


class Film:
    """Sums of samples for the pixels of ``window`` = (x0, y0, x1, y1), the border or the whole frame.

    Arrays are flat, row 0 at the bottom, float64: a million samples add up without drift. Back ends add to them. A
    pixel takes its samples in the order of their index, without gaps, and belongs to one thread at a time, so the sums
    do not depend on the order of work.

    - ``sums``: name of ``CHANNELS`` -> sums, pixel by pixel; empty where no pass needs them.
    - ``light_places``, ``data_places``: name of ``passes.LIGHT_SUMS`` or ``DATA_SUMS`` -> its first column, where a
      pass needs it.
    - ``light_sums``: (pixels, 2 × columns) light before paths divide, then, as in ``SCATTERED``, what branches bring.
    - ``data_sums``: (pixels, columns).
    - ``matte_places``: kind of Cryptomatte -> its row; ``matte_sums``: (pixels, rows, ``matte_slots``, 2) numbers of
      things, 0 for none, and by how much they cover the samples.
    - ``count``: samples; ``surfaces``: samples that met a surface.
    - ``active``: 1 where the pixel takes more samples.
    - ``catches``: whether Combined has what shadow catchers catch in the place of what they are.
    - ``discarded``: for each pixel the number of samples of each kind in ``DISCARDED``; they count as black.
    - ``divided``: (pixels, DIVIDED) into how many branches paths were to divide, in all and in "half", and the surfaces
      that branches met, with a part of one for rays that left the scene; then the sum over samples of one over their
      branches, and how often a lamp was looked at box by box before paths divided. None, where the back end lets no
      path divide.
    - ``squares``: (pixels, SQUARES) sums of the squares of what a sample had, as a sum of RGB, before its path divided,
      and in all; of what samples had in all; and of the squared deviations of what the branches of a sample brought
      from their mean.
    - ``rate``: samples that a pixel takes for one that is set, where the back end can;
      ``next_update``: with how many samples that is decided again (``sample_allocation.py``).
    - ``earlier``: counts and sums at the last such decision.
    - ``branches``: into how many the paths of a pixel divide, where the back end lets them (``sample_allocation.py``).
    - ``shares``: whether groups of pixels share their branches, and have no light paths.
    - ``caustics``: (pixels, RGB) the light of caustic paths, one picture for each of ``caustic_samples`` samples; no
      rows, where there are none.
    - ``samples``: how many samples every active pixel has received whose rate is 1.
    - ``made_by``: what computed them, in words for the user.
    """

    def __init__(self, scene: Scene, passes: tuple[str, ...] = ()):
        self.window = scene.border or (0, 0, scene.width, scene.height)
        self.width, self.height = self.window[2] - self.window[0], self.window[3] - self.window[1]
        self.exposure = scene.settings.exposure
        self.samples = 0
        self.made_by = ""
        names = {"Combined", *passes}
        if scene.settings.denoise:
            names |= {"Denoising Albedo", "Denoising Normal", "Emission"}
        self._table = BY_NAME | {item.name: item for item in scene.passes}
        self.passes = tuple(name for name in self._table if name in names)
        chosen = [self._table[name] for name in self.passes]
        used = {item.source for item in chosen} | {item.per for item in chosen} | {"half"}
        used |= {SCATTERED[name] for name in used & SCATTERED.keys()}
        self.catches = catches_shadows(scene)
        self._transparent = scene.settings.transparent_film
        used |= {*CATCHER_SUMS, "environment"} if self.catches else set()
        pixels = self.width * self.height
        self.sums = {name: np.zeros(pixels * count if name in used else 0) for name, count in CHANNELS.items()}
        self.light_places, width = _placed(
            {item.source: 3 for item in chosen if is_light(item)} | ({CAUGHT_LIGHT: 3} if self.catches else {})
        )
        self.light_sums = np.zeros((pixels, 2 * width))
        widths = {item.source: data_width(item) for item in chosen if data_width(item)}
        self.data_places, width = _placed({name: n for name, n in DATA_SUMS.items() if name in used} | widths)
        self.data_sums = np.zeros((pixels, width))
        kinds = list(dict.fromkeys(filter(None, map(matte_of, chosen))))
        self.matte_places = {kind: place for place, kind in enumerate(kinds)}
        self.matte_slots = 2 * max((item.level + 1 for item in chosen if matte_of(item)), default=0)
        self.matte_sums = np.zeros((pixels, len(kinds), self.matte_slots, 2))
        self.count = np.zeros(pixels, np.int32)
        self.surfaces = np.zeros(pixels, np.int32)
        self.active = np.ones(pixels, np.uint8)
        self.divided, self.squares = np.zeros((pixels, DIVIDED)), np.zeros((pixels, SQUARES))
        self.earlier: tuple[np.ndarray, np.ndarray] | None = None
        self.branches = np.full(pixels, scene.settings.indirect_paths or START_BRANCHES, np.int32)
        self.shares = False
        self.rate, self.next_update = np.ones(pixels), 0
        self.discarded = np.zeros(pixels * len(DISCARDED), np.int32)
        self.caustics, self.caustic_samples = np.zeros((0, 3)), 0
        self._denoised: np.ndarray | None = None
        self._clean_shadow: np.ndarray | None = None

    def clear(self) -> None:
        """Forget all samples, but not how pixels shall be sampled."""
        for array in (*self.sums.values(), self.light_sums, self.data_sums, self.matte_sums, self.count, self.surfaces):
            array[...] = 0
        for array in (self.divided, self.squares, self.discarded):
            array[...] = 0
        self.samples, self.earlier = 0, None
        self.caustics, self.caustic_samples = np.zeros((0, 3)), 0

    def add_caustics(self, image: np.ndarray, samples: int) -> None:
        """Add the light (pixels, RGB) of caustic paths that so many samples share with them."""
        if not len(self.caustics):
            self.caustics = np.zeros(image.shape)
        self.caustics += samples * image
        self.caustic_samples += samples

    def caustic_light(self) -> np.ndarray:
        """(pixels, RGB) mean of the light of caustic paths; no rows, where there are none."""
        return self.caustics / max(self.caustic_samples, 1)

    def read(self, name: str, rows: slice = slice(None)) -> np.ndarray:
        """(height, width, channels) float32 of the pass ``name``, from the samples so far; of the given rows, or of
        all."""
        item = self._table[name]
        if name == "Combined" and self._denoised is not None:
            return self._denoised[rows]

        def of(values: np.ndarray) -> np.ndarray:
            """The values of the rows' pixels, (pixels, channels)."""
            found = values.reshape(self.height, self.width, -1)[rows]
            return found.reshape(-1, found.shape[-1])

        if item.rule is Rule.COUNT:
            return of(self.count).reshape(-1, self.width, 1).astype(np.float32)
        if item.rule is Rule.RATIO:
            return self._shadow(of)[0].reshape(-1, self.width, 3).astype(np.float32)
        if item.rule is Rule.MATTE:
            return self._matte(item, of).reshape(-1, self.width, 4)
        parts = [of(self.count)]
        parts += [of(values) for values in self._sums_of(item.source)]
        if len(parts) > 2:
            parts.append(of(self.divided)[:, :1])
        if item.per is not None:
            parts += [of(values) for values in self._sums_of(item.per)]
        weight, value, *others = self._settled(parts)
        if item.rule is Rule.WEIGHTED:
            value, weight = value[:, :-1], value[:, -1:]
        if item.rule not in (Rule.FIRST, Rule.NUMBER):
            value /= np.maximum(weight, 1)
        if len(others) > 1:
            value[:, :3] += others[0] / np.maximum(others[1], 1)
        if len(self.caustics) and item.source in SCATTERED:
            value[:, :3] += of(self.caustic_light())
        if item.per is not None:
            color = others[-1] / np.maximum(weight, 1)
            value = np.divide(value, color, out=np.zeros_like(value), where=color != 0.0)
        if item.rule is Rule.COMPLEMENT:
            value = 1.0 - value
        if self.catches and item.source == "combined":
            value = self._caught(value, of)
        if self.catches and item.source == "environment":
            value += of(self._sums_of("backdrop")[0]) / np.maximum(weight, 1)
        if item.light and self.exposure != 1.0:
            value[:, :3] *= self.exposure
        value = np.clip(value, -GREATEST, GREATEST).astype(np.float32)
        if item.channels == "RGBA":
            # Light through several transparent surfaces may exceed what one sample has.
            np.clip(value[:, 3], 0.0, 1.0, out=value[:, 3])
        if name == "Depth":
            value[of(self.surfaces) == 0] = NO_DEPTH
        return value.reshape(-1, self.width, value.shape[-1])

    def _shadow(self, of) -> tuple[np.ndarray, np.ndarray]:
        """(pixels, 3) the effect of other objects on the light of shadow catchers, and that light; of the rows'
        pixels."""
        count, mean = of(self.count), of(self.sums["combined"])[:, 3:] / np.maximum(of(self.count), 1)
        if not self.catches:
            return np.ones((len(count), 3)), np.zeros((len(count), 3))
        before, after = (of(sums) / np.maximum(weight, 1) for sums, weight in self._caught_light(of))
        light, bare = before + after, of(self._sums_of("bare")[0]) / np.maximum(count, 1)
        ratio = np.divide(light, bare, out=np.ones_like(light), where=bare != 0.0)
        alpha = np.clip(mean, 0.0, 1.0)
        seen = of(self._sums_of("caught")[0]) > 0.0
        ratio = np.where(seen, 1.0 - alpha + alpha * ratio, 1.0)
        return (ratio if self._clean_shadow is None else of(self._clean_shadow)), light

    def _caught_light(self, of):
        """Sums of light of shadow catchers before and after the split of paths, and the divisor of each."""
        return zip(self._sums_of(CAUGHT_LIGHT), (of(self.count), of(self.divided)[:, :1]))

    def _caught(self, value: np.ndarray, of) -> np.ndarray:
        """Combined (pixels, 4) of other objects alone, over the shadows on the catchers. As in Cycles, the catchers
        show as darkness, unless they have a separate pass."""
        count = np.maximum(of(self.count), 1)
        shadow, light = self._shadow(of)
        alpha = np.clip(of(self._sums_of("uncaught")[0]) / count, 0.0, 1.0)
        color = value[:, :3] - light
        # If all samples have hit catchers, only rounding is left of the difference.
        color = np.where(np.abs(color) > 1e-9 * np.abs(value[:, :3]), color, 0.0)
        if "Shadow Catcher" not in self.passes:
            alpha = alpha + (1.0 - alpha) * (1.0 - np.clip(shadow.mean(1, keepdims=True), 0.0, 1.0))
            if not self._transparent:
                seen = (of(self._sums_of("backdrop")[0]) + of(self.sums["environment"])) / count
                color, alpha = color + seen * (1.0 - alpha), np.ones_like(alpha)
        return np.concatenate([color, alpha], 1)

    def replace_shadow(self, shadow: np.ndarray) -> None:
        """Use ``shadow`` (height, width, RGB), the denoised pass, as the light of shadow catchers."""
        self._clean_shadow = shadow.reshape(-1, 3)

    def _matte(self, item: Pass, of) -> np.ndarray:
        """(pixels, 4) numbers and coverage of the two objects of a level, the greatest coverage first."""
        count, sums = self._settled([of(self.count), of(self.matte_sums[:, self.matte_places[matte_of(item)]])])
        slots = sums.reshape(len(sums), -1, 2)
        order = np.argsort(-slots[..., 1], axis=1, kind="stable")[:, 2 * item.level : 2 * item.level + 2]
        found = np.take_along_axis(slots, order[..., None], axis=1)
        found[..., 1] /= np.maximum(count, 1)
        return found.reshape(-1, 4).astype(np.float32)

    def _sums_of(self, source: str) -> list[np.ndarray]:
        """(pixels × columns) sums by the name of a source: of light, and of the contributions of branches."""
        if source in self.light_places:
            place, half = self.light_places[source], self.light_sums.shape[1] // 2
            return [self.light_sums[:, at : at + 3] for at in (place, half + place)]
        if source in self.data_places:
            place = self.data_places[source]
            ends = sorted(at for at in self.data_places.values() if at > place)
            return [self.data_sums[:, place : ends[0] if ends else None]]
        return [self.sums[name] for name in (source, SCATTERED.get(source)) if name is not None]

    def _settled(self, parts: list[np.ndarray]) -> list[np.ndarray]:
        """Consistent copies of counts (pixels, 1) and sums (pixels, channels), while threads go on adding.

        Pixels whose count changed during the copy are read again. In the end, only the present pixel of each thread may
        differ by a sample.
        """
        kept, counts = [part.copy() for part in parts], parts[0]
        changed = np.flatnonzero(kept[0] != counts)
        for _ in range(4):
            if not len(changed):
                break
            for copy, part in zip(kept, parts):
                copy[changed] = part[changed]
            changed = changed[(kept[0][changed] != counts[changed])[:, 0]]
        return kept

    def beyond(self, back_end: str) -> list[str]:
        """A sentence about passes whose sums are not in ``CHANNELS``, for a back end that has only those; None if there
        are none."""
        chosen = [self._table[name] for name in self.passes]
        chosen = [item for item in chosen if item.rule is not Rule.RATIO]
        names = [item.name for item in chosen if is_light(item) or data_width(item) or matte_of(item)]
        if not names:
            return []
        told = ", ".join(names)
        return [f"{back_end} leaves these passes black: {told}; choose the CPU as the device to have them."]

    def replace_combined(self, color: np.ndarray) -> None:
        """Show ``color`` (height, width, RGB), exposed, as the Combined pass: the denoised picture."""
        picture = self.read("Noisy Image")
        picture[..., :3] = color
        self._denoised = picture

    def light(self) -> tuple[np.ndarray, np.ndarray]:
        """(pixels, RGB) means of all samples, and of "half" alone."""
        caustics = self.caustic_light() if len(self.caustics) else 0.0
        return tuple(
            self.sums[name].reshape(len(self.count), -1)[:, :3] / np.maximum(count, 1)[:, None]
            + self.sums[SCATTERED[name]].reshape(-1, 3) / np.maximum(branches, 1)[:, None]
            + caustics
            for name, count, branches in (
                ("combined", self.count, self.divided[:, 0]),
                ("half", half_count(self.count), self.divided[:, 1]),
            )
        )

    def _errors(self) -> tuple[np.ndarray, np.ndarray]:
        """For each pixel (height, width): brightness I, the sum of RGB, and its estimated error |I − A|, where A is the
        mean of "half" alone. If the two halves are independent, I − A has the variance of I itself."""
        shape = (self.height, self.width)
        mean, half = self.light()
        return mean.sum(axis=1).reshape(shape), np.abs(mean - half).sum(axis=1).reshape(shape)

    def variances(self) -> tuple[np.ndarray, np.ndarray]:
        """Two estimates of the variance of each pixel of Noisy Image (height, width), as sums over RGB.

        By the difference of the halves, as in ``_errors``: without bias, but of one pair. By the scatter of samples, as
        if they were independent: surer, but too large where samples are stratified. Neither knows the noise of caustic
        paths. With fewer than ``LEAST_SAMPLES`` samples the first is too large.
        """
        mean, half = self.light()
        total, count = self.squares[:, 2], np.maximum(self.count, 1)
        # Of the sum of RGB: of a grey pixel, three times the sum of the variances.
        scatter = np.maximum(self.squares[:, 1] - total**2 / count, 0.0) / (count * np.maximum(count - 1, 1)) / 3.0
        found = ((mean - half) ** 2).sum(axis=1), scatter
        return tuple(self.exposure**2 * each.reshape(self.height, self.width) for each in found)

    def noise(self) -> float | None:
        """Estimated relative error of the picture: Σ |error| / Σ brightness over its pixels. None if there are too few
        samples."""
        known = (self.count >= LEAST_SAMPLES).reshape(self.height, self.width)
        if not known.any():
            return None
        brightness, error = self._errors()
        total = brightness[known].sum()
        return float(error[known].sum() / total) if total > 0.0 else 0.0

    def update_active(self, threshold: float) -> bool:
        """Stop sampling pixels whose error is below ``threshold``. Returns False when none are left.

        The error is |I − A| / √I of the exposed picture, between absolute and relative, and |I − A| / I above I = 1.
        Cycles uses the same error, and its threshold is a fifth of it. The largest error of the 3 × 3 neighbourhood
        counts, so that one lucky pixel does not stop early. A stopped pixel does not start again: its samples stay a
        prefix of its stratified pattern.
        """
        brightness, error = self._errors()
        exposed = self.exposure * np.maximum(brightness, 1e-8)
        error = self.exposure * error / np.where(exposed < 1.0, np.sqrt(exposed), exposed)
        error[(self.count < LEAST_SAMPLES).reshape(error.shape)] = np.inf
        padded = np.pad(error, 1, mode="edge")
        rows = np.maximum(np.maximum(padded[:-2], padded[1:-1]), padded[2:])
        largest = np.maximum(np.maximum(rows[:, :-2], rows[:, 1:-1]), rows[:, 2:])
        self.active &= (largest > threshold).ravel()
        return bool(self.active.any())

    def discarded_report(self) -> str | None:
        """One sentence about samples that were not finite, or pixels that are too bright for the numbers of a picture;
        None if there are none."""
        counts = self.discarded.reshape(-1, len(DISCARDED))
        if not counts.any():
            brightest = np.abs(self.light()[0]).max(axis=1) * self.exposure
            if not brightest.max(initial=0.0) > GREATEST:
                return None
            y, x = divmod(int(brightest.argmax()), self.width)
            return (
                f"Pixel ({x + self.window[0]}, {y + self.window[1]}) and others are brighter than a picture can "
                f"store, and are clamped to {GREATEST:.2g}: look there for a material or a light with an extreme "
                "value."
            )
        totals = zip(counts.sum(axis=0, dtype=np.int64), DISCARDED)
        kinds = " and ".join(f"{count} {kind}" for count, kind in totals if count)
        y, x = divmod(int(counts.sum(axis=1).argmax()), self.width)
        return (
            f"{kinds} samples were left out, most of them at pixel ({x + self.window[0]}, {y + self.window[1]}): "
            "look there for a material or a light with an extreme value."
        )
