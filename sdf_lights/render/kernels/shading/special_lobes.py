# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Lobes whose closures are in ``special/``: their nodes, and the fields of a surface that they read."""

from __future__ import annotations

from collections.abc import Callable

from ... import bsdfs
from ...material import Node
from .records import (
    BENDS_EXITS,
    BURLEY,
    HAS_SUBSURFACE,
    HAS_TRANSPARENCY,
    NEEDS_DERIVATIVES,
    NEEDS_RADIAL,
    NEEDS_RAY,
    NEEDS_SHADOW_POINT,
    RANDOM_WALK,
    RANDOM_WALK_LEGACY,
    RANDOM_WALK_SKIN,
    SHADES_SHADOWS,
    THINNEST_FILM,
)

FIRST = 10  # after the lobes of material_records.py
(
    LOBE_ROUGH_GLOSSY,  # glossy, with anisotropy or Beckmann's distribution
    LOBE_ASHIKHMIN_SHIRLEY,  # glossy
    LOBE_ROUGH_GLASS,  # glass, with a film or Beckmann's distribution
    LOBE_ROUGH_REFRACTION,  # refraction with Beckmann's distribution
    LOBE_METALLIC,  # of colours
    LOBE_CONDUCTOR,  # metallic, of indices
    LOBE_SHEEN,
    LOBE_VELVET,  # sheen of Ashikhmin's distribution
    LOBE_SUBSURFACE,
) = range(FIRST, FIRST + 9)
_REGISTERED = {lobe.name: LOBE_SUBSURFACE + 1 + number for number, lobe in enumerate(bsdfs.LOBES)}
END = LOBE_SUBSURFACE + 1 + len(_REGISTERED)


def lobe_kind(name: str) -> int:
    """The kind of a lobe of ``render.bsdfs``."""
    return _REGISTERED[name]


# Features, after those of material_records.py: Principled with microfacets of FACETS; Principled that can be a thin
# wall; Beckmann's distribution.
WITH_FACETS, WITH_THIN_WALL, WITH_BECKMANN = (1 << bit for bit in range(8, 11))
# Of subsurface scattering: there is some; Principled has some in a thin wall; not if the path has already hit a diffuse
# surface. The method is the number from bit METHOD on.
WITH_SUBSURFACE, WITH_THIN_SCATTERING, ONCE = (1 << bit for bit in range(11, 14))
METHOD = 14
BARE_METAL = 1 << 16  # Principled whose film does not cover its metal
_OPTIONS = 17  # from this bit on: options of ``render.bsdfs``, each valid for every BSDF that has it


def option(kind: str, setting: str, value: str) -> int:
    """The feature of a lobe of a BSDF of ``render.bsdfs`` whose ``setting`` has this value."""
    return 1 << _OPTIONS + bsdfs.option(kind, setting, value)


_ROUGH = ("color", "roughness", "normal", "anisotropy", "rotation", "tangent")
_FILM = ("thin_film_thickness", "thin_film_ior")
_CONDUCTOR = ("roughness", "normal", "anisotropy", "rotation", "tangent", *_FILM)
_SHEEN = ("color", "roughness", "normal")

# Kind of node -> its lobe and the inputs that are the lobe's arguments, in order.
SIMPLE = {
    "metallic": (LOBE_METALLIC, ("base_color", "edge_tint", *_CONDUCTOR)),
    "sheen": (LOBE_SHEEN, _SHEEN),
    "subsurface": (LOBE_SUBSURFACE, ("color", "scale", "radius", "ior", "roughness", "anisotropy", "normal")),
    **{bsdf.kind: (lobe_kind(bsdf.lobes[0].name), tuple(bsdf.inputs)) for bsdf in bsdfs.ALL},
}

# Inputs of Principled that are read only with one of these features.
READ_BY = (
    (("anisotropic", "anisotropic_rotation", "tangent"), WITH_FACETS),
    (_FILM, WITH_FACETS | WITH_THIN_WALL),
    (("thin_wall",), WITH_THIN_WALL | WITH_THIN_SCATTERING),
    (("subsurface_weight", "subsurface_anisotropy"), WITH_SUBSURFACE | WITH_THIN_SCATTERING),
    (("subsurface_radius", "subsurface_scale", "subsurface_ior"), WITH_SUBSURFACE),
)

