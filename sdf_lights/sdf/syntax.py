# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""From the text of an expression to Python's syntax tree, without overloading Python's parser.

First the number of characters, the length of statements and the nesting depth are limited. Neither the text nor the
tree is ever run.
"""

from __future__ import annotations

import ast
import keyword
import re
import warnings
from typing import NamedTuple

LONGEST = 10_000  # characters
DEEPEST = 50  # nesting depth of brackets
DEEPEST_BLOCK = 8  # nesting depth of loops and conditions
MOST_OPERATORS = 1_000  # in one statement; a chain of n is a tree of depth n, which CPython 3.13 frees by recursion
MOST_POWERS = 100  # each is nested in the one before, so it takes a part of the parser's stack
MOST_CHOICES = 20  # of not, if and else in one statement; nested likewise
MOST_ALTERNATIVES = 100  # of elif; nested likewise

KEYWORDS = frozenset({"for", "in", "if", "elif", "else", "break", "and", "or", "not", "True", "False"})


class ExpressionError(Exception):
    """A mistake in an expression: what, where, and the cure; ``str()`` gives one sentence.

    ``line`` and ``column`` count from 1.
    """

    def __init__(self, message: str, line: int, column: int, cure: str):
        super().__init__(f"Line {line}, column {column}: {message}: {cure}{'' if cure.endswith('?') else '.'}")
        self.message, self.line, self.column, self.cure = message, line, column, cure


class Syntax(NamedTuple):
    """``tree`` has lines and columns of the text; ``remarks`` has the comment after # on a line, by line number from
    1."""

    tree: ast.Module
    remarks: dict[int, str]


_REFUSED = (
    (
        re.compile(r"[^A-Za-z0-9_.,()+\-*/%=|&<>: \t\n\"]"),
        "{!r} means nothing here",
        "use letters, digits, ( ) , . : and + - * / % ** | & = < >",
    ),
    (re.compile(r"\d{41}"), "the number has too many digits", "write 1e9 for 10 to the 9th"),
    (re.compile(r"([-+][ \t]*){10}"), "there are too many signs in a row", "use one"),
)
_TOKEN = re.compile(
    r"(?P<word>[A-Za-z_]\w*)|(?P<power>\*\*)|(?P<operator>[-+*/%|&<>]|\.\s*[A-Za-z_]\w*|\)\s*\()|(?P<open>\()"
    r"|(?P<close>\))|(?P<end>\n)"
)
_CURES = {
    "[": "use ( ) instead",
    "]": "use ( ) instead",
    "{": "use ( ) instead",
    "}": "use ( ) instead",
    "^": "write ** for a power",
    ";": "write each statement on a line of its own",
    "!": "compare with < <= > >=, and write not before a condition",
    "\\": "a line goes on by itself inside ( )",
}


def parse(text: str) -> Syntax:
    """The syntax tree of an expression. Raises ``ExpressionError``."""
    if len(text) > LONGEST:
        raise ExpressionError(f"the expression has {len(text)} characters", 1, 1, f"use at most {LONGEST}")
    text = text.replace("\r\n", "\n").replace("\r", "\n")
    lines: list[str] = []
    remarks: dict[int, str] = {}
    texts: dict[tuple[int, int], tuple[str, int]] = {}
    for number, line in enumerate(text.split("\n"), 1):
        code, remark = _without_texts(line, number, texts)
        lines.append(code)
        if remark.strip():
            remarks[number] = remark.strip()
    _guard("\n".join(lines))
    written = _indented(lines)
    moved = [len(line) - len(new) for line, new in zip(lines, written)]
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # hints about Python, which do not apply here
            tree = ast.parse("\n".join(written))
    except SyntaxError as error:
        problem = re.sub(r"\W*(Perhaps|Maybe|Did) .*|\.$", "", error.msg or "invalid syntax")
        at = min(max(error.lineno or 1, 1), len(lines))
        raise ExpressionError(
            problem,
            at,
            max(error.offset or 1, 1) + moved[at - 1],
            "look for a missing bracket, comma or operator just before",
        ) from None
    except (ValueError, RecursionError, MemoryError, OverflowError):
        raise ExpressionError(
            "the expression is nested too deeply", 1, 1, "name parts of it on lines of their own"
        ) from None
    if any(moved):
        for node in ast.walk(tree):
            if hasattr(node, "lineno") and hasattr(node, "col_offset"):
                node.col_offset += moved[node.lineno - 1]
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            said, length = texts[node.lineno, node.col_offset]
            if len(node.value) != length:
                raise ExpressionError(
                    "two texts stand one after the other",
                    node.lineno,
                    node.col_offset + 1,
                    "write a comma between them",
                )
            node.value = said
    return Syntax(tree, remarks)


_TEXT = re.compile(r'"(?:[^"\\]|\\.)*"|\'(?:[^\'\\]|\\.)*\'')
_ESCAPE = re.compile(r"\\(x[0-9A-Fa-f]{2}|u[0-9A-Fa-f]{4}|U[0-9A-Fa-f]{8}|.)")
_ESCAPED = {"n": "\n", "\\": "\\", '"': '"', "'": "'", "t": "\t"}


def _without_texts(line: str, number: int, texts: dict[tuple[int, int], tuple[str, int]]) -> tuple[str, str]:
    """A line with other letters in its texts, which are put into ``texts`` by line and column from 0, each with the
    length that it has in the line; and its remark.

    So Python's parser never sees what the texts say.
    """
    code: list[str] = []
    at = 0
    while at < len(line):
        if line[at] == "#":
            return "".join(code), line[at + 1 :]
        if line[at] not in "\"'":
            code.append(line[at])
            at += 1
            continue
        found = _TEXT.match(line, at)
        if found is None:
            raise ExpressionError(
                "the text that begins here has no end", number, at + 1, f"write {line[at]} after it, on the same line"
            )
        if at and (line[at - 1].isalnum() or line[at - 1] in "_\"'"):
            raise ExpressionError(
                "a text cannot stand right after a word or another text", number, at + 1, "write a comma before it"
            )
        texts[number, at] = _unescaped(found[0][1:-1], number, at), len(found[0]) - 2
        code.append('"' + "_" * (len(found[0]) - 2) + '"')
        at = found.end()
    return "".join(code), ""


def _unescaped(text: str, number: int, column: int) -> str:
    def letter(found: re.Match) -> str:
        if len(found[1]) > 1:
            code = int(found[1][1:], 16)
            if code < 0x110000 and not 0xD800 <= code < 0xE000:
                return chr(code)
        elif found[1] in _ESCAPED:
            return _ESCAPED[found[1]]
        raise ExpressionError(
            f"\\{found[1]} means nothing in a text",
            number,
            column + 2 + found.start(),
            "write \\\\ for one \\, or / in a path",
        )

    return _ESCAPE.sub(letter, text)


def _guard(code: str) -> None:
    """Refuses text that should not reach the parser."""

    def error(at: int, message: str, cure: str) -> ExpressionError:
        return ExpressionError(message, code.count("\n", 0, at) + 1, at - code.rfind("\n", 0, at), cure)

    refused = [
        (found.start(), problem.format(found[0]), _CURES.get(found[0], cure))
        for pattern, problem, cure in _REFUSED
        if (found := pattern.search(code))
    ]
    if refused:
        raise error(*min(refused))
    brackets = powers = alternatives = operators = choices = 0
    for found in _TOKEN.finditer(code):
        kind, word = found.lastgroup, found[0]
        if kind == "word":
            if keyword.iskeyword(word) and word not in KEYWORDS:
                raise error(
                    found.start(),
                    f"{word} is not part of the language",
                    "write lines such as name = value, and a shape last",
                )
            operators += word in ("and", "or")
            choices += word in ("not", "if", "else")
            alternatives += word == "elif"
        elif kind == "end":
            if brackets <= 0:  # otherwise the statement continues
                operators = choices = 0
        elif kind == "open":
            brackets += 1
        elif kind == "close":
            brackets -= 1
        else:
            operators += 1
            powers += kind == "power"
        if brackets > DEEPEST:
            raise error(
                found.start(),
                "the brackets are nested too deeply",
                f"use at most {DEEPEST} inside one another, and name parts on lines of their own",
            )
        if operators > MOST_OPERATORS:
            raise error(
                found.start(),
                "there are too many operators in one statement",
                f"use at most {MOST_OPERATORS}, or union(a, b, …) with commas",
            )
        if powers > MOST_POWERS:
            raise error(found.start(), "there are too many powers", f"use at most {MOST_POWERS}")
        if choices > MOST_CHOICES:
            raise error(
                found.start(),
                "there are too many choices in one statement",
                f"use not, if and else at most {MOST_CHOICES} times",
            )
        if alternatives > MOST_ALTERNATIVES:
            raise error(found.start(), "there are too many alternatives", f"use elif at most {MOST_ALTERNATIVES} times")


def _indented(lines: list[str]) -> list[str]:
    """The lines, indented by one space for each block that they are in.

    A block consists of the lines indented more than the line with its colon. Otherwise, the amount of indentation does
    not matter.
    """
    written = []
    blocks: list[int] = []  # indentation of the lines that opened them
    brackets = 0
    for number, line in enumerate(lines, 1):
        code = line.lstrip()
        if brackets <= 0 and code:
            brackets = 0
            indent = len(line[: -len(code)].expandtabs(4))
            while blocks and indent <= blocks[-1]:
                blocks.pop()
            code = " " * len(blocks) + code
        written.append(code)
        brackets += code.count("(") - code.count(")")
        if brackets <= 0 and code.rstrip().endswith(":"):
            blocks.append(indent)
            if len(blocks) > DEEPEST_BLOCK:
                raise ExpressionError(
                    "blocks are nested too deeply",
                    number,
                    len(line) - len(line.lstrip()) + 1,
                    f"use at most {DEEPEST_BLOCK} inside one another",
                )
    return written
