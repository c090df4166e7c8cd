# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Arrays of a thread whose indices are known only when the program runs, so that they cannot be in registers.

In software they are variables. On a graphics card they are in a buffer: with the intervals of a lamp as variables,
NVIDIA's compiler made programs that were up to 15 times as slow (docs/gpu.md). The n-th numbers of all threads are
neighbours there, because the threads of a group read their n-th numbers together.
"""

from __future__ import annotations

SHORT = 8  # numbers of an array that compilers keep in registers, and choose from
FLOATS, INTS = 6, 7  # bindings; both are the same buffer, in which each word is used by one of them only
KINDS = {"float": FLOATS, "int": INTS}


class ThreadArrays:
    """The arrays of a program. ``buffered``: whether long ones are in a buffer; ``words``: those of a thread there."""

    def __init__(self, buffered: bool):
        self._buffered = buffered
        self._places: dict[str, int] = {}
        self.words = 0

    def in_buffer(self, kind: str, count: int) -> bool:
        """Whether an array of so many numbers of a type of GLSL is there."""
        return self._buffered and count > SHORT and kind in KINDS

    def place(self, name: str, kind: str, count: int) -> tuple[str, str]:
        """GLSL of an element of an array in the buffer, with ``{}`` for its index, and the index of its first. The
        same name is the same array."""
        if name not in self._places:
            self._places[name] = self.words
            self.words += count
        return f"own_{kind}s[OWN({{}})]", str(self._places[name])

    def source(self) -> str:
        """GLSL of the buffer, if there is one, for work groups of ``GROUP`` threads."""
        if not self.words:
            return ""
        return "\n".join(
            [
                *(
                    f"layout(std430, binding = {binding}) buffer Own_{kind} {{ {kind} own_{kind}s[]; }};"
                    for kind, binding in KINDS.items()
                ),
                "#define OWN(place) ((place) * int(gl_NumWorkGroups.x * uint(GROUP)) + int(gl_GlobalInvocationID.x))",
            ]
        )
