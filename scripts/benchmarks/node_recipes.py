# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The inputs with which each shader node shows structure in a picture of a few pixels; see ``node_cases``."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import bpy

from . import node_data as data
from .node_sources import bumped, far, normal_color, place, sideways, snapped, snapped_number, wavy

PLANE, BACK, BALL, BOX = "plane", "back", "ball", "box"


@dataclass(frozen=True)
class Recipe:
    """The inputs of a node, and its examined modes.

    ``feeds``: socket identifier -> name of a source, a constant, or a function of (graph, sources). ``variants``: name
    -> feeds besides those and, by names with a dot before them, settings: ``.invert``. ``instead``: mode -> feeds,
    where others would make a pattern too fine to compare. ``together``: settings that are combined; those that are not
    are changed alone. ``matters``: whether a combination differs from one with fewer changes. ``nested``: settings of
    settings, such as a colour ramp's, with their values. ``outputs``: those that are looked at in every combination;
    others in the first one and in variants. ``shape``: the object, of which a value takes a plane otherwise;
    ``shapes``: further variants, that differ by their shape. ``prepare(node, variant)`` gives the node its data.
    ``rays``: the node sends rays of its own. ``scattered``: what it gives is looked at by scattered rays, too.
    """

    feeds: dict = field(default_factory=dict)
    variants: dict[str, dict] = field(default_factory=dict)
    instead: dict[str, dict] = field(default_factory=dict)
    together: tuple[str, ...] | None = None
    matters: Callable[[dict], bool] = lambda modes: True
    nested: dict[str, tuple] = field(default_factory=dict)
    ignored: tuple[str, ...] = ()
    outputs: tuple[str, ...] | None = None
    shape: str | Callable[[dict], str] = ""
    shapes: dict[str, str] = field(default_factory=dict)
    prepare: Callable | None = None
    rays: bool = False
    scattered: bool = False


# Nodes that are not compared, and the reason.
LEFT_OUT = {
    "ShaderNodeScript": "Open Shading Language, which Cycles runs only in a special mode",
    "ShaderNodeEeveeSpecular": "only EEVEE has it",
    "ShaderNodeOutputLineStyle": "of line styles, which Freestyle reads",
    "ShaderNodeUVAlongStroke": "of line styles, which Freestyle reads",
    "ShaderNodeOutputAOV": "an output: it makes a pass",
    "ShaderNodeOutputMaterial": "an output: every case has one",
    "ShaderNodeOutputWorld": "an output: every case of a world has one",
    "ShaderNodeOutputLight": "an output: every case of a light has one",
    "ShaderNodeGroup": "see Groups, among the special cases",
}


RUST = (0.8, 0.5, 0.2)


def _each(node: str, setting: str, feeds: dict) -> dict[str, dict]:
    """A variant for each value of an enumeration of a node, with the same inputs."""
    items = getattr(bpy.types, node).bl_rna.properties[setting].enum_items
    return {item.identifier.lower().replace("_", " "): feeds | {f".{setting}": item.identifier} for item in items}


def _number(value: float):
    """A number beyond the limits of a socket."""

    def build(sources):
        socket = sources.graph.node("ShaderNodeValue")
        socket.default_value = value
        return socket

    return build


def _constant_vector(sources):
    return sources.graph.node("ShaderNodeCombineXYZ", X=0.3, Y=-0.7, Z=1.4)


def _diffuse(sources):
    return sources.graph.node("ShaderNodeBsdfDiffuse", Color=RUST)


def _glossy(sources):
    return sources.graph.node("ShaderNodeBsdfAnisotropic", Color=(0.3, 0.6, 0.9), Roughness=0.2)


def _uv_tangent(sources):
    return sources.graph.node("ShaderNodeTangent", direction_type="UV_MAP")


def _voronoi(modes: dict) -> bool:
    """Distances differ if more than one axis counts; the n-sphere and the edge have only the Euclidean one."""
    metric = modes["distance"] == "EUCLIDEAN"
    if modes["voronoi_dimensions"] == "1D" or modes["feature"] in {"DISTANCE_TO_EDGE", "N_SPHERE_RADIUS"}:
        return metric
    return True


