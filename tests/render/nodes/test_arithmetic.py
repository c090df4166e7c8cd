# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Value nodes that calculate give what Cycles gives, in every mode that this Blender has."""

import itertools

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")

from tests.render.nodes.support import COUNT, Case, Picture  # noqa: E402

_random = np.random.default_rng(7)

# Binary fractions: sums, differences and whole quotients are exact, so both sides of a jump are the same in float32.
_NUMBERS = np.array([-2.375, -1.0, -0.5, 0.0, 0.5, 1.0, 1.75, 3.0])
_PARTS = np.array([-0.5, 0.0, 0.0, 0.25, 0.375, 0.5, 0.75, 1.0, 1.0, 1.5])
A, B = np.repeat(_NUMBERS, 8), np.tile(_NUMBERS, 8)
C = _random.choice([-1.5, -0.25, 0.0, 0.125, 0.5, 1.0, 2.25], COUNT)
U, V, W = _random.choice(_NUMBERS, (3, COUNT, 3))
COLOR, OTHER = _random.choice(_PARTS, (2, COUNT, 3))
COLOR[:8], OTHER[4:12] = _PARTS[1:9, None], _PARTS[1:9, None]  # greys
FACTOR = np.tile([-0.25, 0.0, 0.25, 0.5, 0.75, 1.0, 1.0, 1.5], 8)
ANGLES = _random.uniform(-4.0, 4.0, (COUNT, 3))
VECTORS = dict(data_type="FLOAT_VECTOR")
UNIT = _random.normal(size=(COUNT, 3))
UNIT /= np.linalg.norm(UNIT, axis=1)[:, None]


def _exists(name: str) -> bool:
    return hasattr(bpy.types, name)


def _modes(node: str, setting: str) -> list[str]:
    return [item.identifier for item in getattr(bpy.types, node).bl_rna.properties[setting].enum_items]


def _maths():
    numbers, vectors = dict(Value=A, Value_001=B, Value_002=C), dict(Vector=U, Vector_001=V, Vector_002=W, Scale=C)
    for operation in _modes("ShaderNodeMath", "operation"):
        yield Case("ShaderNodeMath", "Value", numbers, dict(operation=operation))
        yield Case(
            "ShaderNodeMath",
            "Value",
            dict(numbers, Value_001=0.5, Value_002=0.25),
            dict(operation=operation, use_clamp=True),
            label="constants",
        )
    for exponent in (-2.0, -0.5, 0.0, 0.5, 1.0, 3.0, 17.0):
        inputs = dict(Value=A, Value_001=exponent)
        yield Case("ShaderNodeMath", "Value", inputs, dict(operation="POWER"), label=f"{exponent}")
    for operation in _modes("ShaderNodeVectorMath", "operation"):
        for output in ("Vector", "Value"):
            yield Case("ShaderNodeVectorMath", output, vectors, dict(operation=operation))
    for kind in _modes("ShaderNodeClamp", "clamp_type"):
        yield Case("ShaderNodeClamp", "Result", dict(Value=A, Min=B, Max=C), dict(clamp_type=kind))
    for interpolation, clamp in itertools.product(_modes("ShaderNodeMapRange", "interpolation_type"), (False, True)):
        settings = dict(interpolation_type=interpolation, clamp=clamp)
        yield Case(
            "ShaderNodeMapRange",
            "Result",
            {"Value": A, "From Min": C, "From Max": B, "To Min": -1.25, "To Max": U[:, 0], "Steps": V[:, 0]},
            settings,
        )
        bounds = dict(
            From_Min_FLOAT3=V,
            From_Max_FLOAT3=W,
            To_Min_FLOAT3=OTHER,
            To_Max_FLOAT3=(1.0, -2.0, 0.0),
            Steps_FLOAT3=COLOR,
        )
        yield Case("ShaderNodeMapRange", "Vector", dict(bounds, Vector=U), settings | VECTORS)
        yield Case("ShaderNodeMapRange", "Vector", bounds, settings | VECTORS, label="not linked")
        empty = {"Value": 2.0, "From Min": 0.5, "From Max": 0.5, "To Min": 0.25, "To Max": 3.0}
        yield Case("ShaderNodeMapRange", "Result", empty, settings, label="empty, of constants")
        yield Case("ShaderNodeMapRange", "Result", dict(empty, Value=A), settings, label="empty")
        bounds = dict(From_Min_FLOAT3=V, From_Max_FLOAT3=V, To_Min_FLOAT3=OTHER, To_Max_FLOAT3=COLOR)
        yield Case("ShaderNodeMapRange", "Vector", dict(bounds, Vector=U), settings | VECTORS, label="empty")
        bounds = dict.fromkeys(bounds, (0.5, 0.25, -0.75)) | dict(To_Max_FLOAT3=(1.0, -2.0, 0.0))
        yield Case("ShaderNodeMapRange", "Vector", bounds, settings | VECTORS, label="empty, of constants")


