# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
import math
import pathlib
import re
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

from sdf_lights.sdf import syntax, value_evaluation
from sdf_lights.sdf.emission import EmissionExpression
from sdf_lights.sdf.expression import Declaration, Expression, ExpressionError, evaluate
from sdf_lights.sdf.functions import FUNCTIONS
from sdf_lights.sdf.reference import reference_page
from sdf_lights.sdf.shapes import (
    SHAPES,
    Box,
    BoxFrame,
    Difference,
    Intersection,
    Primitive,
    Shape,
    Sphere,
    Torus,
    Transformed,
    Union,
)

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]


def number(text: str) -> float:
    """Value of an expression that is a number between 0.001 and 1e9."""
    return evaluate(f"sphere({text})").radius


@pytest.mark.parametrize(
    "text, shape",
    [
        ("difference(box(0.8), sphere(1.08))", Difference(Box(0.8), Sphere(1.08))),
        ("box(0.8) - sphere(1.08)", Difference(Box(0.8), Sphere(1.08))),
        ("sphere(1) | box(1) & torus(1, 0.2)", Union(Sphere(1.0), Intersection(Box(1.0), Torus(1.0, 0.2)))),
        ("sphere() - box() - torus()", Difference(Sphere(), Box(), Torus())),
        ("union(sphere(1), box(1), torus())", Union(Sphere(1.0), Box(1.0), Torus())),
        ("box(1, 2, 3)", Box((1.0, 2.0, 3.0))),
        ("box((1, 2, 3))", Box((1.0, 2.0, 3.0))),
        ("box(vec3(1, 2, 3))", Box((1.0, 2.0, 3.0))),
        ("box(vec3(2))", Box(2.0)),
        ("box_frame(1, 2, 3)", BoxFrame((1.0, 2.0, 3.0))),
        ("box_frame(1, 2, 3, 0.1)", BoxFrame((1.0, 2.0, 3.0), 0.1)),
        ("box_frame(1, 0.1)", BoxFrame(1.0, 0.1)),
        ("torus(minor_radius=0.2)", Torus(minor_radius=0.2)),
        ("torus(1, minor_radius=0.2)", Torus(1.0, 0.2)),
        ("sphere()  # a remark, in any script: 灯 \"'[]{}", Sphere()),
        ("\r\n  \r\nr = 2\r\nsphere(r)\r\n", Sphere(2.0)),
        ("sphere(\n  1 +\n  1)", Sphere(2.0)),
        ("a = 1\na = a + 1\nsphere(a)", Sphere(2.0)),
        ("  a = 2\n sphere(a)", Sphere(2.0)),
        ("step = 2\nsphere(step * step(0, 1))", Sphere(2.0)),
    ],
)
def test_shapes(text, shape):
    assert evaluate(text) == shape


@pytest.mark.parametrize("name", [n for n, s in SHAPES.items() if issubclass(s, Primitive)])
def test_every_primitive_has_its_name_and_defaults(name):
    shape = SHAPES[name]()
    assert evaluate(f"{name}() & box(1)") == Intersection(shape, Box(1.0))
    if shape.bounded:
        assert evaluate(f"{name}()") == shape