# Nodes whose settings select another lobe: (kind, setting, value) -> its lobe and inputs.
_OTHERS = {
    ("glossy", "distribution", "ASHIKHMIN_SHIRLEY"): (LOBE_ASHIKHMIN_SHIRLEY, _ROUGH),
    ("metallic", "fresnel_type", "PHYSICAL_CONDUCTOR"): (LOBE_CONDUCTOR, ("ior", "extinction", *_CONDUCTOR)),
    ("sheen", "distribution", "ASHIKHMIN"): (LOBE_VELVET, _SHEEN),
    **{
        (bsdf.kind, *lobe.when): (lobe_kind(lobe.name), tuple(bsdf.inputs))
        for bsdf in bsdfs.ALL
        for lobe in bsdf.lobes
        if lobe.when is not None
    },
}
_DERIVATIVES = {lobe_kind(lobe.name) for bsdf in bsdfs.ALL for lobe in bsdf.lobes if bsdf.needs_derivatives}
_FEATURES = {
    (kind, "distribution", "BECKMANN"): WITH_BECKMANN
    for kind in ("glossy", "glass", "refraction", "metallic", "principled")
} | {(bsdf.kind, *pair): option(bsdf.kind, *pair) for bsdf in bsdfs.ALL for pair in bsdf.options}
_METHODS = {
    "BURLEY": BURLEY,
    "RANDOM_WALK": RANDOM_WALK,
    "RANDOM_WALK_LEGACY": RANDOM_WALK_LEGACY,
    "RANDOM_WALK_SKIN": RANDOM_WALK_SKIN,
}


def variant(node: Node, kind: int, inputs: tuple[str, ...], can_be: Callable) -> tuple[int, tuple[str, ...], int]:
    """Kind, arguments and features of the lobe of a node, whose plain lobe has this ``kind`` and these ``inputs``.

    ``can_be(name, test)`` returns whether an input may have a value that passes a test.
    """
    features = 0
    for setting in node.settings.items():
        features |= _FEATURES.get((node.kind, *setting), 0)
        kind, inputs = _OTHERS.get((node.kind, *setting), (kind, inputs))
    if node.kind == "principled":
        film = can_be(_FILM[0], lambda value: value > THINNEST_FILM)
        features |= WITH_FACETS * (film or can_be("anisotropic", lambda value: value > 0.0))
        features |= BARE_METAL * (film and not node.settings.get("film_on_metal", True))
        features |= WITH_THIN_WALL * (
            can_be("thin_wall", lambda value: value > 0.0)
            and can_be("transmission_weight", lambda value: value > 0.0)
            and can_be("metallic", lambda value: value < 1.0)
        )
    elif node.kind == "glass" and (features or can_be(_FILM[0], lambda value: value > THINNEST_FILM)):
        kind, inputs = LOBE_ROUGH_GLASS, (*inputs, *_FILM)
    elif node.kind == "refraction" and features:
        kind = LOBE_ROUGH_REFRACTION
    elif node.kind == "glossy" and kind < FIRST and (features or can_be("anisotropy", lambda value: abs(value) > 1e-4)):
        kind, inputs = LOBE_ROUGH_GLOSSY, _ROUGH
    return kind, inputs, features | _scattering(node, can_be)


def _scattering(node: Node, can_be: Callable) -> int:
    """Features of subsurface scattering."""
    features = 0
    if node.kind == "subsurface":
        features = WITH_SUBSURFACE
    elif (
        node.kind == "principled"
        and can_be("subsurface_weight", lambda value: value > 0.0)
        and can_be("metallic", lambda value: value < 1.0)
        and can_be("transmission_weight", lambda value: value < 1.0)
    ):
        features = WITH_SUBSURFACE * can_be("thin_wall", lambda value: value <= 0.0)
        features |= WITH_THIN_SCATTERING * can_be("thin_wall", lambda value: value > 0.0)
    if features & WITH_SUBSURFACE:
        features |= _METHODS[node.settings.get("subsurface_method", "RANDOM_WALK")] << METHOD
        features |= ONCE * node.settings.get("subsurface_once", False)
    return features


def needs(node: Node, kind: int, features: int, can_be: Callable) -> int:
    """Flags of the surface fields that the closures of a lobe read, and of their features."""
    flags = 0
    if kind in (LOBE_ROUGH_GLOSSY, LOBE_ASHIKHMIN_SHIRLEY, LOBE_METALLIC, LOBE_CONDUCTOR) or features & WITH_FACETS:
        flags |= NEEDS_RADIAL if node["tangent"] is None else 0
    if kind in _DERIVATIVES:
        flags |= NEEDS_DERIVATIVES
    if features & WITH_THIN_WALL and can_be("roughness", lambda value: value**4 < 1e-8):
        flags |= HAS_TRANSPARENCY | SHADES_SHADOWS | NEEDS_SHADOW_POINT | NEEDS_RAY
    if features & WITH_SUBSURFACE:
        flags |= HAS_SUBSURFACE | NEEDS_RAY * bool(features & ONCE) | BENDS_EXITS * (node["normal"] is not None)
    return flags
