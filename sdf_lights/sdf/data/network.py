# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Neural fields: a SIREN, a small network of sines (Sitzmann, Martel, Bergman, Lindell and Wetzstein 2020), as a shape.

h₀ is the point in metres, hₖ = sin ω (Wₖ hₖ₋₁ + bₖ), and the field is W h + b of the last layer. It is negative inside.
A file ``.npz`` holds it:

- ``weight_0``, ``bias_0``, ``weight_1``, …: floats of the shapes (out, in) and (out,). The first has 3 inputs, the last
  1 output.
- ``omega``: ω, one number. Without it, ω is 30.
- ``low``, ``high``: corners (3,) of the box in metres that the network is good in. Without them, they are −1 and 1. The
  shape is what is negative in that box.

Bounds over a box go from layer to layer: values in interval arithmetic, derivatives by interval Jacobians, and values
again by the mean value theorem from these. How far derivatives deviate is bounded three times: by intervals, by the
norms of a layer and of its rows, and to second order by the curvature at the middle of the box, which is the closest in
small boxes. Boxes that are divided where the slope is loose give the Lipschitz constant; the product of the norms of
all layers bounds it, too.
"""

from __future__ import annotations

import dataclasses
import math
import pathlib
import zipfile

import numpy as np

from ...frozen import frozen
from ...graph.formula import Formula, Vector, call, clamp, maximum
from ...graph.functions import Function, TableFunction, evaluate
from ...graph.tables import Table, table
from ...interruption import check
from ...jit import doubles_at, kernel, stack_array
from ..shapes.base import LARGEST, NONE, SMALLEST, Shape, Slots
from ..shapes.primitives import Box

MOST_LAYERS, WIDTH = 8, 256  # hidden layers, and neurons of one
MOST_BYTES = 1 << 24  # of a file, and of what is in it
STEEPEST = 1e4  # sum of the sizes of a neuron's weights, times ω: sines of more have no digits left
OMEGA = 30.0

EXAMPLE = pathlib.Path(__file__).with_name("rabbit.npz")
"""A network that ``scripts/fit_network`` made."""

# numbers before the layers: how many are hidden, the Lipschitz constant, the box (6), the greatest slope along an axis
_HEAD = 16
_ROUNDING = 1e-13  # of a layer, relative to the sum of its weights
_GRADIENT, _CURVATURE = 3 * WIDTH, 6 * WIDTH


@kernel(forceinline=True)
def _sine(x):
    """sin x, to rounding where |x| is below 1e5: a polynomial after the count of half turns is taken off."""
    count = math.floor(x * (1.0 / math.pi) + 0.5)
    # π in three parts, of which the first two have few enough digits that their products are exact.
    x = ((x - count * 3.14159250259399414062) - count * 1.509957883172319271e-7) - count * 1.078060571631623810e-14
    sign = 1.0 - 2.0 * (count - 2.0 * math.floor(0.5 * count))
    s = x * x
    even = 1.0 / 355687428096000.0 - s * (1.0 / 121645100408832000.0)
    even = 1.0 / 6227020800.0 - s * (1.0 / 1307674368000.0 - s * even)
    even = 1.0 / 362880.0 - s * (1.0 / 39916800.0 - s * even)
    even = 1.0 / 120.0 - s * (1.0 / 5040.0 - s * even)
    return sign * (x - x * s * (1.0 / 6.0 - s * even))


@kernel(forceinline=True)
def _sines(low, high):
    """Least and greatest sine of numbers from ``low`` to ``high``."""
    turn, quarter = 1.0 / (2.0 * math.pi), 0.25
    first, last = _sine(low), _sine(high)
    low, high = turn * low - 1e-9, turn * high + 1e-9
    least = -1.0 if math.floor(high + quarter) > math.floor(low + quarter) else min(first, last)
    most = 1.0 if math.floor(high - quarter) > math.floor(low - quarter) else max(first, last)
    return least, most


@kernel(forceinline=True)
def _apply(numbers, at, inputs, outputs, values, out):
    """out = W values + b of the layer at ``at``. Outputs lie side by side, so several are computed at once."""
    for j in range(outputs):
        out[j] = numbers[at + inputs * outputs + j]
    for i in range(inputs):
        value, row = values[i], at + i * outputs
        for j in range(outputs):
            out[j] += value * numbers[row + j]


@kernel
def network_value(address, x, y, z):
    """The field at a point, of the kind ``TableFunction``."""
    numbers = doubles_at(address)
    values, sums = stack_array(WIDTH), stack_array(WIDTH)
    values[0], values[1], values[2] = x, y, z
    at, inputs = _HEAD, 3
    for _ in range(int(numbers[0])):
        outputs = int(numbers[at])
        _apply(numbers, at + 8, inputs, outputs, values, sums)
        for j in range(outputs):
            values[j] = _sine(sums[j])
        at += 8 + outputs * (inputs + 2)
        inputs = outputs
    value = numbers[at + 8 + inputs]
    for i in range(inputs):
        value += values[i] * numbers[at + 8 + i]
    return value


@kernel
def network_slope(address, x, y, z):
    """Its derivatives."""
    numbers = doubles_at(address)
    values, sums = stack_array(WIDTH), stack_array(WIDTH)
    slopes, turned = stack_array(_GRADIENT), stack_array(_GRADIENT)
    values[0], values[1], values[2] = x, y, z
    slopes[0] = slopes[WIDTH + 1] = slopes[2 * WIDTH + 2] = 1.0
    slopes[1] = slopes[2] = slopes[WIDTH] = slopes[WIDTH + 2] = slopes[2 * WIDTH] = slopes[2 * WIDTH + 1] = 0.0
    at, inputs = _HEAD, 3
    for _ in range(int(numbers[0])):
        outputs = int(numbers[at])
        _apply(numbers, at + 8, inputs, outputs, values, sums)
        for j in range(_GRADIENT):
            turned[j] = 0.0
        for i in range(inputs):
            row = at + 8 + i * outputs
            for axis in range(3):
                slope, place = slopes[axis * WIDTH + i], axis * WIDTH
                for j in range(outputs):
                    turned[place + j] += slope * numbers[row + j]
        for j in range(outputs):
            values[j] = _sine(sums[j])
            cosine = _sine(sums[j] + 0.5 * math.pi)
            for axis in range(3):
                slopes[axis * WIDTH + j] = cosine * turned[axis * WIDTH + j]
        at += 8 + outputs * (inputs + 2)
        inputs = outputs
    gx, gy, gz = 0.0, 0.0, 0.0
    for i in range(inputs):
        weight = numbers[at + 8 + i]
        gx += weight * slopes[i]
        gy += weight * slopes[WIDTH + i]
        gz += weight * slopes[2 * WIDTH + i]
    return gx, gy, gz


@kernel(forceinline=True)
def _pair(a, b):
    """Where the second derivative by two axes stands."""
    return max(a, b) * (max(a, b) + 1) // 2 + min(a, b)


@kernel
def network_bounds(address, x_low, x_high, y_low, y_high, z_low, z_high):
    """Bounds of the field and its derivatives in a box.

    With δ the way from its middle, z + J δ is a sum of a layer to first order, and J + H δ its derivatives, H
    symmetric. What is missing in J + H δ is bounded by ``rest``, all that J changes by ``spread``, of which there is a
    second bound by intervals alone.
    """
    numbers = doubles_at(address)
    half = 0.5 * (x_high - x_low), 0.5 * (y_high - y_low), 0.5 * (z_high - z_low)
    along = numbers[8]
    if not (half[0] + half[1] + half[2] < 1e9 and abs(x_low) + abs(y_low) + abs(z_low) < 1e9):
        return -math.inf, math.inf, -along, along, -along, along, -along, along
    # Of each neuron: the value at the middle of the box, and the middle and half the width of its bounds.
    point, middle, reach = stack_array(WIDTH), stack_array(WIDTH), stack_array(WIDTH)
    to_point, to_middle, to_reach = stack_array(WIDTH), stack_array(WIDTH), stack_array(WIDTH)
    slope, spread, rest = stack_array(_GRADIENT), stack_array(_GRADIENT), stack_array(_GRADIENT)
    to_slope, to_spread, to_rest = stack_array(_GRADIENT), stack_array(_GRADIENT), stack_array(_GRADIENT)
    curve, to_curve = stack_array(_CURVATURE), stack_array(_CURVATURE)
    # By axis: what the length of the vector of the deviations of all neurons is at most, and parts of it.
    length, sums, added = stack_array(4), stack_array(4), stack_array(4)
    for j in range(_GRADIENT):
        slope[j] = spread[j] = rest[j] = 0.0
    for j in range(_CURVATURE):
        curve[j] = 0.0
    point[0], point[1], point[2] = 0.5 * (x_low + x_high), 0.5 * (y_low + y_high), 0.5 * (z_low + z_high)
    size = 1.0
    for axis in range(3):
        length[axis] = 0.0
        middle[axis], reach[axis] = point[axis], half[axis] * (1.0 + 1e-12)
        slope[axis * WIDTH + axis] = 1.0
        size = max(size, abs(point[axis]) + half[axis])
    at, inputs, error, steepest, bent = _HEAD, 3, 1e-15 * size, 1.0, 0.0
    layers = int(numbers[0])
    for layer in range(layers + 1):
        outputs = int(numbers[at])
        weights = at + 8
        for j in range(outputs):
            to_point[j] = to_middle[j] = numbers[weights + inputs * outputs + j]
            to_reach[j] = 0.0
        for j in range(_GRADIENT):
            to_slope[j] = to_spread[j] = to_rest[j] = 0.0
        for j in range(_CURVATURE):
            to_curve[j] = 0.0
        for i in range(inputs):
            row, p, m, r = weights + i * outputs, point[i], middle[i], reach[i]
            for j in range(outputs):
                weight = numbers[row + j]
                to_point[j] += weight * p
                to_middle[j] += weight * m
                to_reach[j] += abs(weight) * r
            for axis in range(3):
                place = axis * WIDTH
                p, r, m = slope[place + i], spread[place + i], rest[place + i]
                for j in range(outputs):
                    weight = numbers[row + j]
                    to_slope[place + j] += weight * p
                    to_spread[place + j] += abs(weight) * r
                    to_rest[place + j] += abs(weight) * m
            for pair in range(6):
                place = pair * WIDTH
                p = curve[place + i]
                for j in range(outputs):
                    to_curve[place + j] += numbers[row + j] * p
        total = numbers[at + 1]  # the greatest sum of the sizes of a neuron's weights
        error = total * (error + _ROUNDING * size)
        margin = _ROUNDING * total * (steepest + bent)
        size = steepest = 1.0
        bent = 0.0
        norms, norm = weights + (inputs + 1) * outputs, numbers[at + 2] * (1.0 + 1e-9)
        for axis in range(3):
            sums[axis] = added[axis] = 0.0
            for j in range(outputs):
                place = axis * WIDTH + j
                turn = 0.0
                for other in range(3):
                    turn += abs(to_curve[_pair(axis, other) * WIDTH + j]) * half[other]
                # A sum is at most what the lengths of both vectors allow: not all neurons deviate the most at once.
                to_spread[place] = min(
                    min(to_spread[place], numbers[norms + j] * length[axis]), (turn + to_rest[place]) * (1.0 + 1e-12)
                )
                to_spread[place] += margin
                to_rest[place] += margin
                sums[axis] += to_spread[place] * to_spread[place]
            length[axis] = min(math.sqrt(sums[axis]) * (1.0 + 1e-9), norm * length[axis] + margin * outputs)
            sums[axis] = 0.0
        for j in range(outputs):
            deviation = error
            for axis in range(3):
                place = axis * WIDTH + j
                deviation += half[axis] * (abs(to_slope[place]) + to_spread[place])
            low = max(to_point[j] - deviation, to_middle[j] - to_reach[j] - error)
            high = min(to_point[j] + deviation, to_middle[j] + to_reach[j] + error)
            to_middle[j], to_reach[j] = 0.5 * (low + high), max(0.5 * (high - low), 0.0)
        if layer == layers:
            break
        greatest = 0.0
        for j in range(outputs):
            low, high = to_middle[j] - to_reach[j], to_middle[j] + to_reach[j]
            least, most = _sines(low, high)
            point[j] = _sine(to_point[j])
            middle[j], reach[j] = 0.5 * (least + most), 0.5 * (most - least)
            least, most = _sines(low + 0.5 * math.pi, high + 0.5 * math.pi)
            first, second = _sine(to_point[j] + 0.5 * math.pi), -point[j]
            width = max(most - first, first - least)
            greatest = max(greatest, abs(first))
            linear, missing = 0.0, error
            for axis in range(3):
                place = axis * WIDTH + j
                linear += half[axis] * abs(to_slope[place])
                missing += half[axis] * to_spread[place]
            whole = linear + missing
            missing = 0.5 * whole * whole + abs(second) * missing  # of the cosine to first order
            for axis in range(3):
                place = axis * WIDTH + j
                p, r = to_slope[place], to_spread[place]
                own = width * (abs(p) + r)
                spread[place] = abs(first) * r + own
                rest[place] = abs(first) * to_rest[place] + missing * (abs(p) + r) + abs(second) * linear * r
                sums[axis] += spread[place] * spread[place]
                added[axis] += own * own
                steepest = max(steepest, abs(p) + r)
                slope[place] = first * p
                for other in range(axis + 1):
                    at_pair = _pair(axis, other) * WIDTH + j
                    curve[at_pair] = first * to_curve[at_pair] + second * p * to_slope[other * WIDTH + j]
                    bent = max(bent, abs(curve[at_pair]))
        for axis in range(3):
            least = min(math.sqrt(sums[axis]), greatest * length[axis] + math.sqrt(added[axis]))
            length[axis] = least * (1.0 + 1e-9)
        at += 8 + outputs * (inputs + 2)
        inputs = outputs
    x, y, z = to_slope[0], to_slope[WIDTH], to_slope[2 * WIDTH]
    rx, ry, rz = to_spread[0], to_spread[WIDTH], to_spread[2 * WIDTH]
    low, high = to_middle[0] - to_reach[0], to_middle[0] + to_reach[0]
    return low, high, x - rx, x + rx, y - ry, y + ry, z - rz, z + rz


_GLSL = f"""\
float network(int table, float x, float y, float z)
{{
    float values[{WIDTH}], sums[{WIDTH}];
    values[0] = x;
    values[1] = y;
    values[2] = z;
    int at = table + {_HEAD};
    int inputs = 3;
    int layers = int(table_number(table));
    for (int layer = 0; layer <= layers; layer++) {{
        int outputs = int(table_number(at));
        at += 8;
        for (int j = 0; j < outputs; j++) {{
            float sum = table_number(at + inputs * outputs + j);
            for (int i = 0; i < inputs; i++) {{
                sum += values[i] * table_number(at + i * outputs + j);
            }}
            sums[j] = sum;
        }}
        for (int j = 0; j < outputs && layer < layers; j++) {{
            values[j] = sin(sums[j]);
        }}
        at += outputs * (inputs + 2);
        inputs = outputs;
    }}
    return sums[0];
}}
"""

NETWORK = TableFunction(
    "network",
    network_value,
    bounds=Function("network_bounds", network_bounds, results=8),
    derivatives=Function("network_slope", network_slope, results=3),
    glsl=_GLSL,
    operations=200.0,
    boxes=8,
)


class NetworkError(ValueError):
    """A file is no network: the rest of a sentence that names it."""


class Siren:
    """Weights (out, in) and biases (out,) of layers, ω, and the box (2, 3) in metres: what a file holds."""

    def __init__(
        self, weights: list[np.ndarray], biases: list[np.ndarray], omega: float = OMEGA, box=((-1,) * 3, (1,) * 3)
    ):
        self.weights = [np.asarray(weight, np.float64) for weight in weights]
        self.biases = [np.asarray(bias, np.float64) for bias in biases]
        self.omega, self.box = float(omega), np.asarray(box, np.float64)

    def values(self, points: np.ndarray) -> np.ndarray:
        """The field (n,) at points (n, 3), in NumPy."""
        values = points
        for weight, bias in zip(self.weights[:-1], self.biases):
            values = np.sin(self.omega * (values @ weight.T + bias))
        return (values @ self.weights[-1].T + self.biases[-1])[:, 0]

    def save(self, path: pathlib.Path) -> None:
        """Write a file, in float32."""
        arrays = dict(omega=self.omega, low=self.box[0], high=self.box[1])
        for index, (weight, bias) in enumerate(zip(self.weights, self.biases)):
            arrays |= {f"weight_{index}": weight, f"bias_{index}": bias}
        np.savez_compressed(path, **{name: np.float32(array) for name, array in arrays.items()})

    def shape(self) -> "Network":
        """The lamp's shape. Raises NetworkError."""
        _check(self)
        return Network(_table(self))