@pytest.mark.parametrize(
    "text, value",
    [
        ("1 + 2 * 3", 7.0),
        ("2 ** 3 ** 2", 512.0),
        ("-2 + 5", 3.0),
        ("7 % 4", 3.0),
        ("mod(-1, 4)", 3.0),
        ("10 - 4 - 3", 3.0),
        ("pi", math.pi),
        ("tau", math.tau),
        ("sin(pi / 2)", 1.0),
        ("cos(0)", 1.0),
        ("tan(pi / 4)", math.tan(math.pi / 4)),
        ("asin(1)", math.pi / 2),
        ("acos(0)", math.acos(0.0)),
        ("atan(1)", math.pi / 4),
        ("atan2(1, 1)", math.pi / 4),
        ("sqrt(9)", 3.0),
        ("exp(1)", math.e),
        ("log(e)", 1.0),
        ("pow(2, 10)", 1024.0),
        ("abs(-3)", 3.0),
        ("sign(5)", 1.0),
        ("floor(2.7)", 2.0),
        ("ceil(2.1)", 3.0),
        ("fract(2.25)", 0.25),
        ("min(3, 1, 2)", 1.0),
        ("max(3, 1, 2)", 3.0),
        ("clamp(5, 0, 2)", 2.0),
        ("mix(1, 3, 0.25)", 1.5),
        ("radians(180)", math.pi),
        ("degrees(pi)", 180.0),
        ("dot((1, 2, 3), (4, 5, 6))", 32.0),
        ("length((3, 0, 4))", 5.0),
        ("cross((1, 0, 0), (0, 1, 0)).z", 1.0),
        ("normalize((0, 5, 0)).y", 1.0),
        ("vec3(1, 2, 3).y", 2.0),
        ("((1, 2, 3) * 2 + (0, 0, 1)).z", 7.0),
        ("max((1, 5, 2), 3).x", 3.0),
        ("(2 * vec3(1, 2, 3) / (1, 2, 3)).z", 2.0),
        ("1e3", 1000.0),
        ("0x10", 16.0),
        ("1_000", 1000.0),
        ("mix(a=1, b=3, t=0.5)", 2.0),
        ("(-vec3(-1, 0, 0)).x", 1.0),
    ],
)
def test_numbers(text, value):
    assert number(text) == pytest.approx(value, rel=1e-15)


def test_named_arguments_go_by_name():
    assert number("atan2(x=1, y=2)") == math.atan2(2.0, 1.0)
    assert number("pow(exponent=3, base=2)") == 8.0


@pytest.mark.parametrize(
    "text, point, moved",
    [
        ("translate(sphere(), 1, 2, 3)", (0.1, 0.2, 0.3), (1.1, 2.2, 3.3)),
        ("translate(sphere(), (1, 2, 3))", (0.1, 0.2, 0.3), (1.1, 2.2, 3.3)),
        ("rotate(box(1, 2, 3), 90)", (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)),
        ("rotate(box(1, 2, 3), 90, (2, 0, 0))", (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)),
        ("rotate(box(1, 2, 3), 90, 0, 5, 0)", (0.0, 0.0, 1.0), (1.0, 0.0, 0.0)),
        ("rotate(box(1, 2, 3), (90, 0, 90))", (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)),
        ("rotate(box(1, 2, 3), (90, 0, 90))", (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)),
        ("scale(sphere(), 2)", (1.0, 2.0, 3.0), (2.0, 4.0, 6.0)),
        ("scale(cone(), 1, 2, -3)", (1.0, 2.0, 3.0), (1.0, 4.0, -9.0)),
        ("translate(scale(sphere(), 2), 1, 0, 0)", (1.0, 0.0, 0.0), (3.0, 0.0, 0.0)),
    ],
)
def test_transforms(text, point, moved):
    shape = evaluate(text)
    assert isinstance(shape, Transformed) and shape.validate() == ""
    np.testing.assert_allclose(np.array(shape.matrix) @ [*point, 1.0], [*moved, 1.0], atol=1e-15)


def test_sliders():
    text = "a = slider(1, 0, 2)\nb = slider(0.1, 1 / 100, 3)\ntorus(1 + a, b)"
    lamp = Expression(text)
    assert lamp.parameters == (
        Declaration("a", "slider", 1.0, 0.0, 2.0, ""),
        Declaration("b", "slider", 0.1, 0.01, 3.0, ""),
    )
    assert lamp.shape() == Torus(2.0, 0.1)
    assert lamp.shape({"b": 0.5, "unknown": 7}) == Torus(2.0, 0.5)
    assert lamp.shape({"a": 9.0, "b": 0.0}) == Torus(3.0, 0.01)  # held to the limits
    assert lamp.shape({"a": 2}).formula() is lamp.shape().formula()
    for bad in (math.nan, "wide", None, 10**400):
        with pytest.raises(ExpressionError, match="Line 1, column 5: the value given for a is not a number"):
            lamp.shape({"a": bad})
    with pytest.raises(ExpressionError, match="minor radius"):
        lamp.shape({"a": 0.0, "b": 3.0})


