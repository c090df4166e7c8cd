# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Records that shading shares with the rest of the path tracer: the surface that a ray hit, and its closures.

``SURFACE`` is the whole interface of a hit: the integrator fills the first group of fields, ``shade`` the second.
World space, metres, unit vectors, unless said.
"""

import numpy as np

from ....jit import table

UV_LAYERS = 4
CLOSURES = 64
REGISTERS = 1024

# Kinds of scattering that `sample` returns; the first three are those of scene.Ray.
DIFFUSE, GLOSSY, TRANSMISSION = 2, 4, 8
SINGULAR = 32  # a Dirac delta: evaluate() is zero there, f·|cos| / pdf is the weight of the path
TRANSPARENT = 64  # straight through, with wi = −wo; always together with SINGULAR, never with TRANSMISSION

# Flags of a material (MATERIAL["flags"]): what shading it needs of SURFACE, and what it does.
HAS_TRANSPARENCY = 1  # transparency() may be other than black
HAS_EMISSION = 2
NEEDS_UV = 4  # uv
NEEDS_TANGENT = 8  # tangent, object_normal, world_to_object
NEEDS_OBJECT = 16  # object_normal, world_to_object
NEEDS_DERIVATIVES = 32  # uv_du, uv_dv, dpdu, dpdv, footprint
HAS_SURFACE = 64  # anything that scatters

SURFACE = np.dtype([
    # Of the hit, filled before shade(). A field named under a NEEDS_ flag is read only by materials with that flag.
    ("position", "f8", 3),
    ("wo", "f8", 3),  # towards the viewer
    ("ng", "f8", 3),  # geometric normal, on the side of wo
    ("n", "f8", 3),  # interpolated shading normal, flipped together with ng
    ("uv", "f8", (UV_LAYERS, 2)),  # UV maps in the order of uv_layers(scene); zero where the mesh lacks that map
    ("uv_du", "f8", (UV_LAYERS, 2)),  # of each, the derivative by the first and by the second barycentric coordinate:
    ("uv_dv", "f8", (UV_LAYERS, 2)),  # differences along the triangle's edges from vertex 0 to 1, and from 0 to 2
    ("dpdu", "f8", 3),  # derivatives of position by the same coordinates: those edges
    ("dpdv", "f8", 3),
    ("tangent", "f8", (UV_LAYERS, 4)),  # interpolated, object space, w: sign of the bitangent, 0 where there is none
    ("object_normal", "f8", 3),  # interpolated shading normal in object space, not normalised, never flipped
    ("world_to_object", "f8", (3, 4)),
    ("footprint", "f8"),  # width of a pixel's ray at position in metres, for bump mapping; 0 where unknown
    ("material", "i4"),
    ("backfacing", "i4"),  # 1: wo is behind the triangle's own normal, ng and n have been flipped
    ("ray_kind", "i4"),  # scene.Ray of the ray that arrived
    ("instance", "i4"),
    ("primitive", "i4"),
    # Of the material, filled by shade().
    ("closure_count", "i4"),
    ("evaluable", "i4"),  # closures that are not singular; with none of them light sampling is useless
    ("emission", "f8", 3),  # radiance towards wo
    ("transparency", "f8", 3),  # what passes straight through; sample() draws it too, as TRANSPARENT
    ("albedo", "f8", 3),  # estimated directional albedo of all closures, for denoising
    ("diffuse_albedo", "f8", 3),  # the part of it that is neither reflection nor refraction by microfacets
    ("holdout", "f8"),  # weight of Holdout
    ("pick_total", "f8"),  # sum of the closures' weights for sampling, before they were normalised
], align=True)

# Kinds of closure.
LAMBERT, OREN_NAYAR, TRANSLUCENT, SHEEN, MICROFACET, STRAIGHT = range(6)

# Fresnel terms of a microfacet closure. DIELECTRIC is the real Fresnel curve remapped from its own F0 … 1 to f0 … 1.
FRESNEL_NONE, FRESNEL_DIELECTRIC, FRESNEL_F82 = range(3)

CLOSURE = np.dtype([
    ("kind", "i4"),
    ("fresnel", "i4"),
    ("reflects", "i4"),
    ("transmits", "i4"),
    ("singular", "i4"),
    ("bumped", "i4"),  # its normal is not the surface's: the bump shadowing term applies
    ("weight", "f8", 3),
    ("pick", "f8"),  # probability that sample() draws this closure
    ("normal", "f8", 3),
    ("alpha", "f8"),  # GGX roughness
    ("ior", "f8"),  # of the far side relative to that of wo
    ("f0", "f8", 3),
    ("edge", "f8", 3),  # the term B of F82-Tint
    ("reflection_tint", "f8", 3),
    ("transmission_tint", "f8", 3),
    ("a", "f8"),  # Oren-Nayar: A; sheen: the LTC's A
    ("b", "f8"),  # Oren-Nayar: B; sheen: the LTC's B
    ("multiscatter", "f8", 3),  # Oren-Nayar
], align=True)

# Tables of a workspace and how many elements each has.
WORKSPACE_TABLES = {"surface": SURFACE, "closures": CLOSURE, "registers": np.dtype("f8")}
WORKSPACE_COUNTS = {"surface": 1, "closures": CLOSURES, "registers": REGISTERS}

surface_table = table("surface", SURFACE)
closure_table = table("closures", CLOSURE)
