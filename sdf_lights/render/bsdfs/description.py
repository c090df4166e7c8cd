# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The description of a BSDF that is compiled separately, for the rest of the program."""

from __future__ import annotations

import enum
from collections.abc import Mapping
from dataclasses import field

from ...frozen import frozen


class Group(enum.Enum):
    """How Cycles classifies the scattering of a closure."""

    DIFFUSE = "diffuse"
    GLOSSY = "glossy"  # dark if caustics are off
    OTHER = "other"  # reflection or transmission, by the side on which light leaves


@frozen
class Lobe:
    """A lobe of a node: its ``closures``, by name. ``when`` (setting, value) selects this lobe; None: no other lobe is
    selected."""

    name: str
    closures: Mapping[str, Group]
    when: tuple[str, str] | None = None


@frozen
class Bsdf:
    """A node of ``material.NODES`` whose closures are in a module of ``kernels/shading/special/``.

    ``inputs`` are as in ``material.NODES``, and the arguments of the lobes, in this order. ``settings`` are names of
    properties that are not values, in capitals, as in Blender. ``options`` are pairs of a setting and a value that
    kernels test with ``bsdfs.option``. ``blender`` is Blender's node. ``sockets`` are identifiers of its sockets that
    differ from the inputs' names in title case.
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