# text, line, column, words of the message, words of the cure
MISTAKES = [
    ("", 1, 1, "empty", "sphere"),
    ("# only a remark", 1, 1, "empty", "sphere"),
    ("shpere(1)", 1, 1, "shpere is not a known name", "did you mean sphere?"),
    ("size = 2\nsphere(siez)", 2, 8, "siez is not a known name", "size"),
    ("sphere", 1, 1, "needs brackets", "sphere(radius=0.5)"),
    ("sphere(radius=1, foo=2)", 1, 1, "no argument foo", "sphere(radius=0.5)"),
    ("sphere(1, radius=2)", 1, 1, "radius twice", "sphere(radius=0.5)"),
    ("sphere(1, 2)", 1, 1, "does not take 2", "sphere(radius=0.5)"),
    ("box(1, 2)", 1, 1, "does not take 2", "box("),
    ("box(1)\n| sphere(1)", 2, 1, "invalid syntax", "missing"),
    ("sphere(-1)", 1, 1, "radius is -1", "change"),
    ("  sphere(-1)", 1, 3, "radius is -1", "change"),
    (" a = 1\n   sphere(1", 2, 10, "never closed", "missing"),
    ("a = 1\nb = slider(a, 0, 2)\nsphere(b)", 2, 12, "cannot depend on a", "name = slider"),
    ("torus(1, 2)", 1, 1, "minor radius 2 is more than the major radius 1", "make the minor radius smaller"),
    ("scale(sphere(1), 1, 0, 1)", 1, 1, "flattens", "scale other than zero"),
    ("rotate(sphere(), 10, vec3(0))", 1, 1, "no direction", "another vector"),
    ("union()", 1, 1, "does not take 0", "union(shape, …)"),
    ("union(1)", 1, 1, "must be a shape, not a number", "union"),
    ("union(shape=sphere())", 1, 1, "no named", "union"),
    ("sphere(box())", 1, 1, "must be a number, not a shape", "sphere"),
    ("sphere((1, 2, 3))", 1, 1, "must be a number, not a vector", "sphere"),
    ("translate(sphere())", 1, 1, "needs offset", "translate"),
    ("1 + sphere()", 1, 1, "between a number and a shape", "| & -"),
    ("sphere() * 2", 1, 1, "between a shape and a number", "| & -"),
    ("1 | 2", 1, 1, "between a number and a number", "| & -"),
    ("sphere(2 // 1)", 1, 8, "this operator", "+ - * /"),
    ("sphere(1 @ 2)", 1, 10, "'@' means nothing", "letters"),
    ("-sphere()", 1, 1, "this sign", "numbers"),
    ("x = 1", 1, 1, "what glows", "end with"),
    ("1 + 1", 1, 1, "the last line is a number", "end with"),
    ("sphere()\nsphere()", 1, 1, "no effect", "combine"),
    ("range = 3\nsphere(1)", 1, 1, "range already means", "another name"),
    ("sphere = 3\nsphere", 2, 1, "the last line is a number", "end with"),
    ("slider = 3\nsphere(1)", 1, 1, "slider already means", "another name"),
    ("a = 1\na(2)", 2, 1, "a is a number, not a function", "brackets"),
    ("sphere(slider(1, 0, 2))", 1, 8, "stand alone", "name = slider"),
    ("a = slider(1, 0)\nsphere(a)", 1, 5, "three numbers", "name = slider"),
    ("a = slider(3, 0, 1)\nsphere(a)", 1, 5, "not between 0 and 1", "name = slider"),
    ("a = slider(1, 0, 2)\na = slider(1, 0, 2)\nsphere(a)", 2, 5, "already is a parameter", "another name"),
    ("sphere(1", 1, 7, "never closed", "missing bracket"),
    ("sphere(1))", 1, 10, "unmatched", "missing bracket"),
    ("sphere(1) sphere(2)", 1, 11, "invalid syntax", "missing"),
    ("sphere(1 / 0)", 1, 8, "division by zero", "another number"),
    ("sphere(5 % 0)", 1, 8, "division by zero", "another number"),
    ("sphere(sqrt(-1))", 1, 8, "undefined", "other numbers"),
    ("sphere((-1) ** 0.5)", 1, 8, "undefined", "other numbers"),
    ("sphere(0 ** -1)", 1, 8, "undefined", "other numbers"),
    ("sphere(1e999)", 1, 8, "too large", "other numbers"),
    ("box((1, 2))", 1, 1, "must be a vector of three numbers", "vec3"),
    ("sphere((1, 2, 3).w)", 1, 8, ".w is not part of a vector", ".x"),
    ("sphere[0]", 1, 7, "'[' means nothing", "( )"),
    ("sphere(2^3)", 1, 9, "'^' means nothing", "**"),
    ("sphere(1) # fine\n§", 2, 1, "'§' means nothing", "letters"),
]

