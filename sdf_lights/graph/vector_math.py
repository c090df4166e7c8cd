# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Elementary functions of several numbers at a time, as LLVM code: the same on every platform.

Methods and coefficients are those of the Cephes library (S. L. Moshier, "Methods and Programs for Mathematical
Functions", 1989; netlib.org/cephes), without its branches. A function of ``FUNCTIONS`` returns its values and whether
they are valid: to 5 units in the last place, or to that of 1 for sine and cosine; for a power to 1e-14 (2e-13 for one
below e⁻²⁴). They are not valid for NaN and infinities.
"""

from __future__ import annotations

import math

from llvmlite import ir

_WORD, _LONG = ir.IntType(32), ir.IntType(64)


class Number:
    """A vector of doubles or of booleans, with operators that emit code.

    Without fast-math flags: the reductions and sums below are exact only in this order.
    """

    def __init__(self, builder: ir.IRBuilder, value: ir.Value):
        self.builder, self.value = builder, value

    @property
    def lanes(self) -> int:
        """Number of lanes."""
        return self.value.type.count

    def _other(self, other) -> ir.Value:
        return other.value if isinstance(other, Number) else ir.Constant(self.value.type, [other] * self.lanes)

    def _binary(self, name: str, other) -> "Number":
        return Number(self.builder, getattr(self.builder, name)(self.value, self._other(other)))

    def __add__(self, other):
        return self._binary("fadd", other)

    def __sub__(self, other):
        return self._binary("fsub", other)

    def __mul__(self, other):
        return self._binary("fmul", other)

    def __truediv__(self, other):
        return self._binary("fdiv", other)

    __radd__, __rmul__ = __add__, __mul__

    def __rsub__(self, other):
        return Number(self.builder, self._other(other)) - self

    def __neg__(self):
        return Number(self.builder, self.builder.fneg(self.value))

    def __and__(self, other):
        return self._binary("and_", other)

    def __or__(self, other):
        return self._binary("or_", other)

    def _compared(self, symbol: str, other) -> "Number":
        return Number(self.builder, self.builder.fcmp_ordered(symbol, self.value, self._other(other)))

    def __lt__(self, other):
        return self._compared("<", other)

    def __le__(self, other):
        return self._compared("<=", other)

    def __gt__(self, other):
        return self._compared(">", other)

    def select(self, then, otherwise) -> "Number":
        """For booleans: one or the other, lane by lane."""
        then = then if isinstance(then, Number) else Number(self.builder, otherwise._other(then))
        return Number(self.builder, self.builder.select(self.value, then.value, then._other(otherwise)))

    def _intrinsic(self, name: str, *others: "Number") -> "Number":
        values, module = [number.value for number in (self, *others)], self.builder.module
        name, kind = f"llvm.{name}.v{self.lanes}f64", self.value.type
        function = module.globals.get(name) or ir.Function(module, ir.FunctionType(kind, [kind] * len(values)), name)
        return Number(self.builder, self.builder.call(function, values))

    def __abs__(self):
        return self._intrinsic("fabs")

    def floor(self) -> "Number":
        """⌊x⌋ of each lane."""
        return self._intrinsic("floor")

    def sqrt(self) -> "Number":
        """Square root of each lane."""
        return self._intrinsic("sqrt")

    def signed_as(self, other: "Number") -> "Number":
        """The magnitude of this number with the sign of another, lane by lane."""
        return self._intrinsic("copysign", other)

    # -- the bits of doubles

    def _integers(self, kind: ir.IntType) -> ir.VectorType:
        return ir.VectorType(kind, self.lanes)

    def _longs(self, value: int) -> ir.Constant:
        return ir.Constant(self._integers(_LONG), [value] * self.lanes)

    def power_of_two(self) -> "Number":
        """2 to the power of this integer, within the exponents of doubles."""
        b = self.builder
        exponent = b.sext(b.fptosi(self.value, self._integers(_WORD)), self._integers(_LONG))
        bits = b.shl(b.add(exponent, self._longs(1023)), self._longs(52))
        return Number(b, b.bitcast(bits, self.value.type))

    def mantissa_and_exponent(self) -> tuple["Number", "Number"]:
        """m in [½, 1) and an integer n, with m · 2ⁿ equal to this normal, positive number."""
        b = self.builder
        bits = b.bitcast(self.value, self._integers(_LONG))
        mantissa = b.or_(b.and_(bits, self._longs((1 << 52) - 1)), self._longs(1022 << 52))
        exponent = b.trunc(b.sub(b.lshr(bits, self._longs(52)), self._longs(1022)), self._integers(_WORD))
        return Number(b, b.bitcast(mantissa, self.value.type)), Number(b, b.sitofp(exponent, self.value.type))


def _polynomial(x: Number, *coefficients: float) -> Number:
    """The coefficient of the highest power comes first."""
    value = x * coefficients[0] + coefficients[1] if coefficients[0] != 1.0 else x + coefficients[1]
    for coefficient in coefficients[2:]:
        value = value * x + coefficient
    return value


def _wave(x: Number, quarters: float) -> Number:
    """sin(x + quarters · π/2)"""
    count = (x * (2.0 / math.pi) + 0.5).floor()
    # π/2 in three parts. The first two have few enough digits that these products are exact.
    x = ((x - count * 1.57079625129699707031) - count * 7.54978941586159635335e-8) - count * 5.39030285815811905290e-15
    turned = count + quarters
    turned = turned - (turned * 0.25).floor() * 4.0  # 0, 1, 2 or 3
    squared = x * x
    sine = x + x * squared * _polynomial(
        squared,
        1.58962301576546568060e-10,
        -2.50507477628578072866e-8,
        2.75573136213857245213e-6,
        -1.98412698295895385996e-4,
        8.33333333332211858878e-3,
        -1.66666666666666307295e-1,
    )
    cosine = (
        1.0
        - squared * 0.5
        + squared
        * squared
        * _polynomial(
            squared,
            -1.13585365213876817300e-11,
            2.08757008419747316778e-9,
            -2.75573141792967388112e-7,
            2.48015872888517045348e-5,
            -1.38888888888730564116e-3,
            4.16666666666665929218e-2,
        )
    )
    half = turned * 0.5
    value = (half.floor() < half).select(cosine, sine)
    return (turned > 1.5).select(-value, value)


def _exp(x: Number) -> Number:
    count = (x * (1.0 / math.log(2.0)) + 0.5).floor()
    x = (x - count * 6.93145751953125e-1) - count * 1.42860682030941723212e-6  # ln 2, the first part exact
    squared = x * x
    odd = x * _polynomial(squared, 1.26177193074810590878e-4, 3.02994407707441961300e-2, 9.99999999999999999910e-1)
    even = _polynomial(squared, 3.00198505138664455042e-6, 2.52448340349684104192e-3, 2.27265548208155028766e-1, 2.0)
    return (1.0 + odd / (even - odd) * 2.0) * count.power_of_two()


def _log(x: Number) -> Number:
    mantissa, exponent = x.mantissa_and_exponent()
    small = mantissa < math.sqrt(0.5)
    exponent = exponent - small.select(1.0, exponent * 0.0)
    x = small.select(mantissa + mantissa, mantissa) - 1.0
    squared = x * x
    value = x * (
        squared
        * _polynomial(
            x,
            1.01875663804580931796e-4,
            4.97494994976747001425e-1,
            4.70579119878881725854,
            1.44989225341610930846e1,
            1.79368678507819816313e1,
            7.70838733755885391666,
        )
        / _polynomial(
            x,
            1.0,
            1.12873587189167450590e1,
            4.52279145837532221105e1,
            8.29875266912776603211e1,
            7.11544750618563894466e1,
            2.31251620126765340583e1,
        )
    )
    value = value - exponent * 2.121944400546905827679e-4  # ln 2 minus its exact part
    return (x + (value - squared * 0.5)) + exponent * 0.693359375


_PI, _PI_REST = math.pi, 1.2246467991473531772e-16  # π, and the error of its double


def _atan2(y: Number, x: Number) -> Number:
    across, along = abs(y), abs(x)
    steep = across > along
    least, most = steep.select(along, across), steep.select(across, along)
    ratio = least / (most > 0.0).select(most, 1.0)
    high = ratio > 0.66
    z = high.select((ratio - 1.0) / (ratio + 1.0), ratio)
    squared = z * z
    angle = z + z * (
        squared
        * _polynomial(
            squared,
            -8.750608600031904122785e-1,
            -1.615753718733365076637e1,
            -7.500855792314704667340e1,
            -1.228866684490136173410e2,
            -6.485021904942025371773e1,
        )
        / _polynomial(
            squared,
            1.0,
            2.485846490142306297962e1,
            1.650270098316988542046e2,
            4.328810604912902668951e2,
            4.853903996359136964868e2,
            1.945506571482613964425e2,
        )
    )
    zero = angle * 0.0
    angle = high.select(0.25 * _PI_REST, zero) + angle + high.select(0.25 * _PI, zero)
    angle = steep.select(0.5 * _PI - (angle - 0.5 * _PI_REST), angle)
    behind = (zero + 1.0).signed_as(x) < 0.0  # −0 counts as negative, as in IEEE 754
    return behind.select(_PI - (angle - _PI_REST), angle).signed_as(y)


_FEW = 1e5  # radians up to which products with the number of quarter turns are exact
_LEAST, _MOST = 1e-300, 1e300  # far from where doubles lose digits or overflow


def _beside(x: Number) -> Number:
    """Length of the other leg of a right triangle with a leg x and the hypotenuse 1."""
    return ((1.0 - x) * (x + 1.0)).sqrt()


def _power(x: Number, y: Number) -> tuple[Number, Number]:
    exponent = y * _log(x)
    zero = (abs(x) <= 0.0) & (y > 0.0)
    # The exponent's error grows with the exponent. It is the relative error of the power, and matters little for a
    # small power.
    holds = (x > _LEAST) & (x < _MOST) & (exponent > -700.0) & (exponent < 24.0)
    return zero.select(0.0, _exp(exponent)), holds | zero


FUNCTIONS = {
    "sin": lambda x: (_wave(x, 0.0), abs(x) < _FEW),
    "cos": lambda x: (_wave(x, 1.0), abs(x) < _FEW),
    "tan": lambda x: (_wave(x, 0.0) / _wave(x, 1.0), abs(x) < _FEW),
    "asin": lambda x: (_atan2(x, _beside(x)), abs(x) <= 1.0),
    "acos": lambda x: (_atan2(_beside(x), x), abs(x) <= 1.0),
    "atan": lambda x: (_atan2(x, x * 0.0 + 1.0), abs(x) < _MOST),
    "atan2": lambda y, x: (_atan2(y, x), (abs(y) < _MOST) & (abs(x) < _MOST)),
    "exp": lambda x: (_exp(x), abs(x) < 700.0),
    "log": lambda x: (_log(x), (x > _LEAST) & (x < _MOST)),
    "pow": _power,
}