def read(path: pathlib.Path) -> Siren:
    """The network of a file. Nothing in it is run or unpickled. Raises NetworkError."""
    try:
        if path.stat().st_size > MOST_BYTES:
            raise NetworkError(f"is larger than {MOST_BYTES >> 20} MB: a network of a lamp is smaller.")
        with zipfile.ZipFile(path) as archive:
            if sum(part.file_size for part in archive.infolist()) > MOST_BYTES:
                raise NetworkError(f"holds more than {MOST_BYTES >> 20} MB: a network of a lamp is smaller.")
        with np.load(path, allow_pickle=False) as archive:
            arrays = {name: archive[name] for name in archive.files}
    except FileNotFoundError:
        raise NetworkError("is missing: find it again, or choose another one.") from None
    except (NetworkError, MemoryError):
        raise
    except OSError as error:
        raise NetworkError(f"cannot be read ({error.strerror or error}): choose another one.") from None
    except Exception:  # zipfile, zlib and NumPy's reader of headers raise many kinds for damaged bytes
        raise NetworkError(
            "is damaged, or is no .npz file of plain numbers: write it again, or choose another one."
        ) from None
    return _siren(arrays)


def _siren(arrays: dict[str, np.ndarray]) -> Siren:
    for name, array in arrays.items():
        if array.dtype.kind not in "fiu":
            raise NetworkError(f"has '{name:.40}', which is no array of numbers: see docs/lamps.md for what it needs.")
        if not np.isfinite(array).all():
            raise NetworkError(f"has a number in '{name:.40}' that is not finite: fit the network again.")
    count = sum(name.startswith("weight_") for name in arrays)
    weights, biases = [], []
    for index in range(count):
        for kind, found in (("weight", weights), ("bias", biases)):
            if f"{kind}_{index}" not in arrays:
                raise NetworkError(f"has no array '{kind}_{index}': see docs/lamps.md for what it needs.")
            found.append(arrays[f"{kind}_{index}"])
    numbers = {"omega": np.array(OMEGA), "low": np.full(3, -1.0), "high": np.full(3, 1.0)}
    for name, default in numbers.items():
        numbers[name] = arrays.get(name, default).astype(np.float64)
        if numbers[name].size != default.size:
            raise NetworkError(
                f"has '{name}' of {numbers[name].size} numbers, not {default.size}: see docs/lamps.md for what it needs."
            )
    box = np.stack([numbers["low"].ravel(), numbers["high"].ravel()])
    found = Siren(weights, biases, numbers["omega"].ravel()[0], box)
    _check(found)
    return found