def _mixes():
    for clamp in (False, True):
        yield Case(
            "ShaderNodeMix",
            "Result_Float",
            dict(Factor_Float=FACTOR, A_Float=A, B_Float=B),
            dict(data_type="FLOAT", clamp_factor=clamp),
        )
        for mode in _modes("ShaderNodeMix", "factor_mode"):
            yield Case(
                "ShaderNodeMix",
                "Result_Vector",
                dict(Factor_Float=FACTOR, Factor_Vector=COLOR, A_Vector=U, B_Vector=V),
                dict(data_type="VECTOR", clamp_factor=clamp, factor_mode=mode),
            )
    for blend in _modes("ShaderNodeMix", "blend_type"):
        colors = dict(A_Color=COLOR, B_Color=OTHER)
        for clamp in (False, True):
            yield Case(
                "ShaderNodeMix",
                "Result_Color",
                dict(Factor_Float=FACTOR, **colors),
                dict(data_type="RGBA", blend_type=blend, clamp_factor=clamp, clamp_result=clamp),
            )
        for factor in (0.0, 0.5, 1.0):
            yield Case(
                "ShaderNodeMix",
                "Result_Color",
                dict(Factor_Float=factor, **colors),
                dict(data_type="RGBA", blend_type=blend),
                label=f"{factor}",
            )
        yield Case(
            "ShaderNodeMix",
            "Result_Color",
            dict(Factor_Float=0.0, A_Color=(0.25, -0.5, 1.5), B_Color=(1.0, 0.5, 0.0)),
            dict(data_type="RGBA", blend_type=blend),
            label="constants",
        )
        for clamp in (False, True):
            yield Case(
                "ShaderNodeMixRGB",
                "Color",
                dict(Fac=FACTOR, Color1=COLOR, Color2=OTHER),
                dict(blend_type=blend, use_clamp=clamp),
            )


