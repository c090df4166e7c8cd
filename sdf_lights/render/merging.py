# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""One picture from several renders that shared its samples, pass by pass.

Means are weighted by the number of samples that each render was given. No pixel's noise influences it, so the joined
picture has no bias, even if pixels took more or fewer samples.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence

import numpy as np

from ..frozen import frozen
from .film import NO_DEPTH
from .passes import MATTES, OLD_NAMES, PASSES, Pass, Rule

_PREFIX = "sdf_lights"


class MergeError(Exception):
    """One sentence for the user."""


@frozen
class Share:
    """The samples of a render: ``count`` of the pattern of ``seed``, from number ``first`` on."""

    seed: int
    first: int
    count: int

    def metadata(self, layer: str) -> dict[str, str]:
        """The metadata of a view layer in a file."""
        return {f"{_PREFIX}.{layer}.{name}": str(value) for name, value in vars(self).items()}

    def overlaps(self, other: Share) -> bool:
        """Whether some samples are the same."""
        return (
            self.seed == other.seed and self.first < other.first + other.count and other.first < self.first + self.count
        )


Shares = tuple[Share, ...]
_JOINED = "joined"  # of a file that was joined: the numbers of all its shares


def shares(metadata: Mapping[str, str]) -> dict[str, Shares]:
    """The shares of each view layer, from the metadata of a file."""
    found: dict[str, dict[str, list[int]]] = {}
    for key, value in metadata.items():
        prefix, _, rest = key.partition(".")
        layer, _, name = rest.rpartition(".")
        words = str(value).split()
        if prefix == _PREFIX and all(map(str.isdecimal, words)):
            found.setdefault(layer, {})[name] = [int(word) for word in words]
    return {layer: told for layer, numbers in found.items() if (told := _told(numbers))}


def _told(numbers: Mapping[str, list[int]]) -> Shares:
    width = len(Share.__annotations__)
    flat = numbers.get(_JOINED) or [number for name in Share.__annotations__ for number in numbers.get(name, ())]
    if len(flat) % width:
        return ()
    return tuple(Share(*flat[start : start + width]) for start in range(0, len(flat), width))


def joined(parts: Sequence[Share]) -> Shares:
    """The shares of a joined file, in order: adjoining ranges become one."""
    found: list[Share] = []
    for part in sorted(parts, key=lambda part: (part.seed, part.first)):
        last = found[-1] if found else None
        if last is not None and last.seed == part.seed and last.first + last.count == part.first:
            found[-1] = Share(last.seed, last.first, last.count + part.count)
        else:
            found.append(part)
    return tuple(found)


def joined_metadata(layer: str, parts: Shares) -> dict[str, str]:
    """The metadata of a view layer in a joined file."""
    numbers = (str(value) for part in parts for value in vars(part).values())
    whole = Share(parts[0].seed, parts[0].first, sum(part.count for part in parts))
    return whole.metadata(layer) | {f"{_PREFIX}.{layer}.{_JOINED}": " ".join(numbers)}


_BY_NAME = {item.name: item for item in PASSES} | {
    OLD_NAMES[item.name]: item for item in PASSES if item.name in OLD_NAMES
}
_COLORS = {item.source: item.name for item in PASSES if item.source in {other.per for other in PASSES if other.per}}


@frozen
class Layer:
    """The passes of a view layer in a file, (height, width, channels) float32 by the name of the pass, in one view."""

    shares: Shares
    passes: dict[str, np.ndarray]


def merge(layers: Sequence[Layer]) -> dict[str, np.ndarray]:
    """The passes of all ``layers`` together. They have the same passes and sizes. Raises MergeError if two of them have
    the same samples."""
    layers = sorted(layers, key=lambda layer: layer.shares[0].first)
    for index, layer in enumerate(layers):
        for own, other in itertools.product(layer.shares, (share for one in layers[:index] for share in one.shares)):
            if own.overlaps(other):
                raise MergeError(
                    f"two renders have the same samples ({_range(other)} and {_range(own)}, seed "
                    f"{own.seed}): give each a separate range with --sdf-samples, or another seed"
                )
    weights = np.array([sum(share.count for share in layer.shares) for layer in layers], float)
    weights /= weights.sum()
    found = {name: _merged(name, layers, weights) for name in layers[0].passes if _matte_kind(name) is None}
    for kind in MATTES.values():
        names = sorted(name for name in layers[0].passes if _matte_kind(name) == kind)
        if names:
            found |= _merged_mattes(names, layers, weights)
    return found


