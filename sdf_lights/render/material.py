# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials: closures whose inputs are constants or formulas, independent of Blender and of any back end.

``NODES`` is the one table of closures: sync maps Blender's nodes to it, back ends compile or evaluate it. All values
are ``graph.formula.Formula`` (see ``nodes/``): formulas over the variables of a surface, the parameters of the
material, and functions that look up data in the scene.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np

from ..frozen import frozen
from ..graph.formula import Formula, Vector
from . import bsdfs
from .images import Texture
from .medium import Medium

Value = "float | tuple[float, float, float] | Formula | Vector | Node | None"

WHITE = (1.0, 1.0, 1.0)
GREY = (0.8, 0.8, 0.8)

# kind -> inputs with their defaults. A 3-tuple is a colour or a vector. None for a normal means the shading normal.
# None for a tangent means one around the object's z axis (for hair: along the second edge of the triangle). None for a
# position or direction means that of the ray. None for a closure means black. A value at a closure input is emitted.
NODES: dict[str, dict[str, object]] = {
    "diffuse": dict(color=GREY, roughness=0.0, normal=None),
    # settings of glossy: distribution ("MULTI_GGX", the default, | "GGX" | "BECKMANN" | "ASHIKHMIN_SHIRLEY"); of glass
    # the first three, of refraction "GGX" (the default) or "BECKMANN", of principled "MULTI_GGX" or "GGX"
    "glossy": dict(color=GREY, roughness=0.5, normal=None, anisotropy=0.0, rotation=0.0, tangent=None),
    "glass": dict(color=WHITE, roughness=0.0, ior=1.5, normal=None, thin_film_thickness=0.0, thin_film_ior=1.33),
    "refraction": dict(color=WHITE, roughness=0.0, ior=1.45, normal=None),
    "transparent": dict(color=WHITE),
    "translucent": dict(color=GREY, normal=None),
    "emission": dict(color=WHITE, strength=1.0),
    "holdout": dict(),
    "principled": dict(
        base_color=GREY,
        metallic=0.0,
        roughness=0.5,
        ior=1.5,
        alpha=1.0,
        normal=None,
        diffuse_roughness=0.0,
        specular_ior_level=0.5,
        specular_tint=WHITE,
        transmission_weight=0.0,
        coat_weight=0.0,
        coat_roughness=0.03,
        coat_ior=1.5,
        coat_tint=WHITE,
        coat_normal=None,
        sheen_weight=0.0,
        sheen_roughness=0.5,
        sheen_tint=WHITE,
        emission_color=WHITE,
        emission_strength=0.0,
        anisotropic=0.0,
        anisotropic_rotation=0.0,
        tangent=None,
        thin_film_thickness=0.0,
        thin_film_ior=1.33,
        thin_wall=0.0,
        subsurface_weight=0.0,
        subsurface_radius=(1.0, 0.2, 0.1),
        subsurface_scale=0.05,
        subsurface_ior=1.4,
        subsurface_anisotropy=0.0,
    ),
    # settings, of principled too: subsurface_method ("RANDOM_WALK", the default, | "RANDOM_WALK_LEGACY" |
    # "RANDOM_WALK_SKIN" | "BURLEY"), subsurface_once (bool: after a diffuse bounce it is diffuse); of principled alone:
    # film_on_metal (bool, True by default: the film covers its metal)
    "subsurface": dict(
        color=GREY, scale=0.05, radius=(1.0, 0.2, 0.1), ior=1.4, roughness=1.0, anisotropy=0.0, normal=None
    ),
    # settings: distribution as of glass, fresnel_type ("F82", the default, | "PHYSICAL_CONDUCTOR")
    "metallic": dict(
        base_color=(0.617, 0.577, 0.54),
        edge_tint=(0.695, 0.726, 0.77),
        ior=(2.757, 2.513, 2.231),
        extinction=(3.867, 3.404, 3.009),
        roughness=0.5,
        anisotropy=0.0,
        rotation=0.0,
        normal=None,
        tangent=None,
        thin_film_thickness=0.0,
        thin_film_ior=1.33,
    ),
    "sheen": dict(color=GREY, roughness=0.5, normal=None),  # settings: distribution ("MICROFIBER" | "ASHIKHMIN")
    **{bsdf.kind: dict(bsdf.inputs) for bsdf in bsdfs.ALL},
    "mix_closure": dict(factor=0.5, a=None, b=None),
    "add_closure": dict(a=None, b=None),
}


