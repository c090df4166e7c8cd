# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials as graphs of nodes, independent of Blender and of any back end.

``NODES`` is the one table of what a node is: sync maps Blender's nodes to it, back ends compile or evaluate it.
"""

from __future__ import annotations

from dataclasses import dataclass, field

Value = "float | tuple[float, float, float] | Node"

WHITE = (1.0, 1.0, 1.0)
GREY = (0.8, 0.8, 0.8)

# kind -> inputs with their defaults. A 3-tuple is a colour or a vector; None for a normal means the shading normal,
# None for a vector the active UV map, None for a closure black. A node may stand in the place of any value; a value
# where a closure is expected emits it, a closure where a value is expected is that input's default.
NODES: dict[str, dict[str, object]] = {
    # closures
    "diffuse": dict(color=GREY, roughness=0.0, normal=None),
    "glossy": dict(color=GREY, roughness=0.5, normal=None),
    "glass": dict(color=WHITE, roughness=0.0, ior=1.5, normal=None),
    "refraction": dict(color=WHITE, roughness=0.0, ior=1.45, normal=None),
    "transparent": dict(color=WHITE),
    "translucent": dict(color=GREY, normal=None),
    "emission": dict(color=WHITE, strength=1.0),
    "holdout": dict(),
    # settings of glossy, glass, principled: distribution ("MULTI_GGX", the default, | "GGX")
    "principled": dict(
        base_color=GREY, metallic=0.0, roughness=0.5, ior=1.5, alpha=1.0, normal=None, diffuse_roughness=0.0,
        specular_ior_level=0.5, specular_tint=WHITE, transmission_weight=0.0,
        coat_weight=0.0, coat_roughness=0.03, coat_ior=1.5, coat_tint=WHITE, coat_normal=None,
        sheen_weight=0.0, sheen_roughness=0.5, sheen_tint=WHITE, emission_color=WHITE, emission_strength=0.0),
    "mix_closure": dict(factor=0.5, a=None, b=None),
    "add_closure": dict(a=None, b=None),
    # values
    # settings: image (index or None), interpolation ("Linear" | "Closest" | "Cubic"), extension ("REPEAT" | "EXTEND" |
    # "CLIP" | "MIRROR"), projection ("FLAT" | "SPHERE" | "TUBE"), output ("color" | "alpha"), and associated (colour
    # times alpha, which Blender gives where the Alpha output is not linked; False by default)
    "image": dict(vector=None),
    "uv": dict(),  # settings: uv_map ("" is the active one)
    # settings: type ("POINT" | "TEXTURE" | "VECTOR" | "NORMAL")
    "mapping": dict(vector=None, location=(0.0, 0.0, 0.0), rotation=(0.0, 0.0, 0.0), scale=WHITE),
    "normal_map": dict(color=(0.5, 0.5, 1.0), strength=1.0),  # settings: uv_map, space ("TANGENT" | "OBJECT" | "WORLD")
    "bump": dict(strength=1.0, distance=1.0, height=1.0, normal=None),  # settings: invert
}


@dataclass(frozen=True, eq=False)
class Node:
    """One node: its kind (a key of ``NODES``), the inputs that differ from the defaults, and settings that are not
    values. Nodes are compared by identity, so a node used twice is computed once."""

    kind: str
    inputs: dict[str, object] = field(default_factory=dict)
    settings: dict[str, object] = field(default_factory=dict)

    def __post_init__(self):
        unknown = set(self.inputs) - set(NODES[self.kind])
        if unknown:
            raise ValueError(f"node {self.kind!r} has no input {sorted(unknown)}")

    def __getitem__(self, name: str):
        return self.inputs.get(name, NODES[self.kind][name])


@dataclass
class Material:
    """A surface: the closure that its graph ends in (None: black)."""

    name: str
    surface: Node | None = None
    sample_emission: bool = True