ATTACKS = [
    # names and attributes that reach Python's insides
    "__import__('os').system('true')",
    "().__class__.__bases__",
    "sphere().__class__",
    "sphere.__globals__",
    "__builtins__",
    "eval(1)",
    "exec(1)",
    "open(1)",
    "getattr(sphere(), 1)",
    "vec3(1,2,3).__class__",
    "sphere(__debug__)",
    "sphere(**a)",
    "sphere(*a)",
    "f = sphere\nf(1)",
    "union(sphere)",
    "print(1)",
    "help()",
    "_guard",
    "type(1)",
    # the rest of Python
    "import os",
    "from os import path",
    "lambda: 0",
    "[x for x in y]",
    "{1: 2}",
    "f'{1}'",
    "'text'",
    "b'x'",
    "1j",
    "True",
    "None",
    "...",
    "a = b = 1",
    "a, b = 1, 2",
    "a += 1",
    "a: int = 1",
    "del a",
    "if 1: 2",
    "while 1: pass",
    "1 if 1 else 2",
    "a := 1",
    "not 1",
    "~1",
    "1 < 2",
    "1 == 1",
    "1 and 2",
    "yield",
    "await a",
    "return 1",
    "global a",
    "assert 1",
    "pass",
    "def f(): pass",
    "class A: pass",
    "@a",
    "raise 1",
    "try: pass",
    "with a: pass",
    "match a:\n case 1: pass",
    "print 1",
    "a[0]",
    "a.b = 1",
    "sphere().radius",
    "type X = int",
    "(yield)",
    "sphere(1);sphere(2)",
    "async def f(): pass",
    # numbers
    "sphere(9**9**9**9)",
    "sphere(10**10**10)",
    "9" * 5000,
    "sphere(" + "9" * 5000 + ")",
    "sphere(1e999999999)",
    "sphere(2**1e9)",
    "0x" + "f" * 9000,
    "1." + "0" * 9000,
    "1_" * 4900 + "1",
    "**".join("2" * 3000),
    "**-".join("2" * 3000),
    "exp(exp(exp(9)))",
    "sphere(1e300 * 1e300)",
    "sphere(exp(1e9))",
    "mod(1e308, 1e-308)",
    "sphere(10**9 * 10**9)",
    "translate(sphere(), 1e300)",
    # nesting, length
    "(" * 9_900,
    "(" * 4900 + ")" * 4900,
    "(" * 50 + "1",
    "sphere(" * 1400,
    "sphere(" * 60 + "1" + ")" * 60,
    ")" * 9_900,
    "-" * 9_900 + "1",
    "- " * 4900 + "1",
    "+-" * 4900 + "1",
    "-+ \t" * 2000,
    "not " * 2400 + "1",
    "1" + "+1" * 4900,
    "a" + " . x" * 2400,
    "a" + " ( )" * 2400,
    "(1\n" + "+1\n" * 3000 + ")",
    "(a\n" + ".x\n" * 3000 + ")",
    "(a\n" + ".\nx" * 3000 + ")",
    "(a" + "(\n)" * 3000 + ")",
    "(a" + "\n()" * 3000 + ")",
    "1 if 1 else " * 800,
    "a." * 4900 + "a",
    "a" + ".x" * 4900,
    "a" + "()" * 4900,
    "lambda:" * 1400,
    "," * 9_900,
    "(1,2,3)" + ".x" * 4900,
    "\n" * 9_900,
    "# " * 4900,
    "a=1\n" * 2400,
    "((((((((((" * 4 + "a b" + "))))))))))" * 4,
    "(((((" * 9 + "=" + ")))))" * 9,
    "a(b=" * 49 + "1",
    "x" * 1_000_000,
    "a = box(1)\n" + "a = displace(a, 0.1 * sin(9 * p.x))\n" * 250 + "a",
    "(" * 1_000_000,
    "sphere()|" * 111_111,
    "\0" * 1_000_000,
    # shapes without end
    "s=sphere()\n" + "s=s|s\n" * 1600 + "s",
    "s=sphere()\n" + "s=s-s\n" * 1600 + "s",
    "s=sphere()\n" + "s=s|s&s\n" * 1200 + "s",
    "s=sphere()\n" + "s=s|sphere()-s\n" * 640 + "s",
    "s=sphere()\nt=union(" + ",".join("s" * 1999) + ")\nunion(" + "t," * 2900 + "t)",
    "s=" + "|".join(["sphere()"] * 1000) + "\ns|s|s",
    "s=sphere()\nt=" + "|".join("s" * 999) + "\n" + "u=t|t\n" * 1300 + "q",
    # fields and loops without end
    "for i in range(10**9):\n p = sin(p)\nlength(p)",
    "n = integer(5, 0, 10**9)\nfor i in range(n):\n p = p * 2\nlength(p)",
    "for i in range(1000):\n for j in range(1000):\n  p = sin(p)\nlength(p)",
    "n = 1\nfor i in range(1000):\n for j in range(1000):\n  n = n + 1\nsphere(n)",
    "n = 1\n" + "".join(" " * k + f"for i{k} in range(9):\n" for k in range(8)) + " " * 8 + "n = n + 1\nsphere(n)",
    "\n".join(" " * k + "if 1 < 2:" for k in range(130)),
    "s = length(p)\n" + "s=s*s+s\n" * 1200 + "q",
    "s = p\n" + "s=s*s+s\n" * 1200 + "q",
    "s = p\n" + "s=rotate(s,s)\n" * 600 + "q",
    "a = p\n" + "a=normalize(cross(a,a+1))\n" * 370 + "q",
    "a = p.x < 0\n" + "a=a and a or not a\n" * 450 + "q",
    "a = 1\n" + "if p.x>0:\n a=a+1\n" * 450 + "q",
    "s = length(p)-1\n" + "s=field(s)(p)+field(s)(p+1)\n" * 300 + "q",
    "s=" + "|".join(["sphere()"] * 900) + "\n" + "t=s(p)\n" * 300 + "q",
    "p" + ".xyz" * 900,
    "p" + ".xyz" * 2400,
    "for i in range(900):\n s = sphere(1 + i)(p)\nq",
    "for i in range(100):\n" + " s = sphere(i + 1)(p)\n" * 100 + "q",
    "s = length(p) - 1\nfor i in range(900):\n s = union(s, sphere(i + 1))\nq",
    *(
        f"s = sphere()\n{'s = ' + word + chr(10)}" * 98 + "q"
        for word in (
            "bend(s)",
            "twist(s)",
            "taper(s)",
            "shell(s)",
            "onion(s, 0.001)",
            "mirror(s)",
            "offset(s, 0.001)",
            "s | s(p)",
            "wave_displacement(s)",
            "smooth_union(s, sphere())",
            "morph(s, s)",
            "rotate(s, 10)",
        )
    ),
    # blocks and conditions
    "for " * 2400,
    "for a in " * 1000,
    "if " * 3000,
    "if 1: " * 1600,
    "elif 1:" * 1400,
    "else:" * 1900,
    "break\n" * 1600,
    "if 1 < 2:\n a = 1\n" + "elif 1 < 2:\n a = 1\n" * 450,
    "x = " + "not " * 2400 + "1",
    "x = (1 " + "if 1 else (1 " * 49,
    "1<" * 4900 + "1",
    "1 and " * 1600 + "1",
    "a:b:c:d",
    ":" * 9000,
    "x = (i for i in p)",
    "f(i for i in p)",
    "for i in p: p = p",
    "for p.x in range(3): p = p",
    "for i, j in range(3): p = p",
    "for i in range(3): break",
    "p.__class__",
    "p.x.real",
    "sphere().bounds(1)",
    "p(p)",
    "sphere(1)(p, p)",
    "toggle(True)",
    "a = slider(1, 0, 2) + 1",
    "True.real",
    "range(3)",
    "a = range(3)",
    "p.x in p",
    "p is p",
    "not p",
    "p.x == p.x == p.x",
    # unicode
    "ｓphere(1)",
    "sphеre(1)",
    "sphere(１)",
    "sphere(1)\u2028import os",
    "sphere\u200b(1)",
    "ª = 1",
    "𝐬phere(1)",
    "\u202esphere(1)",
    "\ud800",
    "sphere(1\u00a0)",
    "\ufeffsphere(1)",
    "sphere(²)",
    "sphere(1)\x0c",
    "sphere(1)\x1a",
    "sphere(1)\\\n",
    "\t\tsphere",
    "sphere(−1)",
    "# \ud800\n1",
]


