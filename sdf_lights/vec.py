# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Vectors and RGB colours in kernels: tuples of three floats, which LLVM keeps in registers."""

import math

from .jit import kernel

ZERO = (0.0, 0.0, 0.0)


@kernel
def add(a, b):
    """a + b."""
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


@kernel
def sub(a, b):
    """a − b."""
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


@kernel
def mul(a, b):
    """Product of each component."""
    return (a[0] * b[0], a[1] * b[1], a[2] * b[2])


@kernel
def scale(a, s):
    """a times the number s."""
    return (a[0] * s, a[1] * s, a[2] * s)


@kernel
def madd(a, s, b):
    """a + s·b."""
    return (a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2])


@kernel
def negate(a):
    """−a."""
    return (-a[0], -a[1], -a[2])


@kernel
def dot(a, b):
    """Scalar product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@kernel
def cross(a, b):
    """Vector product a × b, right-handed."""
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


@kernel
def length(a):
    """Euclidean length |a|."""
    return math.sqrt(dot(a, a))


@kernel
def normalize(a):
    """a / |a|; the zero vector stays as it is."""
    square = dot(a, a)
    if square == 0.0:
        return a
    return scale(a, 1.0 / math.sqrt(square))


@kernel
def lerp(a, b, t):
    """Linear interpolation from a (t = 0) to b (t = 1); t may lie outside of [0, 1]."""
    return (a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1]), a[2] + t * (b[2] - a[2]))


@kernel
def largest(a):
    """The largest component."""
    return max(a[0], a[1], a[2])


@kernel
def absolute(a):
    """The magnitude of each component."""
    return (abs(a[0]), abs(a[1]), abs(a[2]))


@kernel
def is_zero(a):
    """Whether all components are 0."""
    return a[0] == 0.0 and a[1] == 0.0 and a[2] == 0.0


@kernel
def average(a):
    """Mean of the components."""
    return (a[0] + a[1] + a[2]) * (1.0 / 3.0)


@kernel
def luminance(a):
    """Luminance of an RGB colour (Rec. 709)."""
    return 0.2126 * a[0] + 0.7152 * a[1] + 0.0722 * a[2]


@kernel
def vec(a):
    """The first three numbers of an array (a field of a record) as a vector."""
    return (a[0], a[1], a[2])


@kernel
def put(array, v):
    """Store the vector v in an array (a field of a record)."""
    array[0] = v[0]
    array[1] = v[1]
    array[2] = v[2]


@kernel
def put_sum(array, v):
    """Add the vector v to an array (a field of a record)."""
    array[0] += v[0]
    array[1] += v[1]
    array[2] += v[2]


@kernel
def frame(n):
    """Two unit vectors that complete the unit vector n to a right-handed frame (t, b, n).

    Duff et al. 2017, "Building an orthonormal basis, revisited", JCGT 6(1), listing 3.
    """
    sign = math.copysign(1.0, n[2])
    a = -1.0 / (sign + n[2])
    b = n[0] * n[1] * a
    return (1.0 + sign * n[0] * n[0] * a, sign * b, -sign * n[0]), (b, sign + n[1] * n[1] * a, -n[1])


@kernel
def to_world(v, t, b, n):
    """The vector with components v in the frame (t, b, n)."""
    return (
        v[0] * t[0] + v[1] * b[0] + v[2] * n[0],
        v[0] * t[1] + v[1] * b[1] + v[2] * n[1],
        v[0] * t[2] + v[1] * b[2] + v[2] * n[2],
    )


@kernel
def transform_point(m, p):
    """Upper three rows of the array m (3 × 4 or 4 × 4) applied to a point."""
    return (
        m[0, 0] * p[0] + m[0, 1] * p[1] + m[0, 2] * p[2] + m[0, 3],
        m[1, 0] * p[0] + m[1, 1] * p[1] + m[1, 2] * p[2] + m[1, 3],
        m[2, 0] * p[0] + m[2, 1] * p[1] + m[2, 2] * p[2] + m[2, 3],
    )


@kernel
def transform_vector(m, v):
    """Upper 3 × 3 of the array m applied to a vector: transforms a direction, without translation."""
    return (
        m[0, 0] * v[0] + m[0, 1] * v[1] + m[0, 2] * v[2],
        m[1, 0] * v[0] + m[1, 1] * v[1] + m[1, 2] * v[2],
        m[2, 0] * v[0] + m[2, 1] * v[1] + m[2, 2] * v[2],
    )


@kernel
def transform_normal(m, n):
    """Transpose of the upper 3 × 3 of m applied to n: pass the inverse matrix to transform a normal."""
    return (
        m[0, 0] * n[0] + m[1, 0] * n[1] + m[2, 0] * n[2],
        m[0, 1] * n[0] + m[1, 1] * n[1] + m[2, 1] * n[2],
        m[0, 2] * n[0] + m[1, 2] * n[1] + m[2, 2] * n[2],
    )