def _colors():
    yield Case("ShaderNodeHueSaturation", "Color", dict(Hue=A, Saturation=C, Value=B, Fac=FACTOR, Color=COLOR))
    for hue in (0.0, 0.25, 0.5, 1.0):
        yield Case("ShaderNodeHueSaturation", "Color", dict(Hue=hue, Saturation=1.25, Value=0.75, Fac=1.0, Color=COLOR))
    yield Case("ShaderNodeBrightContrast", "Color", dict(Color=COLOR, Bright=A, Contrast=B))
    yield Case("ShaderNodeGamma", "Color", dict(Color=COLOR, Gamma=A))
    for exponent in (0.0, 1.0, 2.2):
        yield Case("ShaderNodeGamma", "Color", dict(Color=COLOR, Gamma=exponent), label=f"{exponent}")
    yield Case("ShaderNodeInvert", "Color", dict(Color=COLOR, Fac=FACTOR))
    yield Case("ShaderNodeRGBToBW", "Val", dict(Color=COLOR))
    for mode in _modes("ShaderNodeSeparateColor", "mode"):
        for output in ("Red", "Green", "Blue"):
            yield Case("ShaderNodeSeparateColor", output, dict(Color=COLOR), dict(mode=mode))
        yield Case("ShaderNodeCombineColor", "Color", dict(Red=A, Green=B, Blue=C), dict(mode=mode))
        yield Case("ShaderNodeCombineColor", "Color", dict(Red=FACTOR, Green=C, Blue=A), dict(mode=mode))
    for output in "XYZ":
        yield Case("ShaderNodeSeparateXYZ", output, dict(Vector=U))
    yield Case("ShaderNodeCombineXYZ", "Vector", dict(X=A, Y=B, Z=C))
    for node, made_of, outputs in (
        ("ShaderNodeSeparateRGB", dict(Image=COLOR), "RGB"),
        ("ShaderNodeSeparateHSV", dict(Color=COLOR), "HSV"),
        ("ShaderNodeCombineRGB", dict(R=A, G=B, B=C), ("Image",)),
        ("ShaderNodeCombineHSV", dict(H=FACTOR, S=C, V=A), ("Color",)),
    ):
        for output in outputs if _exists(node) else ():
            yield Case(node, output, made_of)
    yield Case("ShaderNodeBlackbody", "Color", dict(Temperature=np.linspace(500.0, 13000.0, COUNT)))
    yield Case("ShaderNodeBlackbody", "Color", dict(Temperature=np.linspace(790.0, 2000.0, COUNT)), label="red")
    yield Case("ShaderNodeWavelength", "Color", dict(Wavelength=np.linspace(371.0, 789.0, COUNT)))


def _stops(interpolation: str, mode: str = "RGB", hue: str = "NEAR", brightest: float = 2.0):
    def prepare(node):
        ramp = node.color_ramp
        ramp.color_mode, ramp.interpolation, ramp.hue_interpolation = mode, interpolation, hue
        ramp.elements[0].position, ramp.elements[0].color = 0.125, (1.0, 0.25, 0.0, 0.5)
        ramp.elements[1].position, ramp.elements[1].color = 0.875, (0.0, 0.5, brightest, 1.0)
        for position, color in ((0.4, (0.2, 1.0, 0.3, 0.0)), (0.5, (0.9, 0.9, 0.1, 1.0))):
            ramp.elements.new(position).color = color

    return prepare


def _points(extend: str, *curves):
    def prepare(node):
        mapping = node.mapping
        mapping.extend = extend
        for index, points in enumerate(curves):
            while len(mapping.curves[index].points) < len(points):
                mapping.curves[index].points.new(0.0, 0.0)
            for point, location in zip(mapping.curves[index].points, points):
                point.location = location
        mapping.update()

    return prepare


def _curves():
    positions = np.linspace(-0.2, 1.2, COUNT)
    for interpolation in ("EASE", "CARDINAL", "LINEAR", "B_SPLINE", "CONSTANT"):
        for output in ("Color", "Alpha"):
            prepare = _stops(interpolation)
            yield Case("ShaderNodeValToRGB", output, dict(Fac=positions), prepare=prepare, label=interpolation)
    for mode, hue in itertools.product(("HSV", "HSL"), ("NEAR", "FAR", "CW", "CCW")):
        prepare = _stops("LINEAR", mode, hue, 1.0)
        yield Case("ShaderNodeValToRGB", "Color", dict(Fac=positions), prepare=prepare, label=f"{mode} {hue}")
    yield Case("ShaderNodeValToRGB", "Color", dict(Fac=0.4375), prepare=_stops("LINEAR"), label="constant")
    rising, falling = [(0.0, 0.2), (0.3, 0.7), (1.0, 0.9)], [(0.1, 1.0), (0.5, 0.2), (0.9, 0.0)]
    wide = [(-1.0, 0.5), (0.25, -0.75), (1.0, 1.0)]
    values = np.stack([np.linspace(-1.4, 1.4, COUNT), positions[::-1], np.linspace(-0.5, 1.5, COUNT)], -1)
    for extend in ("HORIZONTAL", "EXTRAPOLATED"):
        yield Case(
            "ShaderNodeRGBCurve",
            "Color",
            dict(Color=values, Fac=FACTOR),
            prepare=_points(extend, rising, falling, rising[::-1], falling[::-1]),
            label=extend,
        )
        yield Case(
            "ShaderNodeVectorCurve",
            "Vector",
            dict(Vector=values, Fac=FACTOR),
            prepare=_points(extend, wide, rising, falling),
            label=extend,
        )
        yield Case("ShaderNodeVectorCurve", "Vector", dict(Vector=values, Fac=0.75), label=extend + " as it is")
        yield Case(
            "ShaderNodeFloatCurve",
            "Value",
            dict(Value=positions, Factor=FACTOR),
            prepare=_points(extend, falling),
            label=extend,
        )