def _check(found: Siren) -> None:
    """Raises NetworkError where the parts do not go together."""
    hidden = len(found.weights) - 1
    if not 1 <= hidden <= MOST_LAYERS:
        raise NetworkError(f"has {max(hidden, 0)} hidden layers, not 1 to {MOST_LAYERS}: fit another network.")
    inputs = 3
    for index, (weight, bias) in enumerate(zip(found.weights, found.biases)):
        outputs = 1 if index == hidden else bias.size
        if not 1 <= outputs <= WIDTH:
            raise NetworkError(f"has a layer of {outputs} neurons, not 1 to {WIDTH}: fit another network.")
        if weight.shape != (outputs, inputs) or bias.shape != (outputs,):
            raise NetworkError(
                f"has 'weight_{index}' of shape {weight.shape} and 'bias_{index}' of shape {bias.shape}, "
                f"not ({outputs}, {inputs}) and ({outputs},): see docs/lamps.md for what it needs."
            )
        scale = abs(found.omega) if index < hidden else 1.0
        inputs = outputs
        if not scale * (np.abs(weight).sum(axis=1) + np.abs(bias)).max() <= STEEPEST:
            raise NetworkError(f"has weights in 'weight_{index}' that are too large: fit the network again.")
    low, high = found.box
    if not ((high - low >= SMALLEST).all() and np.abs(found.box).max() <= 1e3):
        raise NetworkError(
            "has a box 'low' to 'high' that is empty, or larger than 1000 m: see docs/lamps.md for what it needs."
        )