@pytest.mark.parametrize("text, line, column, message, cure", MISTAKES)
def test_mistakes_are_located_and_explained(text, line, column, message, cure):
    with pytest.raises(ExpressionError) as caught:
        evaluate(text)
    error = caught.value
    assert (error.line, error.column) == (line, column), str(error)
    assert message in error.message and cure in error.cure
    end = "" if error.cure.startswith("did you mean") else "."  # its mark ends the sentence
    assert str(error) == f"Line {line}, column {column}: {error.message}: {error.cure}{end}"
    assert error.cure.endswith("?") == error.cure.startswith("did you mean")


def _fails_soon(text: str) -> None:
    with pytest.raises(ExpressionError) as caught:
        evaluate(text)
    error = caught.value
    assert error.line >= 1 and error.column >= 1 and error.message and error.cure
    assert "\n" not in str(error) and len(str(error)) < 400


@pytest.mark.parametrize("text", ATTACKS, ids=range(len(ATTACKS)))
def test_attacks_end_in_an_error_within_a_tenth_of_a_second(text):
    # Time of this thread alone, the best of three: other programs on the machine do not count.
    times = []
    for _ in range(3):
        start = time.thread_time()
        _fails_soon(text)
        times.append(time.thread_time() - start)
        if times[-1] < 0.1:
            return
    raise AssertionError(f"took {min(times):.2f} s")