def _set_output(index: int, value):
    def prepare(node):
        node.outputs[index].default_value = value

    return prepare


def _vectors():
    for kind in _modes("ShaderNodeMapping", "vector_type"):
        linked = dict(Vector=U, Location=V, Rotation=ANGLES, Scale=W)
        constants = dict(Vector=U, Location=(1.0, 2.0, 3.0), Rotation=(0.1, -0.2, 0.3), Scale=(0.5, 2.0, 0.0))
        yield Case("ShaderNodeMapping", "Vector", linked, dict(vector_type=kind))
        yield Case("ShaderNodeMapping", "Vector", constants, dict(vector_type=kind), label="constants")
    for kind, invert in itertools.product(_modes("ShaderNodeVectorRotate", "rotation_type"), (False, True)):
        settings = dict(rotation_type=kind, invert=invert)
        inputs = dict(Vector=U, Center=V, Axis=W, Angle=ANGLES[:, 0], Rotation=ANGLES)
        if kind != "EULER_XYZ":
            del inputs["Rotation"]
        yield Case("ShaderNodeVectorRotate", "Vector", inputs, settings)
    yield Case("ShaderNodeVectorRotate", "Vector", dict(Vector=U, Axis=(0.0, 0.0, 0.0), Angle=1.0), label="no axis")
    yield Case("ShaderNodeVectorRotate", "Vector", dict(Center=(1.0, 2.0, 3.0), Angle=1.0), label="not linked")
    spaces = _modes("ShaderNodeVectorTransform", "convert_from")
    for kind, start, end in itertools.product(_modes("ShaderNodeVectorTransform", "vector_type"), spaces, spaces):
        yield Case(
            "ShaderNodeVectorTransform",
            "Vector",
            dict(Vector=UNIT * 2.5),
            dict(vector_type=kind, convert_from=start, convert_to=end),
        )
    for output in ("Normal", "Dot"):
        yield Case("ShaderNodeNormal", output, dict(Normal=UNIT * 1.5), prepare=_set_output(0, (0.25, -0.5, 0.75)))
    yield Case("ShaderNodeValue", "Value", prepare=_set_output(0, -1.75))
    yield Case("ShaderNodeRGB", "Color", prepare=_set_output(0, (0.25, 1.5, -0.75, 1.0)))


def _tilings():
    if not _exists("ShaderNodeRadialTiling"):
        return
    vector = _random.uniform(-1.5, 1.5, (COUNT, 3))
    vector[0] = 0.0
    shapes = itertools.product((2.5, 3.0, 4.25, 5.0, 6.0, 8.75), (0.0, 0.3, 1.0))
    for (sides, roundness), normalize in itertools.product([*shapes, (2.0, 0.0)], (False, True)):
        for output in ("Segment Coordinates", "Segment ID", "Segment Width", "Segment Rotation"):
            yield Case(
                "ShaderNodeRadialTiling",
                output,
                dict(Vector=vector, Sides=sides, Roundness=roundness),
                dict(normalize=normalize),
                label=f"{sides} {roundness}",
            )
    yield Case(
        "ShaderNodeRadialTiling",
        "Segment Coordinates",
        dict(Vector=vector, Sides=_random.uniform(2.1, 9.0, COUNT), Roundness=_random.uniform(0.1, 1.5, COUNT)),
    )


