# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Wraps prose at 120 columns: paragraphs of Markdown, docstrings and comments. Tables and code stay as they are.

    python scripts/wrap_prose.py [--check] [FILE …]

Only paragraphs with a longer line change. ``--check`` changes nothing: it lists such files, and the exit code is 1.
"""

from __future__ import annotations

import argparse
import ast
import io
import pathlib
import re
import subprocess
import sys
import textwrap
import tokenize

REPOSITORY = pathlib.Path(__file__).resolve().parents[1]
WIDTH = 120
ITEM = re.compile(r"( *)([-*]|\d+\.) +")
# A line that begins so would be something else in Markdown.
MARK = re.compile(r" (?=(?:[-*+>#|=]|\d+[.)])(?: |$))")
VERBATIM = ("|", "#", "!", "[!", "<", "```")
HELD = "\x00"  # a space at which no line ends
GENERATED = {"docs/expressions.md", "docs/gallery.md", "docs/recipes.md", "docs/report.md"}  # their scripts write lines


def wrapped(lines: list[str], prefix: str, width: int) -> list[str]:
    """One paragraph. ``prefix`` is what its first line begins with; later lines are indented as far."""
    text = " ".join(line.strip() for line in lines)
    text = re.sub(r"``[^`]{1,60}``|`[^`]{1,60}`", lambda span: span[0].replace(" ", HELD), MARK.sub(HELD, text))
    found = textwrap.wrap(
        text,
        width,
        initial_indent=prefix,
        subsequent_indent=" " * len(prefix),
        break_long_words=False,
        break_on_hyphens=False,
    )
    return [line.replace(HELD, " ") for line in found]


def markdown(lines: list[str], width: int = WIDTH) -> list[str]:
    """The lines of a document, with wrapped paragraphs and list items."""
    done: list[str] = []
    paragraph: list[str] = []
    prefix, fenced = "", False

    def finish() -> None:
        too_long = any(len(line) > width for line in paragraph) and not any(line.endswith("  ") for line in paragraph)
        if too_long:
            first = paragraph[0][len(prefix) :]
            done.extend(wrapped([first, *paragraph[1:]], prefix, width))
        else:
            done.extend(paragraph)
        paragraph.clear()

    for line in lines:
        if line.startswith("```"):
            fenced = not fenced
        item = ITEM.match(line)
        indent = len(line) - len(line.lstrip(" "))
        continues = bool(paragraph) and line.strip() and not item and indent == len(prefix)
        if fenced or not line.strip() or line.startswith(VERBATIM) or line.strip() == '"""':
            finish()
            done.append(line)
        elif item and len(item[1]) < 8:
            finish()
            prefix = item[0]
            paragraph.append(line)
        elif continues:
            paragraph.append(line)
        elif indent == 0:
            finish()
            prefix = ""
            paragraph.append(line)
        else:
            finish()
            done.append(line)
    finish()
    return done


def docstrings(source: str) -> list[tuple[int, int, int]]:
    """First line, end and indentation of each docstring in triple quotes."""
    found = []
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, (ast.Module, ast.ClassDef, ast.FunctionDef)) and node.body:
            first = node.body[0]
            if (
                isinstance(first, ast.Expr)
                and isinstance(first.value, ast.Constant)
                and isinstance(first.value.value, str)
            ):
                found.append((first.lineno - 1, first.end_lineno or first.lineno, first.col_offset))
    return found


def python(source: str) -> str:
    """A module with wrapped docstrings and comments. A comment behind code that is too long goes above it."""
    lines = source.split("\n")
    for start, end, indent in sorted(docstrings(source), reverse=True):
        part = lines[start:end]
        if part[0].startswith(" " * indent + '"""') and any(len(line) > WIDTH for line in part):
            inner = markdown([line[indent:] if line.strip() else "" for line in part], WIDTH - indent)
            lines[start:end] = [" " * indent + line if line else "" for line in inner]
    lines = comments(lines)
    return "\n".join(above(lines))


def comments(lines: list[str]) -> list[str]:
    """Lines with wrapped blocks of comments."""
    done: list[str] = []
    block: list[str] = []
    prefix = ""

    def finish() -> None:
        if any(len(line) > WIDTH for line in block):
            for line in wrapped([line[len(prefix) :] for line in block], "", WIDTH - len(prefix)):
                done.append(prefix + line)
        else:
            done.extend(block)
        block.clear()

    for line in lines:
        match = re.match(r" *# (?=[^ \-])", line)
        if match is None or (block and match[0] != prefix):
            finish()
        if match is None:
            done.append(line)
        else:
            prefix = match[0]
            block.append(line)
    finish()
    return done


def above(lines: list[str]) -> list[str]:
    """Lines with long comments above their code."""
    if not any(len(line) > WIDTH for line in lines):
        return lines
    done = list(lines)
    tokens = tokenize.generate_tokens(io.StringIO("\n".join(lines)).readline)
    for token in reversed([token for token in tokens if token.type == tokenize.COMMENT]):
        row, column = token.start
        code = done[row - 1][:column].rstrip()
        if len(done[row - 1]) > WIDTH and code and not re.search(r"type:|noqa|fmt:", token.string):
            indent = " " * (len(code) - len(code.lstrip()))
            done[row - 1 : row] = [*comments([indent + token.string]), code]
    return done


def files() -> list[pathlib.Path]:
    """Documents and modules of the repository."""
    listed = subprocess.run(
        ["git", "ls-files", "*.md", "*.py"], cwd=REPOSITORY, capture_output=True, text=True, check=True
    )
    return [REPOSITORY / name for name in listed.stdout.split("\n") if name and name not in GENERATED]


def main(words: list[str]) -> int:
    """Wrap the files; the exit code."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--check", action="store_true", help="only list files with longer lines")
    parser.add_argument("files", nargs="*", type=pathlib.Path)
    options = parser.parse_args(words)
    changed = 0
    for path in options.files or files():
        if not path.is_file():
            continue
        text = path.read_text(encoding="utf-8")
        if not any(len(line) > WIDTH for line in text.split("\n")):
            continue
        new = python(text) if path.suffix == ".py" else "\n".join(markdown(text.split("\n")))
        if new != text:
            changed += 1
            if options.check:
                print(f"{path}: prose longer than {WIDTH} columns: run ./scripts/check --fix")
            else:
                path.write_text(new, encoding="utf-8")
    return int(options.check and changed > 0)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
