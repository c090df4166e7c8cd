# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What the rest of the program has to know of a BSDF that is compiled apart."""

from __future__ import annotations

import enum
from collections.abc import Mapping
from dataclasses import dataclass, field


class Group(enum.Enum):
    """How Cycles counts what a closure scatters."""

    DIFFUSE = "diffuse"
    GLOSSY = "glossy"  # dark where caustics are off
    OTHER = "other"  # reflection or transmission, by the side that light leaves to


@dataclass(frozen=True)
class Lobe:
    """What a node adds to a surface: ``closures``, by name. ``when`` (setting, value) asks for this lobe; None: no other is."""

    name: str
    closures: Mapping[str, Group]
    when: tuple[str, str] | None = None


@dataclass(frozen=True)
class Bsdf:
    """A node of ``material.NODES`` whose closures are in a module of ``kernels/shading/special/``.

    ``inputs`` are as in ``material.NODES``, and the arguments of the lobes, in this order. ``settings`` are names of what is no value,
    in Blender too, in capitals. ``options`` are pairs of a setting and a value for which kernels ask by ``bsdfs.option``.
    ``blender`` is Blender's node. ``sockets`` are identifiers of its sockets, where they are not the inputs' names in title case.
    """

    kind: str
    blender: str
    inputs: Mapping[str, object]
    lobes: tuple[Lobe, ...]
    settings: tuple[str, ...] = ()
    options: tuple[tuple[str, str], ...] = ()
    sockets: Mapping[str, str] = field(default_factory=dict)
    needs_derivatives: bool = False  # the lobes read dpdu or dpdv of the surface

    def socket(self, name: str) -> str:
        """Identifier of Blender's socket of an input."""
        return self.sockets.get(name, name.replace("_", " ").title())