def _mix(modes: dict) -> bool:
    colors, vectors = modes["data_type"] == "RGBA", modes["data_type"] == "VECTOR"
    return (
        (colors or modes["blend_type"] == "MIX" and not modes["clamp_result"])
        and (vectors or modes["factor_mode"] == "UNIFORM")
        and (not modes["clamp_result"] or modes["blend_type"] in {"ADD", "SUBTRACT", "DIVIDE"})
        and (modes["clamp_factor"] or modes["blend_type"] == "MIX")
    )


def _wave(modes: dict) -> bool:
    return modes["rings_direction" if modes["wave_type"] == "BANDS" else "bands_direction"] == "X"


def _ramp(modes: dict) -> bool:
    plain = modes["color_ramp.color_mode"] == "RGB"
    return (
        modes["color_ramp.interpolation"] == "LINEAR" if not plain else modes["color_ramp.hue_interpolation"] == "NEAR"
    )


def _image(modes: dict) -> bool:
    """The region beyond a picture shows if it lies flat; "Smart" is cubic."""
    return modes["projection"] == "FLAT" and modes["interpolation"] != "Smart" or modes["extension"] == "REPEAT"


def _curved(modes: dict) -> str:
    return PLANE if modes["projection"] in {"FLAT", "TUBE"} else BALL


def _tangent(modes: dict) -> bool:
    return modes["direction_type"] == "RADIAL" or modes["axis"] == "Z"


_TEXTURE = dict(Vector="vector")
_COLORS = dict(Color1="color", Color2="color2", Fac="factor")