def test_random_words_make_a_shape_or_an_error():
    rng = np.random.default_rng(19)
    names = list(FUNCTIONS)
    words = [
        "a",
        "b",
        "a",
        "(",
        ")",
        "(",
        ")",
        ",",
        "1",
        "2.5",
        "0",
        "-1",
        "1e9",
        "+",
        "-",
        "*",
        "/",
        "%",
        "**",
        "|",
        "&",
        "=",
        ".",
        ".x",
        "\n",
        "slider(",
        "sphere()",
        "box(1)",
        "(1, 2, 3)",
        "vec3(",
        "a = ",
        "\nsphere(1)",
        "=",
        "_",
        "p",
        "p.x",
        "(p)",
        "for i in range(3):\n  ",
        "if ",
        "<",
        " and ",
        "not ",
        "else ",
        "break",
        "(p) - 1",
    ]
    shapes = 0
    for _ in range(2500):
        text = " ".join(rng.choice(names if rng.random() < 0.3 else words) for _ in range(rng.integers(1, 9)))
        try:
            shapes += isinstance(evaluate(text), Shape)
        except ExpressionError:
            pass
    assert shapes > 5


def test_attacks_do_not_overflow_the_small_stack_of_a_thread():
    failures = []

    def attack():
        try:
            for text in ATTACKS:
                _fails_soon(text)
        except BaseException as error:  # reported by the main thread
            failures.append(error)

    previous = threading.stack_size(512 * 1024)  # what macOS gives to threads
    try:
        thread = threading.Thread(target=attack)
        thread.start()
        thread.join()
    finally:
        threading.stack_size(previous)
    assert not failures


