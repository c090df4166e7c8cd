# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Records shared by shading and the rest of the path tracer: the surface at a hit, and its closures.

``SURFACE`` is the whole interface of a hit: the integrator fills the first group of fields, ``shade`` the second. World
space, metres, unit vectors, unless stated otherwise.
"""

import numpy as np

from ....graph.codegen_native import Place
from ....jit import table
from ... import bsdfs

CLOSURES = 64
REGISTERS = 1024

# Kinds of scattering that `sample` returns; the first three are those of scene.Ray.
DIFFUSE, GLOSSY, TRANSMISSION = 2, 4, 8
SCATTERED = DIFFUSE | GLOSSY | TRANSMISSION
SINGULAR = 32  # a Dirac delta: evaluate() is zero there, f·|cos| / pdf is the weight of the path
TRANSPARENT = 64  # straight through, with wi = −wo; always together with SINGULAR, never with TRANSMISSION
THROUGH_PORTAL = 128  # continue from surface.exit; always together with TRANSPARENT and SINGULAR
INTO_SUBSURFACE = 256  # to scatter there, by closure surface.entered; always together with TRANSMISSION and SINGULAR

# Flags of a material (MATERIAL["flags"]): the fields of SURFACE that its shading needs, and its features.
HAS_TRANSPARENCY = 1  # transparency() may be other than black, and light rays pass it
HAS_EMISSION = 2
NEEDS_OBJECT_NORMAL = 4  # object_normal
NEEDS_DERIVATIVES = 8  # dpdu, dpdv, bump_step
NEEDS_SHADOW_POINT = 16  # of transparency(): position, n and ng
NEEDS_RAY = 32  # ray_length, ray_singular, depth
HAS_SURFACE = 64  # anything that scatters
NEEDS_RADIAL = 128  # radial
SHADES_SHADOWS = 256  # shade() computes the straight transmission, not transparency()
HAS_SUBSURFACE = 512  # light may scatter below the surface
BENDS_EXITS = 1024  # the normal where such light leaves is that of the SUBSURFACE closures
STOPS_LIGHT_RAYS = 2048  # transparent, but not to light rays
UNCORRECTED = 4096  # no correction of bump maps
TRACES_RAYS = 16384  # shading does: not for a second workspace, which has no random numbers for that
DEPENDS_ON_VIEW = 8192  # closures that are diffuse may differ for other directions of view, and other distances

SURFACE = np.dtype(
    [
        # Of the hit, filled before shade(). A field named under a NEEDS_ flag is read only by materials with that flag.
        ("position", "f8", 3),
        ("wo", "f8", 3),  # towards the viewer
        ("ng", "f8", 3),  # geometric normal, on the side of wo
        ("n", "f8", 3),  # interpolated shading normal, flipped together with ng
        ("barycentric", "f8", 2),  # weights of the triangle's second and third vertex
        ("dpdu", "f8", 3),  # derivatives of position by them: the triangle's edges from its first vertex
        ("dpdv", "f8", 3),
        ("bump_step", "f8"),  # distance in metres over which bump mapping takes differences
        ("object_normal", "f8", 3),  # interpolated shading normal in object space, not normalised, never flipped
        ("radial", "f8", 3),  # direction around the object's z axis, from its generated coordinates; not normalised
        ("ray_length", "f8"),  # distance from the point where the incoming ray left a surface or the camera
        ("material", "i4"),
        ("backfacing", "i4"),  # 1: wo is behind the triangle's own normal; ng and n have been flipped
        ("ray_kind", "i4"),  # scene.Ray of the incoming ray
        ("ray_singular", "i4"),  # 1: it left its last surface in a mirror direction
        ("depth", "i4", 5),  # bounces before this hit: all, diffuse, glossy, transmission, transparent
        ("instance", "i4"),
        ("primitive", "i4"),
        ("strand", "i4"),  # of a curve, which kind of scene.Primitive it is; else 0
        ("terminator", "f8"),  # cosine below which light rays start above a smooth triangle; 0: none does
        (
            "number",
            "u4",
        ),  # of its triangle, curve or sphere, which rays that leave it do not meet: ray_origins.number_of
        ("exact_origin", "i4"),  # 1: rays start at its position, 2: and no other face is there, 0: their origin is
        # offset (see ray_origins.py)
        # Of the material, filled by shade().
        ("uncorrected", "i4"),  # not 0: bumps neither darken near the horizon, nor is their normal raised for mirrors
        ("closure_count", "i4"),
        ("evaluable", "i4"),  # closures that are not singular; without them light sampling is useless
        ("subsurface", "i4"),  # closures of scattering below the surface
        ("entered", "i4"),  # the one of them that sample() has drawn
        ("emission", "f8", 3),  # radiance towards wo
        ("transparency", "f8", 3),  # transmitted straight or by a PORTAL; sample() draws it too, as TRANSPARENT
        ("albedo", "f8", 3),  # estimated directional albedo of all closures, for denoising
        ("diffuse_albedo", "f8", 3),  # the part of it that passes call diffuse, as in Cycles
        ("holdout", "f8"),  # weight of Holdout
        ("exit", "f8", 3),  # origin of a ray that sample() has sent through a PORTAL
        ("portal", "i4"),  # 1: it has a PORTAL: light behind it is not left to light rays
        ("pick_total", "f8"),  # sum of the closures' sampling weights, before normalisation
    ],
    align=True,
)

# Variables of formulas (see nodes/variables.py): the field that holds each, and its position.
VARIABLE_FIELDS = {
    "position": "position",
    "incoming": "wo",
    "true_normal": "ng",
    "normal": "n",
    "barycentric": "barycentric",
    "dpdu": "dpdu",
    "dpdv": "dpdv",
    "bump_step": "bump_step",
    "object_normal": "object_normal",
    "ray_length": "ray_length",
    "backfacing": "backfacing",
    "ray_kind": "ray_kind",
    "ray_singular": "ray_singular",
    "depth": "depth",
}
VARIABLES = {
    name: Place(SURFACE.fields[field][1], SURFACE.fields[field][0].base.str[1:])
    for name, field in VARIABLE_FIELDS.items()
}

# Kinds of closure: diffuse ones first, then lobes, which are narrower. Those between SHEEN and MICROFACET, and those
# between MICROFACET and STRAIGHT, are compiled separately, only for scenes that have them (see special/). Those of
# ``render.bsdfs`` have no name here: ``closure_kind`` returns their numbers.
_KINDS = (
    *("lambert", "oren_nayar", "translucent", "sheen", "velvet", "subsurface"),
    *bsdfs.closures(bsdfs.Group.DIFFUSE),
    *("microfacet", "facets", "ashikhmin_shirley", "thin_glass"),
    *bsdfs.closures(bsdfs.Group.GLOSSY),
    *bsdfs.closures(bsdfs.Group.OTHER),
    "straight",
)
closure_kind = _KINDS.index
LAMBERT, OREN_NAYAR, TRANSLUCENT, SHEEN, VELVET, SUBSURFACE = range(6)
MICROFACET = closure_kind("microfacet")
FACETS, ASHIKHMIN_SHIRLEY, THIN_GLASS = range(MICROFACET + 1, MICROFACET + 4)
LAST_GLOSSY = THIN_GLASS + len(
    bsdfs.closures(bsdfs.Group.GLOSSY)
)  # from MICROFACET to here they are dark if caustics are off
CHIANG, HAIR, HUANG, PORTAL = map(closure_kind, ("chiang", "hair", "huang", "portal"))
STRAIGHT = len(_KINDS) - 1

# Fresnel terms of a microfacet closure. DIELECTRIC is the real Fresnel curve remapped from its own F0 … 1 to f0 … 1.
FRESNEL_NONE, FRESNEL_DIELECTRIC, FRESNEL_F82, FRESNEL_CONDUCTOR = range(4)

# Distributions of the normals of microfacets.
GGX, BECKMANN = range(2)

# Methods of subsurface scattering, as in ``special.subsurface``.
BURLEY, RANDOM_WALK, RANDOM_WALK_LEGACY, RANDOM_WALK_SKIN = range(4)

NEGLIGIBLE = 1e-5  # a closure with less weight is left out
THINNEST_FILM = 0.1  # nanometres; thinner films have no effect

CLOSURE = np.dtype(
    [
        ("kind", "i4"),
        ("fresnel", "i4"),
        ("reflects", "i4"),
        ("transmits", "i4"),
        ("singular", "i4"),
        ("bumped", "i4"),  # its normal is not the surface's: the bump shadowing term applies
        ("distribution", "i4"),  # of FACETS; of SUBSURFACE the method; of CHIANG and HUANG: ``fibers.cuts_light_rays``
        ("weight", "f8", 3),
        ("pick", "f8"),  # probability that sample() draws this closure
        ("normal", "f8", 3),
        ("alpha", "f8"),  # GGX roughness; of FACETS along the tangent
        ("ior", "f8"),  # of the far side relative to that of wo
        ("f0", "f8", 3),  # of a conductor: n
        ("edge", "f8", 3),  # the term B of F82-Tint; of a conductor: k
        ("reflection_tint", "f8", 3),
        ("transmission_tint", "f8", 3),
        ("a", "f8"),  # Oren-Nayar: A; sheen: the LTC's A; FACETS: alpha across the tangent
        ("b", "f8"),  # Oren-Nayar: B; sheen: the LTC's B; FACETS: thickness of a film in nanometres
        ("c", "f8"),  # FACETS: index of the film relative to that of the side of wo
        # Of Oren-Nayar. Of microfacets, the first: the part of the weight that is left without multiple scattering.
        ("multiscatter", "f8", 3),
        ("tangent", "f8", 3),  # of anisotropic FACETS, and of hair
        ("thin_film", "f8", 3),  # reflectance of FACETS under a film, seen along wo
    ],
    align=True,
)

# Tables of a workspace and how many elements each has.
WORKSPACE_TABLES = {"surface": SURFACE, "closures": CLOSURE, "registers": np.dtype("f8")}
WORKSPACE_COUNTS = {"surface": 1, "closures": CLOSURES, "registers": REGISTERS}

surface_table = table("surface", SURFACE)
closure_table = table("closures", CLOSURE)