def _range(share: Share) -> str:
    return f"{share.first} to {share.first + share.count - 1}"


def _matte_kind(name: str) -> str | None:
    return next((kind for kind in MATTES.values() if name.startswith(kind) and name[len(kind) :].isdecimal()), None)


def _merged(name: str, layers: Sequence[Layer], weights: np.ndarray) -> np.ndarray:
    item, values = _BY_NAME.get(name), [layer.passes[name] for layer in layers]
    if item is None:
        return _mean(values, weights)
    if item.rule is Rule.COUNT:
        return np.sum(values, axis=0)
    if item.rule is Rule.NUMBER:
        return values[0]
    if item.rule is Rule.FIRST:
        return _first(name, layers)
    if item.rule is Rule.WEIGHTED:
        met = [value.any(axis=2, keepdims=True) for value in values]
        total = sum(weight * there for weight, there in zip(weights, met))
        return (_mean(values, weights) / np.where(total > 0.0, total, 1.0)).astype(np.float32)
    if item.per is not None:
        return _over_color(item, values, layers, weights)
    return _mean(values, weights)


def _mean(values: Sequence[np.ndarray], weights: np.ndarray) -> np.ndarray:
    total = sum(weight * value.astype(np.float64) for weight, value in zip(weights, values))
    return total.astype(np.float32)


def _first(name: str, layers: Sequence[Layer]) -> np.ndarray:
    """From the first render whose samples have hit a surface there."""
    found = layers[0].passes[name].copy()
    for layer in layers[1:]:
        empty = found[..., :1] >= NO_DEPTH if name == "Depth" else ~found.any(axis=2, keepdims=True)
        found = np.where(empty, layer.passes[name], found)
    return found


def _over_color(item: Pass, values, layers: Sequence[Layer], weights: np.ndarray) -> np.ndarray:
    """Light over the colour of its lobe: the quotient of the means, if the file has the colour."""
    wanted = _COLORS[item.per or ""]
    color = next((name for name in (wanted, OLD_NAMES[wanted]) if name in layers[0].passes), None)
    if color is None:
        return _mean(values, weights)
    colors = [layer.passes[color] for layer in layers]
    light, whole = _mean([a * b for a, b in zip(values, colors)], weights), _mean(colors, weights)
    return np.divide(light, whole, out=np.zeros_like(light), where=whole != 0.0)


def _merged_mattes(names: Sequence[str], layers: Sequence[Layer], weights: np.ndarray) -> dict[str, np.ndarray]:
    """Object numbers with the coverage of all renders, the greatest first; those without room are dropped."""
    parts = []
    for layer, weight in zip(layers, weights):
        slots = np.concatenate([layer.passes[name] for name in names], axis=2)
        slots = slots.reshape(*slots.shape[:2], -1, 2).astype(np.float64)
        slots[..., 1] *= weight
        parts.append(slots)
    slots = np.concatenate(parts, axis=2)
    order = np.argsort(slots[..., 0], axis=2, kind="stable")
    slots = np.take_along_axis(slots, order[..., None], axis=2)
    number, cover = slots[..., 0], slots[..., 1]
    # Coverage of equal numbers is summed in the first slot of each.
    for index in range(number.shape[2] - 1, 0, -1):
        same = number[..., index] == number[..., index - 1]
        cover[..., index - 1] += np.where(same, cover[..., index], 0.0)
        cover[..., index] = np.where(same, 0.0, cover[..., index])
        number[..., index] = np.where(same, 0.0, number[..., index])
    order = np.argsort(-cover, axis=2, kind="stable")[..., : 2 * len(names)]
    slots = np.take_along_axis(slots, order[..., None], axis=2).astype(np.float32)
    return {
        name: slots[..., 2 * place : 2 * place + 2, :].reshape(*slots.shape[:2], 4) for place, name in enumerate(names)
    }