def test_the_largest_expressions_that_are_allowed():
    wide = "s = sphere()\nunion(" + ", ".join("s" * value_evaluation.MOST_PRIMITIVES) + ")"
    assert evaluate(wide).size == value_evaluation.MOST_PRIMITIVES
    assert evaluate("|".join(["sphere()"] * (syntax.MOST_OPERATORS + 1))).size == syntax.MOST_OPERATORS + 1
    half = syntax.DEEPEST // 2
    deep = "sphere(" + "(" * (syntax.DEEPEST - 1) + "1" + ")" * syntax.DEEPEST
    assert evaluate(deep) == Sphere(1.0)
    nested = "union(box(), difference(sphere(), " * (half - 1) + "sphere()" + "))" * (half - 1)
    assert evaluate(nested).size == 2 * half - 1


def test_no_word_has_a_private_name_or_lacks_documentation():
    for name, function in FUNCTIONS.items():
        assert name.isidentifier() and not name.startswith("_") and function.name == name
        assert function.description and function.signature().startswith(name + "(")


def test_the_reference_page_is_current():
    page = (REPOSITORY / "docs" / "expressions.md").read_text(encoding="utf-8")
    command = [sys.executable, "-m", "sdf_lights.sdf.reference"]
    written = subprocess.run(
        command, cwd=REPOSITORY, capture_output=True, text=True, encoding="utf-8", check=True
    ).stdout
    assert page == written, "run python -m sdf_lights.sdf.reference > docs/expressions.md"


def test_the_examples_of_the_reference_page_work():
    introduction, rest = reference_page().split("## Shapes\n")
    shapes, emissions = rest.split("## Examples\n")[1].split("## Emission\n")
    shapes, emissions = (
        [
            "\n".join(line[4:] for line in block.splitlines())
            for block in re.findall(r"(?:^    .*\n(?:^\n(?=    ))?)+", text, re.MULTILINE)
        ]
        for text in (introduction + shapes, emissions)
    )
    assert len(shapes) >= 15 and len(emissions) >= 5
    for text in shapes:
        low, high = evaluate(text).bounds()
        assert (low < high).all()
    for text in emissions:
        EmissionExpression(text)


@pytest.mark.parametrize(
    ("new", "old"),
    [
        ("mandelbulb(exponent=6, iterations=3)", "mandelbulb(power=6, rounds=3)"),
        ("apollonian_gasket(iterations=2)", "apollonian_gasket(rounds=2)"),
    ],
)
def test_arguments_have_the_names_of_their_labels_too(new, old):
    assert evaluate(new) == evaluate(old)
