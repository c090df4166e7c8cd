# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""From the text of an expression to Python's syntax tree, without giving Python's parser anything that makes it labour.

The text is held to few characters, a length, and a nesting depth first. Nothing here, or of the tree, is ever run.
"""

from __future__ import annotations

import ast
import keyword
import re
from typing import NamedTuple

LONGEST = 10_000  # characters
DEEPEST = 50  # brackets inside one another
DEEPEST_BLOCK = 8  # loops and conditions inside one another
MOST_OPERATORS = 1_000  # in one statement; a chain of n is a tree n deep, and frees itself by recursion in CPython 3.13
MOST_POWERS = 100  # each is nested in the one before, and so takes of the parser's stack
MOST_CHOICES = 20  # of not, if and else in one statement; nested likewise
MOST_ALTERNATIVES = 100  # of elif; nested likewise

KEYWORDS = frozenset({"for", "in", "if", "elif", "else", "break", "and", "or", "not", "True", "False"})


class ExpressionError(Exception):
    """What is wrong in an expression, where, and how to put it right; ``str()`` says it in one sentence.

    ``line`` and ``column`` count from 1.
    """

    def __init__(self, message: str, line: int, column: int, cure: str):
        super().__init__(f"Line {line}, column {column}: {message}: {cure}.")
        self.message, self.line, self.column, self.cure = message, line, column, cure


class Syntax(NamedTuple):
    """``tree`` has lines and columns of the text; ``remarks`` is what follows # on a line, by its number from 1."""

    tree: ast.Module
    remarks: dict[int, str]


_OTHER_CHARACTER = re.compile(r"[^A-Za-z0-9_.,()+\-*/%=|&<>: \t]")
_LONGEST_NUMBER = re.compile(r"\d{41}")
_SIGNS_IN_A_ROW = re.compile(r"([-+][ \t]*){10}")
_OPERATOR = re.compile(r"[-+*/%|&<>]|\.\s*[A-Za-z_]|\)\s*\(|\b(?:and|or)\b")
_WORD = re.compile(r"[A-Za-z_]\w*")
_CHOICE = re.compile(r"\b(?:not|if|else)\b")
_ALTERNATIVE = re.compile(r"\belif\b")
_CURES = {
    "[": "use ( ) instead", "]": "use ( ) instead", "{": "use ( ) instead", "}": "use ( ) instead",
    "'": "there is no text in expressions", '"': "there is no text in expressions",
    "^": "write ** for a power", ";": "write each statement on a line of its own",
    "!": "compare with < <= > >=, and write not before a condition", "\\": "a line goes on by itself inside ( )"}


def parse(text: str) -> Syntax:
    """The syntax tree of an expression. Raises ``ExpressionError``."""
    if len(text) > LONGEST:
        raise ExpressionError(f"the expression has {len(text)} characters", 1, 1, f"use at most {LONGEST}")
    text = text.replace("\r\n", "\n").replace("\r", "\n")
    lines, remarks = [], {}
    for number, line in enumerate(text.split("\n"), 1):
        code, _, remark = line.partition("#")
        lines.append(code)
        if remark.strip():
            remarks[number] = remark.strip()
    _guard(lines)
    written = _indented(lines)
    moved = [len(line) - len(new) for line, new in zip(lines, written)]
    try:
        tree = ast.parse("\n".join(written))
    except SyntaxError as error:
        problem = re.sub(r"\W*(Perhaps|Maybe|Did) .*|\.$", "", error.msg or "invalid syntax")
        line = min(max(error.lineno or 1, 1), len(lines))
        raise ExpressionError(problem, line, max(error.offset or 1, 1) + moved[line - 1],
                              "look for a missing bracket, comma or operator just before") from None
    except (ValueError, RecursionError, MemoryError, OverflowError):
        raise ExpressionError("the expression is nested too deeply", 1, 1,
                              "name parts of it on lines of their own") from None
    if any(moved):
        for node in ast.walk(tree):
            if hasattr(node, "lineno"):
                node.col_offset += moved[node.lineno - 1]
    return Syntax(tree, remarks)


def _guard(lines: list[str]) -> None:
    """Refuses text that is not worth showing to the parser."""
    brackets = powers = alternatives = 0
    statement = ""  # may go on over several lines, inside brackets
    for number, line in enumerate(lines, 1):
        for pattern, problem, cure in (
                (_OTHER_CHARACTER, "{!r} means nothing here",
                 "use letters, digits, ( ) , . : and + - * / % ** | & = < >"),
                (_LONGEST_NUMBER, "the number has too many digits", "write 1e9 for 10 to the 9th"),
                (_SIGNS_IN_A_ROW, "there are too many signs in a row", "use one")):
            found = pattern.search(line)
            if found:
                raise ExpressionError(
                    problem.format(found[0]), number, found.start() + 1, _CURES.get(found[0], cure))
        for word in _WORD.finditer(line):
            if keyword.iskeyword(word[0]) and word[0] not in KEYWORDS:
                raise ExpressionError(f"{word[0]} is not part of the language", number, word.start() + 1,
                                      "write lines such as name = value, and a shape last")
        powers += line.count("**")
        if powers > MOST_POWERS:
            raise ExpressionError("there are too many powers", number, line.rfind("**") + 1,
                                  f"use at most {MOST_POWERS}")
        for bracket in re.finditer(r"[()]", line):
            brackets += 1 if bracket[0] == "(" else -1
            if brackets > DEEPEST:
                raise ExpressionError("the brackets are nested too deeply", number, bracket.start() + 1,
                                      f"use at most {DEEPEST} inside one another, and name parts on lines of their own")
        alternatives += len(_ALTERNATIVE.findall(line))
        if alternatives > MOST_ALTERNATIVES:
            raise ExpressionError("there are too many alternatives", number, 1,
                                  f"use elif at most {MOST_ALTERNATIVES} times")
        statement += line + "\n"
        if brackets <= 0 or number == len(lines):
            if len(_OPERATOR.findall(statement)) > MOST_OPERATORS:
                raise ExpressionError("there are too many operators in one statement", number, 1,
                                      f"use at most {MOST_OPERATORS}, or union(a, b, …) with commas")
            if len(_CHOICE.findall(statement)) > MOST_CHOICES:
                raise ExpressionError("there are too many choices in one statement", number, 1,
                                      f"use not, if and else at most {MOST_CHOICES} times")
            statement = ""


def _indented(lines: list[str]) -> list[str]:
    """The lines indented by one space for each block they stand in.

    A block is what is indented more than the line with the colon that opens it; apart from that, how far a line is
    indented means nothing.
    """
    written = []
    blocks: list[int] = []  # indentation of the lines that opened them
    brackets = 0
    for number, line in enumerate(lines, 1):
        code = line.lstrip()
        if brackets <= 0 and code:
            brackets = 0
            indent = len(line[:-len(code)].expandtabs(4))
            while blocks and indent <= blocks[-1]:
                blocks.pop()
            code = " " * len(blocks) + code
        written.append(code)
        brackets += code.count("(") - code.count(")")
        if brackets <= 0 and code.rstrip().endswith(":"):
            blocks.append(indent)
            if len(blocks) > DEEPEST_BLOCK:
                raise ExpressionError("blocks are nested too deeply", number, len(line) - len(line.lstrip()) + 1,
                                      f"use at most {DEEPEST_BLOCK} inside one another")
    return written