@dataclass(frozen=True, eq=False)
class Node:
    """One closure: its kind (a key of ``NODES``), the inputs that differ from the defaults, and its settings. Closures
    are compared by identity, so a closure used twice is computed once."""

    kind: str
    inputs: dict[str, object] = field(default_factory=dict)
    settings: dict[str, object] = field(default_factory=dict)

    def __post_init__(self):
        unknown = set(self.inputs) - set(NODES[self.kind])
        if unknown:
            raise ValueError(f"node {self.kind!r} has no input {sorted(unknown)}")

    def __getitem__(self, name: str):
        return self.inputs.get(name, NODES[self.kind][name])


@frozen
class Attribute:
    """Data of meshes or objects that a formula looks up (``nodes.lookups.attribute``).

    ``kind`` is "uv" or "tangent" (``name`` is that of a UV map; "" is the active one), "generated" (position in the box
    around the undeformed mesh, 0 to 1), "geometry" (``name`` is that of an attribute of the mesh), or "object",
    "instancer", "view_layer" (``name`` is that of a property), "instancer_generated" and "instancer_uv" (position of an
    instance on the instancer), "texture_space" ("scale" and "offset" from object space to "generated", inside meshes),
    "pointiness" (convexity of a mesh), "island" (a random number of each part), "undisplaced" (position of a point
    before ``displacement``), "grid" (``name`` is that of a grid of voxels, see ``voxels``) or "object_density" (metres
    of object space in one of the world).
    """

    kind: str
    name: str = ""


UNDISPLACED = Attribute("undisplaced")
OBJECT_DENSITY = Attribute("object_density")
UV = Attribute("uv")
"""The active UV map, for the pass."""
SHARP_FACE = Attribute("geometry", "sharp_face")
"""Which faces are flat; displacement needs it."""


@dataclass(frozen=True, eq=False)
class Table:
    """Numbers that a formula looks up (``nodes.lookups.table``): (rows, columns) float64."""

    values: np.ndarray


@dataclass
class Material:
    """A surface: the closure of its graph (None: black), and the ``medium`` behind it.

    A surface that only bounds its medium is a white ``transparent``.

    If there is a ``displacement``, formulas of a world vector, it moves the vertices (see ``displacement.py``).
    ``keeps_normals``: their normals stay, because ``normal`` follows the displacement. ``normal`` replaces the shading
    normal, if given: closures without their own normal use it, and those with one are bumps of it.

    ``index`` is for the pass of that name, ``aovs`` for those of shader AOVs. ``parameters`` are the values of the
    slots of its formulas: numbers, or an ``Attribute``, a ``Table`` or a ``Texture`` that a function looks up; the slot
    then holds its index.

    Without ``transparent_shadows``, rays towards lights do not pass its transparent parts. Without ``bump_correction``,
    bumps do not darken near the horizon of the surface, and normals that mirror the view into it stay.
    """

    name: str
    surface: Node | None = None
    sample_emission: bool = True
    parameters: list["float | Attribute | Table | Texture"] = field(default_factory=list)
    medium: Medium | None = None
    displacement: Vector | None = None
    keeps_normals: bool = False
    normal: Vector | None = None
    index: int = 0
    aovs: dict[str, Formula | Vector] = field(default_factory=dict)
    transparent_shadows: bool = True
    bump_correction: bool = True


def attributes_of(materials: Iterable[Material], others: Iterable[Attribute] = ()) -> list[Attribute]:
    """Every attribute that the materials look up, and ``others``, in the order of their indices."""
    lists = [material.parameters for material in materials]
    lists += [each.medium.varying.parameters for each in materials if each.medium and each.medium.varying]
    found = {value for values in lists for value in values if isinstance(value, Attribute)} | {*others}
    return sorted(found, key=lambda attribute: (attribute.kind, attribute.name))