RECIPES: dict[str, Recipe] = {
    # -- numbers ------------------------------------------------------------------------------------------------------
    "ShaderNodeMath": Recipe(
        dict(Value="x", Value_001="y", Value_002=0.713),
        variants={"of constants": dict(Value=1.37, Value_001=0.61)}
        | {
            f"{operation.lower()} by less than zero": {".operation": operation, "Value_001": -0.83}
            for operation in ("MODULO", "FLOORED_MODULO", "SNAP", "POWER")
        },
        instead=dict.fromkeys(("MODULO", "FLOORED_MODULO", "SNAP"), dict(Value_001=0.613))
        | dict.fromkeys(("WRAP", "PINGPONG"), dict(Value_001=1.63)),
    ),
    "ShaderNodeClamp": Recipe(
        dict(Value="x", Min="factor_y", Max=0.913), variants={"swapped": dict(Min=1.2, Max=-0.7)}
    ),
    "ShaderNodeMapRange": Recipe(
        {
            "Value": "x",
            "From Min": -1.3,
            "From Max": 1.4,
            "To Min": 0.2,
            "To Max": "y",
            "Steps": 3.7,
            "Vector": "vector",
            "From_Min_FLOAT3": (-1.0, -1.3, -0.2),
            "From_Max_FLOAT3": (1.1, 1.4, 0.9),
            "To_Min_FLOAT3": (0.1, 0.9, 0.3),
            "To_Max_FLOAT3": "vector2",
            "Steps_FLOAT3": (3.0, 4.6, 2.0),
        },
        variants={"of no width": {"From Min": 0.5, "From Max": 0.5}},
        together=("interpolation_type", "data_type", "clamp"),
    ),
    "ShaderNodeFloatCurve": Recipe(
        dict(Factor="factor_y", Value="factor"),
        prepare=data.curves,
        nested={"mapping.extend": ("EXTRAPOLATED", "HORIZONTAL")},
    ),
    "ShaderNodeSqueeze": Recipe(dict(Value="x", Width="y", Center=0.3)),
    "ShaderNodeValue": Recipe(prepare=data.value),
    # -- vectors ------------------------------------------------------------------------------------------------------
    "ShaderNodeVectorMath": Recipe(
        dict(Vector="vector", Vector_001="vector2", Vector_002="vector3", Scale="x"),
        variants={"of constants": dict(Vector=(0.3, -1.7, 0.9), Vector_001=(0.6, 0.8, 1.3))},
        instead={name: dict(Vector_001=(0.83, -1.31, 0.67)) for name in ("MODULO", "SNAP")},
    ),
    "ShaderNodeVectorRotate": Recipe(
        dict(Vector="vector", Center=(0.3, -0.4, 0.7), Axis=(0.3, -0.5, 0.9), Angle="x", Rotation="vector2"),
        variants={"about no axis": dict(Axis=(0.0, 0.0, 0.0))},
        together=("rotation_type", "invert"),
    ),
    "ShaderNodeVectorTransform": Recipe(dict(Vector="vector")),
    "ShaderNodeVectorCurve": Recipe(
        dict(Fac="factor_y", Vector="color"),
        prepare=data.curves,
        nested={"mapping.extend": ("EXTRAPOLATED", "HORIZONTAL")},
    ),
    "ShaderNodeMapping": Recipe(
        dict(Vector="vector", Location=(0.3, -0.7, 0.2), Rotation=(0.4, -0.9, 1.3), Scale=(0.7, 1.9, -1.2)),
        variants={
            "of varying numbers": dict(Location="vector2", Rotation="vector3", Scale="vector"),
            "of no scale": dict(Scale=(0.0, 1.0, 2.0)),
        },
    ),
    "ShaderNodeCombineXYZ": Recipe(dict(X="x", Y="y", Z=0.4)),
    "ShaderNodeSeparateXYZ": Recipe(dict(Vector="vector")),
    "ShaderNodeNormal": Recipe(dict(Normal="vector"), prepare=data.normal),
    "ShaderNodeRadialTiling": Recipe(
        dict(Vector="flat", Sides="sides", Roundness=0.0),
        variants={
            "round": dict(Roundness=0.6, Sides=5.0),
            "of two sides": dict(Sides=2.0),
            "all round": dict(Roundness=1.0, Sides=5.0),
            "of varying roundness": dict(Roundness="factor_y", Sides=6.0),
        },
    ),
    # -- colours ------------------------------------------------------------------------------------------------------
    "ShaderNodeMix": Recipe(
        dict(
            Factor_Float="factor",
            Factor_Vector="color",
            A_Float="x",
            B_Float="y",
            A_Vector="vector",
            B_Vector="vector2",
            A_Color="color",
            B_Color="color2",
        ),
        matters=_mix,
        together=("data_type", "factor_mode", "blend_type", "clamp_factor", "clamp_result"),
    ),
    "ShaderNodeMixRGB": Recipe(_COLORS),
    "ShaderNodeBrightContrast": Recipe(dict(Color="color", Bright="factor", Contrast="factor_y")),
    "ShaderNodeGamma": Recipe(dict(Color="color", Gamma="positive")),
    "ShaderNodeHueSaturation": Recipe(dict(Hue="factor", Saturation="positive_y", Value=1.2, Fac=0.8, Color="color")),
    "ShaderNodeInvert": Recipe(dict(Fac="factor", Color="color")),
    "ShaderNodeRGBCurve": Recipe(
        dict(Fac="factor_y", Color="color"),
        prepare=data.curves,
        nested={"mapping.extend": ("EXTRAPOLATED", "HORIZONTAL"), "mapping.tone": ("STANDARD", "FILMLIKE")},
    ),
    "ShaderNodeRGBToBW": Recipe(dict(Color="color")),
    "ShaderNodeRGB": Recipe(prepare=data.color),
    "ShaderNodeCombineColor": Recipe(
        dict(Red="factor", Green="factor_y", Blue=0.7), variants={"of constants": dict(Red=0.3, Green=0.6, Blue=0.8)}
    ),
    "ShaderNodeSeparateColor": Recipe(dict(Color="color")),
    "ShaderNodeCombineRGB": Recipe(dict(R="x", G="y", B=0.7)),
    "ShaderNodeCombineHSV": Recipe(dict(H="factor", S="factor_y", V=0.7)),
    "ShaderNodeSeparateRGB": Recipe(dict(Image="color")),
    "ShaderNodeSeparateHSV": Recipe(dict(Color="color")),
    "ShaderNodeValToRGB": Recipe(
        dict(Fac="factor"),
        prepare=data.ramp,
        matters=_ramp,
        outputs=("Color",),
        nested={"color_ramp.interpolation": None, "color_ramp.color_mode": None, "color_ramp.hue_interpolation": None},
        variants={"of one stop": dict(), "of two stops at one place": dict()},
    ),
    "ShaderNodeBlackbody": Recipe(dict(Temperature="kelvin"), variants={"of a constant": dict(Temperature=2900.0)}),
    "ShaderNodeWavelength": Recipe(dict(Wavelength="nanometres"), variants={"of a constant": dict(Wavelength=511.0)}),
    # -- textures -----------------------------------------------------------------------------------------------------
    "ShaderNodeTexNoise": Recipe(
        _TEXTURE
        | dict(W="x", Scale=0.4, Detail=2.3, Roughness=0.55, Lacunarity=2.1, Offset=0.4, Gain=1.3, Distortion=0.0),
        together=("noise_dimensions", "noise_type", "normalize"),
        outputs=("Fac",),
        variants={
            "without detail": dict(Detail=0.0),
            "distorted": dict(Distortion=1.7),
            "rough": dict(Roughness=1.0, Detail=4.0),
            "of all detail": dict(Roughness=0.4, Detail=15.0, Scale=0.2),
            "of varying numbers": dict(Scale="unit", Detail="positive", Roughness="unit_y", Lacunarity="positive_y"),
            "distorted 1D": {".noise_dimensions": "1D", "Distortion": 0.8},
            "distorted 2D": {".noise_dimensions": "2D", "Distortion": 0.8},
            "distorted 4D": {".noise_dimensions": "4D", "Distortion": 0.8},
            "far away": dict(Vector=far),
            "of the lattice": dict(Vector="flat", Scale=0.7, Detail=0.0),
        },
    ),
    "ShaderNodeTexVoronoi": Recipe(
        _TEXTURE
        | dict(
            W="x", Scale=0.5, Detail=0.0, Roughness=0.6, Lacunarity=2.1, Smoothness=0.7, Exponent=0.7, Randomness=0.9
        ),
        together=("voronoi_dimensions", "distance", "feature"),
        matters=_voronoi,
        outputs=("Distance", "Radius"),
        variants={
            "of detail": dict(Detail=2.6),
            "of detail, normalized": {"Detail": 2.6, ".normalize": True},
            "F2 of detail": {"Detail": 1.4, ".feature": "F2"},
            "smooth, of detail": {"Detail": 2.6, ".feature": "SMOOTH_F1"},
            "edges of detail": {"Detail": 2.6, ".feature": "DISTANCE_TO_EDGE"},
            "edges, normalized": {".feature": "DISTANCE_TO_EDGE", ".normalize": True},
            "F2, normalized": {".feature": "F2", ".normalize": True},
            "Minkowski, normalized": {".distance": "MINKOWSKI", ".normalize": True},
            "not smooth": {".feature": "SMOOTH_F1", "Smoothness": 0.0},
            "very smooth": {".feature": "SMOOTH_F1", "Smoothness": 1.0},
            "regular": dict(Randomness=0.0),
            "of varying numbers": dict(Scale="positive", Randomness="unit_y"),
            "2D F1": {".voronoi_dimensions": "2D"},
            "4D F1": {".voronoi_dimensions": "4D"},
            "1D F1": {".voronoi_dimensions": "1D"},
            "F2": {".feature": "F2"},
            "smooth": {".feature": "SMOOTH_F1"},
            "4D F2": {".voronoi_dimensions": "4D", ".feature": "F2"},
            "2D smooth": {".voronoi_dimensions": "2D", ".feature": "SMOOTH_F1"},
            "4D smooth": {".voronoi_dimensions": "4D", ".feature": "SMOOTH_F1"},
            "1D smooth": {".voronoi_dimensions": "1D", ".feature": "SMOOTH_F1"},
        },
    ),
    "ShaderNodeTexWhiteNoise": Recipe(dict(Vector=snapped, W=snapped_number)),
    "ShaderNodeTexBrick": Recipe(
        dict(
            Vector="flat",
            Color1="color",
            Color2="color2",
            Mortar=(0.1, 0.5, 0.2),
            Scale=0.37,
            **{"Mortar Size": 0.08, "Mortar Smooth": 0.0, "Bias": 0.2, "Brick Width": 0.9, "Row Height": 0.45},
        ),
        variants={
            "smooth": {"Mortar Smooth": 0.6, "Mortar Size": 0.1},
            "with an offset": {".offset": 0.3, ".offset_frequency": 3},
            "squashed": {".squash": 1.7, ".squash_frequency": 3},
            "at default": {
                "Color1": (0.8, 0.8, 0.8),
                "Color2": (0.2, 0.2, 0.2),
                "Mortar": (0.0, 0.0, 0.0),
                "Mortar Size": 0.02,
                "Mortar Smooth": 0.1,
                "Bias": 0.0,
                "Brick Width": 0.5,
                "Row Height": 0.25,
                "Scale": 0.17,
            },
        },
    ),
    "ShaderNodeTexChecker": Recipe(_TEXTURE | dict(Color1="color", Color2="color2", Scale=0.6)),
    "ShaderNodeTexGabor": Recipe(
        _TEXTURE
        | {"Scale": 0.4, "Frequency": 1.7, "Anisotropy": 0.8, "Orientation 2D": 0.6, "Orientation 3D": (0.5, 0.4, 0.9)},
        variants={
            "isotropic": dict(Anisotropy=0.0),
            "of varying numbers": dict(Frequency="positive", Anisotropy="unit_y"),
        },
    ),
    "ShaderNodeTexGradient": Recipe(dict(Vector="vector3")),
    "ShaderNodeTexMagic": Recipe(
        _TEXTURE | dict(Scale=0.4, Distortion=1.2),
        variants={f"of depth {depth}": {".turbulence_depth": depth} for depth in (0, 1, 5, 10)},
    ),
    "ShaderNodeTexWave": Recipe(
        _TEXTURE
        | {
            "Scale": 0.2,
            "Distortion": 0.0,
            "Detail": 2.3,
            "Detail Scale": 1.2,
            "Detail Roughness": 0.6,
            "Phase Offset": 0.4,
        },
        matters=_wave,
        outputs=("Fac",),
        variants={
            "distorted": dict(Distortion=2.3),
            "of rings, distorted": {"Distortion": 2.3, ".wave_type": "RINGS"},
            "of varying numbers": dict(Scale="unit", Distortion="y"),
            "beyond the limits of noise": {
                "Distortion": 1.3,
                "Detail": _number(16.5),
                "Detail Roughness": _number(-0.4),
            },
        },
    ),
    "ShaderNodeTexImage": Recipe(
        dict(Vector="picture"),
        prepare=data.image,
        matters=_image,
        shape=_curved,
        outputs=("Color",),
        variants={name: {} for name in data.IMAGES}
        | {
            "clipped, of none": {".extension": "CLIP"},
            "of its own coordinates": dict(Vector=None),
            "blended": {".projection": "BOX", ".projection_blend": 0.4},
        },
    ),
    "ShaderNodeTexEnvironment": Recipe(dict(Vector="direction"), prepare=data.environment),
    "ShaderNodeTexSky": Recipe(dict(Vector="direction"), prepare=data.sky, ignored=("sun_disc",)),
    "ShaderNodeTexIES": Recipe(dict(Vector="direction", Strength=1.3), prepare=data.photometry, ignored=("mode",)),
    "ShaderNodeTexPointDensity": Recipe(_TEXTURE, together=()),
    # -- inputs -------------------------------------------------------------------------------------------------------
    "ShaderNodeTexCoord": Recipe(
        prepare=data.coordinates,
        shape=BALL,
        variants={"of another object": {}},
        shapes={"of a plane": PLANE, "of its back": BACK},
    ),
    "ShaderNodeNewGeometry": Recipe(shape=BALL, shapes={"of a plane": PLANE, "of its back": BACK}),
    "ShaderNodeAttribute": Recipe(
        prepare=data.attribute, ignored=("attribute_type",), variants={name: {} for name in data.ATTRIBUTES}
    ),
    "ShaderNodeVertexColor": Recipe(
        prepare=data.color_attribute, variants={"of corners": {}, "of the active one": {}, "of a missing one": {}}
    ),
    "ShaderNodeUVMap": Recipe(prepare=data.uv_map, variants={"by name": {}, "of a missing one": {}}),
    "ShaderNodeLightPath": Recipe(scattered=True),
    "ShaderNodeTangent": Recipe(prepare=data.tangent, shape=BALL, matters=_tangent, variants={"by name": {}}),
    "ShaderNodeFresnel": Recipe(
        dict(IOR=1.45),
        shape=BALL,
        variants={"of varying index": dict(IOR="positive"), "of a normal": dict(Normal=bumped)},
        shapes={"of its back": BACK},
    ),
    "ShaderNodeLayerWeight": Recipe(
        dict(Blend=0.4),
        shape=BALL,
        variants={"of varying blend": dict(Blend="factor"), "of a normal": dict(Normal=bumped)},
        shapes={"of its back": BACK},
    ),
    "ShaderNodeWireframe": Recipe(
        dict(Size=0.083),
        ignored=("use_pixel_size",),
        variants={"in pixels": {".use_pixel_size": True, "Size": 1.5}, "of less than zero": dict(Size=-0.083)},
        shape=lambda modes: BOX if modes["use_pixel_size"] else PLANE,
    ),
    "ShaderNodeBump": Recipe(
        dict(Strength=0.7, Distance=0.3, Height=wavy),
        shape=BALL,
        variants={
            "of varying strength": dict(Strength="factor"),
            "wide": {"Filter Width": 2.0},
            "of a normal": dict(Normal=bumped),
            "of a constant": dict(Height=_number(0.7)),
            "of a constant and a normal": dict(Height=_number(0.7), Normal=bumped),
            "of constants": dict(Height=_number(0.7), Normal=_constant_vector),
            "of a constant normal": dict(Normal=_constant_vector),
        },
    ),
    "ShaderNodeNormalMap": Recipe(
        dict(Strength=0.8, Color=normal_color),
        shape=BALL,
        ignored=("base",),
        variants={
            "of half strength": dict(Strength=0.5),
            "of varying strength": dict(Strength="factor"),
            "of another UV map": {".uv_map": data.SECOND_UV},
        },
    ),
    "ShaderNodeAmbientOcclusion": Recipe(
        dict(Color=(0.9, 0.6, 0.3), Distance=0.8),
        shape=BOX,
        rays=True,
        variants={"of a normal": dict(Normal=bumped), "far": dict(Distance=0.0)},
    ),
    "ShaderNodeBevel": Recipe(
        dict(Radius=0.15),
        shape=BOX,
        rays=True,
        variants={"of 16 samples": {".samples": 16}, "of a normal": {".samples": 16, "Normal": bumped}},
    ),
    "ShaderNodeRaycast": Recipe(
        dict(Position=place, Direction=sideways, Length=0.7), shape=BOX, variants={"of less length": dict(Length=0.3)}
    ),
    "ShaderNodeBsdfRayPortal": Recipe(
        dict(Color=(0.9, 0.6, 0.4)), variants={"elsewhere": dict(Position=(0.0, 0.0, 3.0))}
    ),
    # -- closures -----------------------------------------------------------------------------------------------------
    "ShaderNodeBsdfDiffuse": Recipe(
        dict(Color=RUST),
        variants={
            "rough": dict(Roughness=1.0),
            "of a normal": dict(Normal=bumped),
            "of varying color": dict(Color="color"),
        },
    ),
    "ShaderNodeBsdfTranslucent": Recipe(dict(Color=RUST), variants={"of a normal": dict(Normal=bumped)}),
    "ShaderNodeBsdfTransparent": Recipe(dict(Color=RUST)),
    "ShaderNodeHoldout": Recipe(),
    "ShaderNodeEmission": Recipe(dict(Color=RUST, Strength=1.7), variants={"of varying color": dict(Color="color")}),
    "ShaderNodeBsdfAnisotropic": Recipe(
        dict(Color=RUST, Roughness=0.3),
        variants={
            "anisotropic": dict(Anisotropy=0.8),
            "turned": dict(Anisotropy=0.8, Rotation=0.2),
            "anisotropic, by UVs": dict(Anisotropy=-0.6, Tangent=_uv_tangent),
            "rough": dict(Roughness=0.9),
            "sharp": dict(Roughness=0.0),
            "of a normal": dict(Normal=bumped),
        },
    ),
    "ShaderNodeBsdfGlass": Recipe(
        dict(Color=(0.9, 0.95, 1.0), Roughness=0.2, IOR=1.45),
        variants={
            "clear": dict(Roughness=0.0),
            "thin film": {"Thin Film Thickness": 450.0, "Thin Film IOR": 1.33},
            "dense": dict(IOR=2.2, Roughness=0.1),
            "of air": dict(IOR=0.8),
            "of no refraction": dict(IOR=1.0),
        },
    ),
    "ShaderNodeBsdfRefraction": Recipe(
        dict(Color=(0.9, 0.95, 1.0), Roughness=0.2, IOR=1.45), variants={"clear": dict(Roughness=0.0)}
    ),
    "ShaderNodeBsdfMetallic": Recipe(
        {"Base Color": (0.95, 0.64, 0.37), "Edge Tint": (0.9, 0.8, 0.6), "Roughness": 0.3},
        variants={
            "of an index": {
                ".fresnel_type": "PHYSICAL_CONDUCTOR",
                "IOR": (0.27, 0.68, 1.32),
                "Extinction": (3.61, 2.63, 2.29),
            },
            "anisotropic": dict(Anisotropy=0.7),
            "thin film": {"Thin Film Thickness": 350.0},
        },
    ),
    "ShaderNodeBsdfSheen": Recipe(dict(Color=RUST, Roughness=0.4), variants={"rough": dict(Roughness=0.9)}),
    "ShaderNodeBsdfToon": Recipe(
        dict(Color=RUST, Size=0.6, Smooth=0.2), variants={"sharp": dict(Smooth=0.0, Size=0.4)}
    ),
    "ShaderNodeBsdfHair": Recipe(dict(Color=RUST)),
    "ShaderNodeBsdfHairPrincipled": Recipe(dict(Color=RUST)),
    "ShaderNodeSubsurfaceScattering": Recipe(
        dict(Color=RUST, Scale=0.3, Radius=(1.0, 0.4, 0.2)),
        variants={"even": dict(Radius=(0.5, 0.5, 0.5)), "skewed": dict(Anisotropy=0.6), "deep": dict(Scale=1.5)},
    ),
    "ShaderNodeMixShader": Recipe(
        dict(Fac="factor", Shader=_diffuse, Shader_001=_glossy),
        variants={"of nothing": dict(Shader_001=None), "of a constant": dict(Fac=0.3)},
    ),
    "ShaderNodeAddShader": Recipe(
        dict(Shader=_diffuse, Shader_001=_glossy), variants={"of nothing": dict(Shader=None)}
    ),
    "ShaderNodeBackground": Recipe(dict(Color=RUST, Strength=0.7)),
    "ShaderNodeBsdfPrincipled": Recipe(
        {"Base Color": RUST},
        ignored=("subsurface_method",),
        variants={
            "metal": {"Metallic": 1.0, "Roughness": 0.25},
            "half metal": {"Metallic": 0.5},
            "metal, tinted": {"Metallic": 1.0, "Specular Tint": (0.9, 0.3, 0.2), "Roughness": 0.4},
            "anisotropic": {"Metallic": 1.0, "Anisotropic": 0.8},
            "turned": {"Metallic": 1.0, "Anisotropic": 0.8, "Anisotropic Rotation": 0.3, "Tangent": _uv_tangent},
            "sharp": {"Roughness": 0.0},
            "rough": {"Roughness": 1.0, "Diffuse Roughness": 1.0},
            "dense": {"IOR": 2.4},
            "of low specular level": {"Specular IOR Level": 0.1},
            "of high specular level": {"Specular IOR Level": 1.0},
            "specular tint": {"Specular Tint": (0.2, 0.5, 0.9), "IOR": 2.0},
            "glass": {"Transmission Weight": 1.0, "Roughness": 0.1},
            "clear glass": {"Transmission Weight": 1.0, "Roughness": 0.0},
            "half glass": {"Transmission Weight": 0.5},
            "thin wall": {"Transmission Weight": 1.0, "Thin Wall": True},
            "thin wall, rough": {"Transmission Weight": 1.0, "Thin Wall": True, "Roughness": 0.5},
            "thin wall of scattering": {"Subsurface Weight": 1.0, "Thin Wall": True},
            "coat": {"Coat Weight": 1.0, "Coat Roughness": 0.1},
            "tinted coat": {"Coat Weight": 0.8, "Coat Tint": (0.4, 0.7, 0.9)},
            "coat of a normal": {"Coat Weight": 1.0, "Coat Normal": bumped},
            "dense coat": {"Coat Weight": 1.0, "Coat IOR": 2.2},
            "sheen": {"Sheen Weight": 1.0},
            "tinted sheen": {"Sheen Weight": 0.7, "Sheen Roughness": 0.2, "Sheen Tint": RUST},
            "emission": {"Emission Color": (0.3, 0.6, 0.9), "Emission Strength": 0.6},
            "alpha": {"Alpha": 0.4},
            "varying alpha": {"Alpha": "factor"},
            "thin film": {"Thin Film Thickness": 400.0, "Roughness": 0.1},
            "thin film of metal": {
                "Metallic": 1.0,
                "Thin Film Thickness": 600.0,
                "Thin Film IOR": 1.8,
                "Roughness": 0.1,
            },
            "of a normal": {"Normal": bumped},
            "of varying color and roughness": {"Base Color": "color", "Roughness": "unit_y"},
            "all at once": {
                "Metallic": 0.3,
                "Transmission Weight": 0.3,
                "Subsurface Weight": 0.3,
                "Coat Weight": 0.5,
                "Sheen Weight": 0.4,
                "Emission Strength": 0.1,
            },
        }
        | _each(
            "ShaderNodeBsdfPrincipled",
            "subsurface_method",
            {"Subsurface Weight": 1.0, "Subsurface Scale": 0.3, "Subsurface Radius": (1.0, 0.4, 0.2)},
        )
        | {
            "half scattering": {"Subsurface Weight": 0.5, "Subsurface Scale": 0.3},
            "short scattering": {
                ".subsurface_method": "RANDOM_WALK_SKIN",
                "Subsurface Weight": 1.0,
                "Subsurface Scale": 0.005,
            },
        },
    ),
    # -- volumes ------------------------------------------------------------------------------------------------------
    "ShaderNodeVolumeAbsorption": Recipe(
        dict(Color=(0.9, 0.5, 0.3), Density=1.3), variants={"of varying density": dict(Density="object_positive")}
    ),
    "ShaderNodeVolumeScatter": Recipe(
        dict(Color=(0.9, 0.7, 0.5), Density=1.1, Anisotropy=0.4, IOR=1.33, Backscatter=0.1, Alpha=0.5, Diameter=2.0),
        variants={"even": dict(Anisotropy=0.0), "of varying density": dict(Density="object_positive")},
    ),
    "ShaderNodeVolumeCoefficients": Recipe(
        {
            "Absorption Coefficients": (0.2, 0.5, 0.9),
            "Scatter Coefficients": (1.0, 0.8, 0.5),
            "Anisotropy": 0.3,
            "IOR": 1.33,
            "Backscatter": 0.1,
            "Alpha": 0.5,
            "Diameter": 2.0,
        },
        variants={"emission": {"Emission Coefficients": (0.2, 0.1, 0.05)}},
    ),
    "ShaderNodeVolumePrincipled": Recipe(
        dict(Color=(0.8, 0.6, 0.4), Density=1.2),
        variants={
            "emission": {"Emission Strength": 0.4, "Emission Color": (0.3, 0.6, 0.9)},
            "of no density": dict(Density=0.0),
            "blackbody": {"Blackbody Intensity": 1.0, "Temperature": 1700.0},
            "absorption": {"Absorption Color": (0.5, 0.1, 0.2)},
            "of varying density": dict(Density="object_positive"),
        },
    ),
    # -- displacement -------------------------------------------------------------------------------------------------
    "ShaderNodeDisplacement": Recipe(
        dict(Height=wavy, Midlevel=0.1, Scale=0.12), variants={"of the mesh": {}, "of the mesh and bump": {}}
    ),
    "ShaderNodeVectorDisplacement": Recipe(
        dict(Vector="color", Midlevel=0.5, Scale=0.15), variants={"of the mesh": {}}
    ),
}