def _views():
    # Without a link the cosine is 1, and powers up to 50000 of it are as inexact as it is in float32.
    for inputs, blend in ((dict(Normal=UNIT), FACTOR), ({}, np.minimum(FACTOR, 0.75))):
        yield Case("ShaderNodeFresnel", "Fac", dict(inputs, IOR=A if inputs else np.abs(A) + 0.25))
        yield Case("ShaderNodeFresnel", "Fac", dict(inputs, IOR=1.5), label="glass")
        for output in ("Fresnel", "Facing"):
            yield Case("ShaderNodeLayerWeight", output, dict(inputs, Blend=blend))
            yield Case("ShaderNodeLayerWeight", output, dict(inputs, Blend=0.3), label="constant")


def _conversions():
    for as_colors in (False, True):
        adds = dict(operation="ADD")
        yield Case("ShaderNodeMath", "Value", dict(Value=COLOR, Value_001=U), adds, as_colors=as_colors)
        yield Case("ShaderNodeVectorMath", "Vector", dict(Vector=A, Vector_001=U), adds, as_colors=as_colors)
    yield Case("ShaderNodeGamma", "Color", dict(Color=A, Gamma=COLOR))


def _light():
    for output in [socket.identifier for socket in _node("ShaderNodeLightPath").outputs]:
        yield Case("ShaderNodeLightPath", output)
    for output in ("Quadratic", "Linear", "Constant"):
        yield Case("ShaderNodeLightFalloff", output, dict(Strength=A, Smooth=B))
        yield Case("ShaderNodeLightFalloff", output, dict(Strength=A, Smooth=0.0), label="not smooth")


def _constants():
    if bpy.app.version >= (5, 2):
        yield Case("FunctionNodeInputVector", "Vector", settings=dict(vector=(0.25, 1.5, -0.75)))
        yield Case("FunctionNodeInputInt", "Integer", settings=dict(integer=-3))
        yield Case("FunctionNodeInputBool", "Boolean", settings=dict(boolean=True))
        yield Case("GeometryNodeInputSceneTime", "Seconds")
        yield Case("GeometryNodeInputSceneTime", "Frame")
    for value in (A, 0.5, B, C):
        yield Case("ShaderNodeSqueeze", "Value", dict(Value=value))


def _node(name: str):
    return bpy.data.node_groups.new("Any", "ShaderNodeTree").nodes.new(name)


_GROUPS = [_maths, _mixes, _colors, _curves, _vectors, _tilings, _views, _conversions, _light, _constants]

# Blackbody of Blender 5.0 has another rounding of the matrix of Rec. 709, by 0.02 %.
TOLERANCE = 3e-4 if (5, 0) <= bpy.app.version < (5, 2) else 1e-4


def _compare(picture: Picture, folder) -> None:
    expected = picture.in_cycles(folder)
    for folded in (False, True):
        error = np.abs(picture.in_formulas(folded) - expected) / (TOLERANCE * np.abs(expected) + 1e-5)
        wrong = [
            f"{case}: {row.max():.3g} × the tolerance at {np.unravel_index(np.argmax(row), row.shape)}"
            for case, row in zip(picture.cases, error)
            if not row.max() <= 1.0
        ]
        assert not wrong, "\n".join(wrong)


@pytest.mark.parametrize("group", _GROUPS, ids=lambda group: group.__name__[1:])
def test_nodes_give_what_cycles_gives(group, tmp_path):
    cases = list(group())
    if not cases:
        pytest.skip("this Blender does not have the node")
    _compare(Picture(cases), tmp_path)


@pytest.mark.skipif(bpy.app.version < (5, 0), reason="the working space is always Rec. 709")
@pytest.mark.parametrize("working_space", ["Linear Rec.2020", "ACEScg"])
def test_colors_are_those_of_the_working_space(working_space, tmp_path):
    _compare(Picture([*_colors(), *_conversions()], working_space), tmp_path)


def test_what_is_not_modelled_is_reported(tmp_path):
    picture = Picture([Case("ShaderNodeSqueeze", "Value", dict(Value=A))] * 4)
    picture.in_formulas(False)
    assert len(picture.warnings) == 4 and all("Cycles does not know it" in text for text in picture.warnings)
