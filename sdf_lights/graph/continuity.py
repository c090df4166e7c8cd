# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Where formulas are continuous although operations in them jump.

Steps of ``floor``, cuts of angles and choices tear a formula, unless later operations join both sides again.
``lipschitz`` finds some of these cases from values. Two other cases are handled here: the author of the formula
*declares* it continuous, and a choice between two polynomials that are equal where its condition changes.
"""

from __future__ import annotations

import functools
import threading
import weakref
from collections.abc import Iterable
from fractions import Fraction
from typing import NamedTuple

from .formula import CONSTANT, Formula
from .operations import CONDITIONS


class Declared(NamedTuple):
    """A formula, or only its absolute value if ``even``, is a continuous function of ``inputs``, if all of the formulas
    ``whole``, which are numbers, are integers."""

    inputs: tuple[Formula, ...]
    even: bool = False
    whole: tuple[Formula, ...] = ()


_declared: weakref.WeakKeyDictionary[Formula, Declared] = weakref.WeakKeyDictionary()
_lock = threading.Lock()


def declare(formula: Formula, inputs: Iterable[Formula], even: bool = False, whole: Iterable[Formula] = ()) -> Formula:
    """Declare that a formula is continuous for all numbers in its slots, except for ``whole``: see ``Declared``."""
    if formula.operands:
        with _lock:
            _declared[formula] = Declared(tuple(inputs), even, tuple(whole))
    return formula


def declared(formula: Formula) -> Declared | None:
    """The declaration of a formula."""
    with _lock:
        return _declared.get(formula)


# -- choices ------------------------------------------------------------------------------------------------------

_MOST_TERMS = 64
_Polynomial = dict[tuple[Formula, ...], Fraction]  # coefficients, by the factors of each product, sorted


class _TooLong(Exception):
    pass


def _added(a: _Polynomial, b: _Polynomial, factor: int = 1) -> _Polynomial:
    found = dict(a)
    for product, coefficient in b.items():
        found[product] = found.get(product, Fraction(0)) + factor * coefficient
    return {product: coefficient for product, coefficient in found.items() if coefficient}


def _multiplied(a: _Polynomial, b: _Polynomial) -> _Polynomial:
    if len(a) * len(b) > _MOST_TERMS:
        raise _TooLong
    found: _Polynomial = {}
    for u, s in a.items():
        for v, t in b.items():
            found = _added(found, {tuple(sorted((*u, *v), key=id)): s * t})
    return found


def _polynomial(formula: Formula, known: dict[Formula, _Polynomial]) -> _Polynomial:
    if formula in known:
        return known[formula]
    parts = [_polynomial(o, known) for o in formula.operands] if formula.kind in _RING else []
    found: _Polynomial
    if formula.kind == CONSTANT and abs(formula.value) < 1e300:
        found = {(): Fraction(formula.value)} if formula.value else {}
    elif formula.kind == "negate":
        found = _added({}, parts[0], -1)
    elif formula.kind in ("add", "subtract"):
        found = _added(parts[0], parts[1], 1 if formula.kind == "add" else -1)
    elif formula.kind == "multiply":
        found = _multiplied(parts[0], parts[1])
    else:
        found = {(formula,): Fraction(1)}
    if len(found) > _MOST_TERMS:
        raise _TooLong
    known[formula] = found
    return found


_RING = frozenset({"negate", "add", "subtract", "multiply"})


@functools.lru_cache(maxsize=1024)
def joins(condition: Formula, then: Formula, otherwise: Formula) -> bool:
    """Whether both sides of a choice are certainly equal where its condition changes.

    They are equal if their difference is 0 at the value where the condition changes; the condition must be linear in
    one formula.
    """
    if condition.kind not in CONDITIONS:
        return False
    try:
        known: dict[Formula, _Polynomial] = {}
        a, b, one, other_one = (_polynomial(side, known) for side in (*condition.operands, then, otherwise))
        border, step = _added(a, b, -1), _added(one, other_one, -1)
        for product, coefficient in border.items():
            if len(product) == 1 and sum(product[0] in other for other in border) == 1:
                rest = {other: value / -coefficient for other, value in border.items() if other != product}
                if not _replaced(step, product[0], rest):
                    return True
        return not step
    except (_TooLong, RecursionError):
        return False


def _replaced(polynomial: _Polynomial, factor: Formula, value: _Polynomial) -> _Polynomial:
    found: _Polynomial = {}
    for product, coefficient in polynomial.items():
        term: _Polynomial = {tuple(p for p in product if p is not factor): coefficient}
        for _ in range(product.count(factor)):
            term = _multiplied(term, value)
        found = _added(found, term)
    return found