def _table(found: Siren) -> Table:
    """Numbers of the network, with ω in the weights, inputs before outputs, and neurons without effect up to a multiple
    of eight."""
    hidden = len(found.weights) - 1
    head = np.zeros(_HEAD)
    head[0] = hidden
    head[2:8] = found.box.ravel()
    parts, inputs, product = [head], 3, 1.0
    for index, (weight, bias) in enumerate(zip(found.weights, found.biases)):
        is_last = index == hidden
        outputs = 1 if is_last else -(-len(bias) // 8) * 8
        scale = 1.0 if is_last else found.omega
        padded, shift = np.zeros((inputs, outputs)), np.zeros(outputs)
        padded[: weight.shape[1], : len(bias)], shift[: len(bias)] = scale * weight.T, scale * bias
        start = np.zeros(8)
        norm = float(np.linalg.norm(padded, 2))
        start[:3] = outputs, (np.abs(padded).sum(axis=0) + np.abs(shift)).max(), norm
        parts += [start, padded.ravel(), shift, np.linalg.norm(padded, axis=0) * (1.0 + 1e-9)]
        product *= norm
        inputs = outputs
    numbers = np.concatenate(parts)
    numbers[1] = numbers[8] = product * (1.0 + 1e-9)
    numbers[1] = numbers[8] = min(numbers[1], _steepest(table(numbers), found.box))
    return table(numbers)


_SIDE, _TOGETHER, _LOOSE = 12, 2048, 1.1
_WORK = 2e8  # weights times boxes that are bounded: about a second


def _steepest(numbers: Table, box: np.ndarray) -> float:
    """A Lipschitz constant of the field in its box: the greatest bound of boxes, divided where they are loose."""
    steps = np.stack(np.meshgrid(*[np.arange(_SIDE)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    size = (box[1] - box[0]) / _SIDE
    low = box[0] + steps * size
    high = low + size * (1.0 + 1e-9)
    corner = np.stack(np.meshgrid(*[(0.0, 1.0)] * 3, indexing="ij"), axis=-1).reshape(8, 1, 3)
    pending, bounds, occurring, spent = np.zeros((0, 2, 3)), np.zeros(0), 0.0, 0
    while True:
        check()
        found = evaluate(NETWORK.bounds, [float(numbers.address), *np.stack([low, high], axis=2).reshape(-1, 6).T])
        lengths = np.sqrt(sum(np.maximum(np.abs(a), np.abs(b)) ** 2 for a, b in zip(found[2::2], found[3::2])))
        slopes = evaluate(NETWORK.derivatives, [float(numbers.address), *(0.5 * (low + high)).T])
        occurring = max(occurring, float(np.sqrt(sum(slope**2 for slope in slopes)).max()))
        pending = np.concatenate([pending, np.stack([low, high], axis=1)])
        bounds = np.concatenate([bounds, np.where(np.isnan(lengths), np.inf, lengths)])
        spent += len(low)
        worst = np.argsort(bounds)[: -_TOGETHER - 1 : -1]
        worst = worst[bounds[worst] > _LOOSE * occurring]
        if not len(worst) or spent * len(numbers.array) >= _WORK:
            return float(bounds.max()) * (1.0 + 1e-9)
        parts = pending[worst]
        pending, bounds = np.delete(pending, worst, axis=0), np.delete(bounds, worst)
        middle = 0.5 * (parts[:, 0] + parts[:, 1])
        low = np.where(corner, middle, parts[:, 0]).reshape(-1, 3)
        high = np.where(corner, parts[:, 1], middle).reshape(-1, 3)


@frozen
class Network(Shape, abstract=True):
    """What a network is negative in, within its box."""

    exactness = NONE

    data: Table = dataclasses.field(metadata=dict(description="its weights, see ``_table``"))

    @property
    def lipschitz(self) -> float:  # type: ignore[override]
        return max(float(self.data.array[1]), 1.0)

    @property
    def box(self) -> np.ndarray:
        """Corners (2, 3) of the box that the network is good in."""
        return self.data.array[2:8].reshape(2, 3)

    def build(self, p: Vector, slot: Slots) -> Formula:
        low, high = self.box
        within = [clamp(part, slot(a), slot(b)) for part, a, b in zip(p, low, high)]
        (value,) = call(NETWORK, slot(self.data.address), *within)
        middle = Vector(*(slot(number) for number in 0.5 * (low + high)))
        return maximum(value, Box(tuple(0.5 * (high - low))).build(p - middle, slot))

    def bounds(self, matrix: np.ndarray | None = None) -> tuple[np.ndarray, np.ndarray]:
        middle, half = 0.5 * self.box.sum(axis=0), 0.5 * (self.box[1] - self.box[0])
        if matrix is not None:
            middle, half = matrix[:3, :3] @ middle + matrix[:3, 3], np.abs(matrix[:3, :3]) @ half
        return middle - half, middle + half

    def growth(self, matrix: np.ndarray | None = None) -> np.ndarray:
        # Outside of the box the field is at least the distance to it.
        return np.ones(3) if matrix is None else np.linalg.norm(matrix[:3, :3], axis=1)

    def relation(self) -> str:
        return "" if np.abs(self.box).max() <= LARGEST else "Network: its box is too far from the origin."
