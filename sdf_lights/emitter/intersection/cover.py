# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""All zeros of a field along a ray, by covering the ray with balls that contain none.

Let the field fall by at most the rate F per unit of the ray's parameter, and rise by at most the rate R. Then a value v
> 0 at t proves that there is no zero from t − v/R to t + v/F. For a value below zero, exchange F and R. Sphere tracing
(Hart 1996) uses the half of that ball ahead of the point. Here both halves count. Values anywhere along the ray can be
evaluated, so eight are evaluated at a time. A *gap* lies between two neighbouring values and is covered by neither:

- no gap is left, or the field is monotonic there: there is one zero if the signs differ, and none if they agree;
- the gap is shorter than the tolerance: the same is assumed, and the gap counts as unresolved;
- else the field is evaluated within the gap, which splits it into two gaps, or three.

So every two zeros farther apart than the tolerance are found, if the rates are right. A single zero between two values
is then located by the bracketing method of Chandrupatla 1997, "A new hybrid quadratic/bisection algorithm for finding
the zero of a nonlinear function without using derivatives".

``pending`` is a stack of entries: parts of the ray between two values, with their rates. Its size and the number of
rounds are bounded. The tolerance grows when a ray takes many rounds, so that every part gets its share. The assumed
parts are counted.
"""

from __future__ import annotations

import math

from ...jit import kernel
from .fields import LANES, VALUES, evaluate

# Columns of an entry. In a bracket with a third point, FALL and RISE hold that point and its value: rates are not
# needed any more.
START, AT_START, END, AT_END, FALL, RISE, STATE, POINTS, COLUMNS = range(9)
OPEN, NEW, OLD = 0.0, 1.0, 2.0  # states: a part to be covered; a bracket of one zero, without and with a third point

PENDING = 256  # entries in ``pending``; behind them are those of a round, and the points of evaluation
ASKED = (PENDING + LANES) * COLUMNS
PENDING_SIZE = ASKED + LANES  # number of float64 in ``pending``: jit.stack_array(PENDING_SIZE)

SIGN = 1e-300  # magnitude of a value of which only the sign is known
LARGEST = 1e300  # largest magnitude of a stored value
UNKNOWN = math.nan  # a value not evaluated yet

RESOLUTION = 1e-7  # zeros closer to each other, relative to the lamp's size, may stay unresolved
PRECISION = 1e-12  # of a zero, relative to the lamp's size
ENOUGH = 0.01  # fraction of the precision that the unchecked last step in a bracket may be expected to miss
STEEP = 0.1  # fraction of its greatest rate below which a field between two values counts as a straight line
PAIRS = 2  # points in a gap evaluated at once, if lanes are free
PATIENCE = 16384  # rounds, and sixteen more for each entry at the start, before the tolerance grows …
GROWTH = 1.25  # … by this factor per round
LAST = 200  # rounds after which the rest is counted as it is


@kernel(forceinline=True)
def signed(value):
    """A value as the cover stores it: neither zero nor infinite; NaN counts as outside but proves nothing."""
    if value > 0.0:
        return min(max(value, SIGN), LARGEST)
    if value <= 0.0:
        return max(min(value, -SIGN), -LARGEST)
    return SIGN


@kernel(forceinline=True)
def add(pending, used, start, at_start, end, at_end, fall, rise, state):
    """Append a part of the ray to ``pending``. Returns the new number of entries, at most ``PENDING``.

    At the start its ``state`` is ``OPEN``. ``at_end`` may be ``UNKNOWN``, and so may ``at_start`` if the previous entry
    ends at ``start``.
    """
    place = used * COLUMNS
    pending[place + START], pending[place + AT_START] = start, at_start
    pending[place + END], pending[place + AT_END] = end, at_end
    pending[place + FALL], pending[place + RISE], pending[place + STATE] = fall, rise, state
    return used + 1


@kernel
def insert(spans, limit, count, t):
    """Insert t into the sorted numbers in the first ``limit`` rows of ``spans``. Returns how many there have been.

    If there are too many, the greatest are dropped.
    """
    place = min(count, 2 * limit)
    while place > 0 and spans[(place - 1) >> 1, (place - 1) & 1] > t:
        if place < 2 * limit:
            spans[place >> 1, place & 1] = spans[(place - 1) >> 1, (place - 1) & 1]
        place -= 1
    if place < 2 * limit:
        spans[place >> 1, place & 1] = t
    return count + 1


@kernel(forceinline=True)
def _ask(stack, lane, o, d, t):
    stack[lane] = o[0] + t * d[0]
    stack[LANES + lane] = o[1] + t * d[1]
    stack[2 * LANES + lane] = o[2] + t * d[2]


@kernel(forceinline=True)
def _gap(start, at_start, end, at_end, fall, rise):
    """Ends of the uncovered part between the two values of an entry; in reverse order if there is none."""
    down, up = max(fall, 0.0), max(rise, 0.0)
    low = start + (at_start / down if at_start > 0.0 else -at_start / up)
    high = end - (at_end / up if at_end > 0.0 else -at_end / down)
    return low, high


@kernel(forceinline=True)
def _settle(pending, used, start, at_start, end, at_end, fall, rise, tolerance, precision, spans, limit, found):
    """Append a part unless it is settled. Returns (entries, zeros found so far, unresolved length)."""
    differ = (at_start > 0.0) != (at_end > 0.0)
    monotonic = fall <= 0.0 or rise <= 0.0
    if monotonic and not differ:
        return used, found, 0.0
    unresolved = 0.0
    if not monotonic:
        low, high = _gap(start, at_start, end, at_end, fall, rise)
        if not differ and low >= high:
            return used, found, 0.0
        unresolved = max(high - low, 0.0)
    full = used >= PENDING - LANES
    if unresolved > tolerance and not full:
        return add(pending, used, start, at_start, end, at_end, fall, rise, OPEN), found, 0.0
    if differ:
        if end - start <= precision or full:
            found = insert(spans, limit, found, 0.5 * (start + end))
        else:
            used = add(pending, used, start, at_start, end, at_end, fall, rise, NEW)
    return used, found, unresolved


@kernel
def _joints(block, row, first, count, o, d, pending, used, stack):
    """Evaluate the unknown values at the ends of entries. Returns the number of evaluations."""
    evaluations, entry = 0, 0
    while entry < used:
        lanes, begin = 0, entry
        while entry < used and lanes < LANES:
            if math.isnan(pending[entry * COLUMNS + AT_END]):
                _ask(stack, lanes, o, d, pending[entry * COLUMNS + END])
                lanes += 1
            entry += 1
        if lanes > 0:
            evaluate(block, row, first, count, lanes, stack)
            evaluations += lanes
            lane = 0
            for asked in range(begin, entry):
                if math.isnan(pending[asked * COLUMNS + AT_END]):
                    pending[asked * COLUMNS + AT_END] = signed(stack[VALUES + lane])
                    lane += 1
    for entry in range(1, used):
        place = entry * COLUMNS
        if math.isnan(pending[place + AT_START]):
            pending[place + AT_START] = pending[place - COLUMNS + AT_END]
    return evaluations


@kernel(forceinline=True)
def _points(pending, lane, room, start, at_start, end, at_end, fall, rise):
    """Write points of a gap whose values cover much of it to ``pending``, in order, from ``ASKED`` + ``lane`` on.

    Returns their number, which is at most ``room``.
    """
    asked = ASKED + lane
    low, high = _gap(start, at_start, end, at_end, fall, rise)
    middle = 0.5 * (low + high)
    ahead, behind = (fall, rise) if at_start > 0.0 else (rise, fall)
    pending[asked] = middle
    if (at_start > 0.0) == (at_end > 0.0):
        # A value's ball reaches to different distances on both sides; here it would touch both ends of the gap at once.
        even = low + (high - low) * (ahead / (ahead + behind))
        if low < even < high:
            pending[asked] = even
        return 1
    size_start, size_end = abs(at_start), abs(at_end)
    slope = (size_start + size_end) / (end - start)
    steepness = slope / max(ahead, behind)
    if min(size_start, size_end) <= SIGN or steepness < STEEP:
        return 1
    # On both sides of the zero of the straight line: points whose balls just reach the ends of the gap, and then each
    # other.
    zero = start + size_start / slope
    part = 1.0 / (1.0 + steepness)
    if room == 1:
        wider_before = zero - low > high - zero
        pending[asked] = zero - part * (zero - low) if wider_before else zero + part * (high - zero)
        return 1
    pairs = min(room // 2, PAIRS)
    for pair in range(pairs):
        pending[asked + pair] = zero - part * (zero - low)
        pending[asked + 2 * pairs - 1 - pair] = zero + part * (high - zero)
        part *= (1.0 - steepness) / (1.0 + steepness)
    return 2 * pairs


@kernel(forceinline=True)
def first_estimate(start, at_start, end, at_end, fall, rise):
    """The first point of a new bracket from ``start`` to ``end``: the zero of the straight line. If only the sign is
    known at an end, the point is just behind the zero."""
    known_start, known_end = abs(at_start) > SIGN, abs(at_end) > SIGN
    t = math.nan
    if known_start and known_end:
        t = start + (end - start) * (at_start / (at_start - at_end))
    elif known_start or known_end:
        slope = max(-fall, -rise)  # the least one in a part where the field is monotonic
        t = start + abs(at_start) / slope if known_start else end - abs(at_end) / slope
    return t if start < t < end else 0.5 * (start + end)


@kernel(forceinline=True)
def estimate(start, at_start, end, at_end, third, at_third, precision):
    """The next point of a bracket. ``start`` is its newest point, whose value has not the sign of that at ``end``;
    ``third`` is the point before."""
    width = end - start
    xi = -width / (third - end)
    phi = (at_start - at_end) / (at_third - at_end)
    part = 0.5
    if phi * phi < xi and (1.0 - phi) * (1.0 - phi) < 1.0 - xi:
        part = at_start / (at_end - at_start) * (at_third / (at_end - at_third))
        part += (third - start) / width * (at_start / (at_third - at_start)) * (at_end / (at_third - at_end))
    least = min(0.5 * precision / abs(width), 0.5)
    return start + min(max(part, least), 1.0 - least) * width


@kernel(forceinline=True)
def refine_bracket(start, at_start, end, at_end, third, t, value, precision):
    """A bracket with a new value: (zero, or NaN if it is not located yet; end, at_end, third, at_third).

    The new ``start`` is t. ``third`` is NaN in a new bracket.
    """
    # The error of an estimate is about the product of the distances to its points, times a factor that stays the same
    # from step to step. So the error of this step predicts that of the next.
    farthest = min(abs(start - t), abs(end - t)) if math.isnan(third) else abs(third - t)
    if (value > 0.0) == (at_start > 0.0):
        third, at_third = start, at_start
    else:
        third, at_third = end, at_end
        end, at_end = start, at_start
    error = abs(end - t)
    if value != SIGN:  # true for NaN, too
        error = abs(value * (end - t) / (at_end - value))
    zero = t if error <= precision or abs(end - t) <= precision else math.nan
    if error * error <= ENOUGH * precision * farthest:
        better = estimate(t, value, end, at_end, third, at_third, 0.0)
        if abs(better - t) <= 2.0 * error:
            zero = better
    return zero, end, at_end, third, at_third


@kernel
def cover(block, row, first, count, o, d, pending, used, tolerance, precision, spans, limit, found, stack):
    """Insert all zeros in the ``used`` entries of ``pending`` into ``spans``, for the field of a list (``evaluate``).

    ``tolerance`` and ``precision`` are in units of the ray's parameter. Returns (zeros found so far, the value at the
    end of the last entry, unresolved length, number of evaluations).
    """
    evaluations = _joints(block, row, first, count, o, d, pending, used, stack)
    last = pending[(used - 1) * COLUMNS + AT_END]
    unresolved = 0.0
    patience = PATIENCE + 16 * used
    # First the entries as they are, in place; then those of each round with their evaluated values.
    base, batch, used, rounds = 0, used, 0, 0
    for entry in range(batch):
        pending[entry * COLUMNS + POINTS] = 0.0
    while True:
        lane = 0
        for entry in range(base, base + batch):
            place = entry * COLUMNS
            start, at_start, end, at_end = (
                pending[place + START],
                pending[place + AT_START],
                pending[place + END],
                pending[place + AT_END],
            )
            fall, rise, state = pending[place + FALL], pending[place + RISE], pending[place + STATE]
            if state != OPEN:
                t, value = pending[ASKED + lane], signed(stack[VALUES + lane])
                lane += 1
                zero, end, at_end, third, at_third = refine_bracket(
                    start, at_start, end, at_end, fall if state == OLD else math.nan, t, value, precision
                )
                if not math.isnan(zero):
                    found = insert(spans, limit, found, zero)
                elif min(abs(at_end), abs(at_third)) > SIGN:
                    used = add(pending, used, t, value, end, at_end, third, at_third, OLD)
                elif t < end:
                    used = add(pending, used, t, value, end, at_end, fall, rise, NEW)
                else:
                    used = add(pending, used, end, at_end, t, value, fall, rise, NEW)
                continue
            for point in range(int(pending[place + POINTS]), -1, -1):
                t, value = end, at_end
                if point > 0:
                    t, value = pending[ASKED + lane], signed(stack[VALUES + lane])
                    lane += 1
                used, found, left = _settle(
                    pending, used, start, at_start, t, value, fall, rise, tolerance, precision, spans, limit, found
                )
                unresolved += left
                start, at_start = t, value
        if used == 0 or rounds == patience + LAST:
            break
        rounds += 1
        if rounds > patience:
            tolerance *= GROWTH
        base, batch, lane = PENDING, 0, 0
        while used > 0 and lane < LANES:
            room = max((LANES - lane) // used, 1)
            used -= 1
            place = used * COLUMNS
            start, at_start, end, at_end = (
                pending[place + START],
                pending[place + AT_START],
                pending[place + END],
                pending[place + AT_END],
            )
            fall, rise, state = pending[place + FALL], pending[place + RISE], pending[place + STATE]
            points = 1
            if state == OLD:
                pending[ASKED + lane] = estimate(start, at_start, end, at_end, fall, rise, precision)
            elif state == NEW:
                pending[ASKED + lane] = first_estimate(start, at_start, end, at_end, fall, rise)
            else:
                points = _points(pending, lane, room, start, at_start, end, at_end, fall, rise)
            add(pending, base + batch, start, at_start, end, at_end, fall, rise, state)
            pending[(base + batch) * COLUMNS + POINTS] = points
            batch += 1
            for _ in range(points):
                _ask(stack, lane, o, d, pending[ASKED + lane])
                lane += 1
        evaluate(block, row, first, count, lane, stack)
        evaluations += lane
    for entry in range(used):
        place = entry * COLUMNS
        start, end = pending[place + START], pending[place + END]
        unresolved += abs(end - start)
        if (pending[place + AT_START] > 0.0) != (pending[place + AT_END] > 0.0):
            found = insert(spans, limit, found, 0.5 * (start + end))
    return found, last, unresolved, evaluations
