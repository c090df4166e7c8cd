# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""BSDFs that few scenes have: one module each, found automatically. Its ``BSDF`` describes it to the other modules.

Their kernels are the modules of the same names in ``kernels/shading/special/``. The reference versions for tests are in
``reference/bsdfs/``.
"""

from __future__ import annotations

import importlib
import pkgutil

from .description import Bsdf, Group, Lobe

ALL: tuple[Bsdf, ...] = tuple(
    module.BSDF
    for module in (
        importlib.import_module(f".{name}", __name__)
        for name in sorted(item.name for item in pkgutil.iter_modules(__path__))
    )
    if hasattr(module, "BSDF")
)
LOBES: tuple[Lobe, ...] = tuple(lobe for bsdf in ALL for lobe in bsdf.lobes)
_OPTIONS = tuple((bsdf.kind, *option) for bsdf in ALL for option in bsdf.options)


def closures(group: Group) -> tuple[str, ...]:
    """Names of all closures of a group."""
    return tuple(name for lobe in LOBES for name, own in lobe.closures.items() if own is group)


def option(kind: str, setting: str, value: str) -> int:
    """The number of an option of a BSDF, from 0. Raises ValueError if its description has no such option."""
    same = [item[1:] for item in _OPTIONS if item[0] == kind]
    return same.index((setting, value))
