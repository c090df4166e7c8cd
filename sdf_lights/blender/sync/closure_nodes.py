# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Which closure each of Blender's shader nodes is, with its inputs and settings."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import bpy

from ...render import bsdfs
from ...render.material import NODES


class _Entry(NamedTuple):
    kind: str
    inputs: dict[str, str]  # input of our node -> identifier of Blender's socket
    settings: Callable[[bpy.types.Node], dict] = lambda node: {}


def _distribution(node) -> dict:
    return {"distribution": node.distribution}


def _subsurface(method: str) -> dict:
    """Settings of subsurface scattering, which Cycles changed in 5.0 and 5.2."""
    once = method == "BURLEY" or bpy.app.version < (5, 0)
    if method == "RANDOM_WALK" and bpy.app.version < (5, 2):
        method = "RANDOM_WALK_LEGACY"
    return {"subsurface_method": method, "subsurface_once": once}


def _principled(node) -> dict:
    """Settings of Principled, whose film covers its metal since Blender 5.0."""
    film = {"film_on_metal": bpy.app.version >= (5, 0)}
    return _distribution(node) | _subsurface(node.subsurface_method) | film


_PRINCIPLED = {name: name.replace("_", " ").title() for name in NODES["principled"]} | {
    "ior": "IOR",
    "specular_ior_level": "Specular IOR Level",
    "coat_ior": "Coat IOR",
    "thin_film_ior": "Thin Film IOR",
    "subsurface_ior": "Subsurface IOR",
}
_ROUGH = dict(roughness="Roughness", normal="Normal", anisotropy="Anisotropy", rotation="Rotation", tangent="Tangent")
_FILM = dict(thin_film_thickness="Thin Film Thickness", thin_film_ior="Thin Film IOR")

CLOSURES = {
    "ShaderNodeBsdfPrincipled": _Entry("principled", _PRINCIPLED, _principled),
    "ShaderNodeSubsurfaceScattering": _Entry(
        "subsurface",
        dict(
            color="Color",
            scale="Scale",
            radius="Radius",
            ior="IOR",
            roughness="Roughness",
            anisotropy="Anisotropy",
            normal="Normal",
        ),
        lambda node: _subsurface(node.falloff),
    ),
    "ShaderNodeBsdfDiffuse": _Entry("diffuse", dict(color="Color", roughness="Roughness", normal="Normal")),
    "ShaderNodeBsdfAnisotropic": _Entry(  # "Glossy BSDF", whose anisotropy is zero by default
        "glossy", dict(color="Color", **_ROUGH), _distribution
    ),
    "ShaderNodeBsdfGlass": _Entry(
        "glass", dict(color="Color", roughness="Roughness", ior="IOR", normal="Normal", **_FILM), _distribution
    ),
    "ShaderNodeBsdfRefraction": _Entry(
        "refraction", dict(color="Color", roughness="Roughness", ior="IOR", normal="Normal"), _distribution
    ),
    "ShaderNodeBsdfMetallic": _Entry(
        "metallic",
        dict(base_color="Base Color", edge_tint="Edge Tint", ior="IOR", extinction="Extinction", **_ROUGH, **_FILM),
        lambda node: _distribution(node) | {"fresnel_type": node.fresnel_type},
    ),
    "ShaderNodeBsdfSheen": _Entry(
        "sheen",
        dict(color="Color", roughness="Roughness", normal="Normal"),
        lambda node: {"distribution": node.distribution},
    ),
    "ShaderNodeBsdfTransparent": _Entry("transparent", dict(color="Color")),
    "ShaderNodeBsdfTranslucent": _Entry("translucent", dict(color="Color", normal="Normal")),
    "ShaderNodeEmission": _Entry("emission", dict(color="Color", strength="Strength")),
    "ShaderNodeBackground": _Entry("emission", dict(color="Color", strength="Strength")),
    "ShaderNodeHoldout": _Entry("holdout", {}),
    "ShaderNodeMixShader": _Entry("mix_closure", dict(factor="Fac", a="Shader", b="Shader_001")),
    "ShaderNodeAddShader": _Entry("add_closure", dict(a="Shader", b="Shader_001")),
}
# Settings that all nodes of a kind have in this Blender.
_OF_VERSION = {"principled_hair": {"light_rays": "ALL"}} if bpy.app.version < (5, 0) else {}
for _bsdf in bsdfs.ALL:
    CLOSURES[_bsdf.blender] = _Entry(
        _bsdf.kind,
        {name: _bsdf.socket(name) for name in _bsdf.inputs},
        lambda node, names=_bsdf.settings, more=_OF_VERSION.get(_bsdf.kind, {}): (
            {name: getattr(node, name).upper() for name in names} | more
        ),
    )
CLOSURES["ShaderNodeBsdfGlossy"] = CLOSURES["ShaderNodeBsdfAnisotropic"]
