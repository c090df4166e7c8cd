# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Texture nodes with all their modes, as ``render_textures.py`` renders them, and the same by the definitions here."""

import itertools

import numpy as np

from sdf_lights.graph.formula import Vector, variable
from sdf_lights.graph.numpy_evaluation import Inputs, evaluate_inputs
from sdf_lights.render.nodes import node_outputs

SIZE = 24

# Whole multiples of 1/1024: no point lies on a border of cells that are whole, or thirds.
NEAR = {
    "origin": (-1.6572265625, -1.2158203125, 0.4072265625, -2.0966796875),
    "step": (0.1455078125, 0.1181640625, 0.0576171875, 0.0869140625),
}
FAR = {"origin": (-2048.6572265625, 1001.2158203125, 4096.4072265625, -517.0966796875), "step": NEAR["step"]}
LARGE = {"origin": (-150000.125, 1250000.375, 99998.625, 100001.875), "step": (0.625, 0.625, 0.375, 0.125)}

_INPUTS = {
    "ShaderNodeTexNoise": dict(
        Scale=1.0, Detail=2.0, Roughness=0.5, Lacunarity=2.0, Offset=0.0, Gain=1.0, Distortion=0.0
    ),
    "ShaderNodeTexVoronoi": dict(
        Scale=1.0, Detail=0.0, Roughness=0.5, Lacunarity=2.0, Smoothness=1.0, Exponent=0.5, Randomness=1.0
    ),
    "ShaderNodeTexWave": {
        "Scale": 0.5,
        "Distortion": 0.0,
        "Detail": 2.0,
        "Detail Scale": 1.0,
        "Detail Roughness": 0.5,
        "Phase Offset": 0.0,
    },
    "ShaderNodeTexMagic": dict(Scale=1.0, Distortion=1.0),
    "ShaderNodeTexChecker": dict(Color1=(0.8, 0.1, 0.3), Color2=(0.2, 0.9, 0.4), Scale=2.5),
    "ShaderNodeTexBrick": {
        "Color1": (0.8, 0.1, 0.3),
        "Color2": (0.2, 0.9, 0.4),
        "Mortar": (0.1, 0.2, 0.6),
        "Scale": 1.0,
        "Mortar Size": 0.02,
        "Mortar Smooth": 0.1,
        "Bias": 0.0,
        "Brick Width": 0.5,
        "Row Height": 0.25,
    },
    "ShaderNodeTexGradient": {},
    "ShaderNodeTexWhiteNoise": {},
    "ShaderNodeTexGabor": {
        "Scale": 1.0,
        "Frequency": 2.0,
        "Anisotropy": 1.0,
        "Orientation 2D": 0.7,
        "Orientation 3D": (0.8, 0.4, 0.3),
    },
}
_SETTINGS = {
    "ShaderNodeTexNoise": dict(noise_dimensions="3D", noise_type="FBM", normalize=True),
    "ShaderNodeTexVoronoi": dict(voronoi_dimensions="3D", distance="EUCLIDEAN", feature="F1", normalize=False),
    "ShaderNodeTexWave": dict(wave_type="BANDS", bands_direction="X", rings_direction="X", wave_profile="SIN"),
    "ShaderNodeTexMagic": dict(turbulence_depth=2),
    "ShaderNodeTexChecker": {},
    "ShaderNodeTexBrick": dict(offset=0.5, offset_frequency=2, squash=1.0, squash_frequency=2),
    "ShaderNodeTexGradient": dict(gradient_type="LINEAR"),
    "ShaderNodeTexWhiteNoise": dict(noise_dimensions="3D"),
    "ShaderNodeTexGabor": dict(gabor_type="2D"),
}

DIMENSIONS = ("1D", "2D", "3D", "4D")


def case(node: str, output: str, place: dict = NEAR, **changes) -> dict:
    """A case with Blender's defaults but for ``changes``: of inputs (blanks are underlines) and of settings."""
    settings, inputs = dict(_SETTINGS[node]), dict(_INPUTS[node])
    for name, value in changes.items():
        if name in settings:
            settings[name] = value
        else:
            inputs[name.replace("_", " ")] = value
    assert len(inputs) == len(_INPUTS[node])
    return {"node": node, "settings": settings, "inputs": inputs, "output": output, **place}


def _noise():
    node = "ShaderNodeTexNoise"
    kinds = "FBM", "MULTIFRACTAL", "HYBRID_MULTIFRACTAL", "RIDGED_MULTIFRACTAL", "HETERO_TERRAIN"
    rough = dict(Detail=3.4, Roughness=0.7, Lacunarity=2.25, Offset=0.7, Gain=1.5)
    for dimensions, kind in itertools.product(DIMENSIONS, kinds):
        given = dict(noise_dimensions=dimensions, noise_type=kind, **rough)
        yield case(node, "Fac", **given)
        yield case(node, "Color", normalize=False, Distortion=1.5, **given)
    for dimensions in DIMENSIONS:
        yield case(node, "Color", noise_dimensions=dimensions)
        yield case(node, "Fac", noise_dimensions=dimensions, Detail=0.0, Distortion=0.75)
        yield case(node, "Fac", FAR, noise_dimensions=dimensions, Detail=1.5)
        yield case(node, "Fac", LARGE, noise_dimensions=dimensions, Detail=0.0)
    for detail, roughness in ((20.0, 1.0), (-1.0, 0.5), (3.0, 0.0), (0.5, 1.0)):
        yield case(node, "Fac", Detail=detail, Roughness=roughness)
    yield case(node, "Fac", noise_type="RIDGED_MULTIFRACTAL", Detail=5.0, Offset=1.0, Gain=2.0, Scale=-3.0)


def _voronoi():
    node = "ShaderNodeTexVoronoi"
    for dimensions, feature in itertools.product(DIMENSIONS, ("F1", "F2", "SMOOTH_F1")):
        position = "W" if dimensions == "1D" else "Position"
        given = dict(voronoi_dimensions=dimensions, feature=feature)
        for output in ("Distance", "Color", position):
            yield case(node, output, **given)
        octaves = dict(Detail=1.6, Roughness=0.6, Lacunarity=2.25, Randomness=0.75, Smoothness=0.3, Scale=1.5)
        for output in ("Distance", "Color", position):
            yield case(node, output, normalize=True, **given, **octaves)
        yield case(node, "Color", FAR, **given)
        if dimensions == "4D":
            yield case(node, "W", **given)
    for dimensions, feature, metric in itertools.product(
        DIMENSIONS, ("F1", "F2", "SMOOTH_F1"), ("MANHATTAN", "CHEBYCHEV", "MINKOWSKI")
    ):
        yield case(node, "Distance", voronoi_dimensions=dimensions, feature=feature, distance=metric, normalize=True)
        yield case(node, "Color", voronoi_dimensions=dimensions, feature=feature, distance=metric, Exponent=3.5)
    for dimensions in DIMENSIONS:
        given = dict(voronoi_dimensions=dimensions)
        yield case(node, "Distance", feature="DISTANCE_TO_EDGE", **given)
        yield case(node, "Distance", FAR, feature="DISTANCE_TO_EDGE", Randomness=0.5, **given)
        yield case(node, "Distance", feature="DISTANCE_TO_EDGE", normalize=True, Detail=2.3, Roughness=0.8, **given)
        yield case(node, "Radius", feature="N_SPHERE_RADIUS", **given)
        yield case(node, "Radius", FAR, feature="N_SPHERE_RADIUS", Randomness=0.4, **given)
        yield case(node, "Color", feature="SMOOTH_F1", Smoothness=0.0, **given)
        yield case(node, "Distance", feature="F1", Randomness=0.0, Detail=2.0, Roughness=0.0, **given)


def _others():
    for dimensions in DIMENSIONS:
        for place in (NEAR, FAR):
            yield case("ShaderNodeTexWhiteNoise", "Value", place, noise_dimensions=dimensions)
            yield case("ShaderNodeTexWhiteNoise", "Color", place, noise_dimensions=dimensions)
    wave = "ShaderNodeTexWave"
    for direction, profile in itertools.product(("X", "Y", "Z", "DIAGONAL"), ("SIN", "SAW", "TRI")):
        yield case(wave, "Color", bands_direction=direction, wave_profile=profile, Phase_Offset=0.7)
    for direction, profile in itertools.product(("X", "Y", "Z", "SPHERICAL"), ("SIN", "SAW", "TRI")):
        yield case(wave, "Fac", wave_type="RINGS", rings_direction=direction, wave_profile=profile)
    yield case(wave, "Fac", Distortion=3.0, Detail=2.5, Detail_Scale=1.5, Detail_Roughness=0.7)
    yield case(wave, "Fac", wave_type="RINGS", Distortion=-2.0, wave_profile="SAW")
    for depth in range(11):
        yield case("ShaderNodeTexMagic", "Color", turbulence_depth=depth, Scale=1.3, Distortion=1.4)
    yield case("ShaderNodeTexMagic", "Fac", turbulence_depth=0, Distortion=0.0)
    yield case("ShaderNodeTexMagic", "Color", FAR, Scale=0.3)
    for output in ("Color", "Fac"):
        for place in (NEAR, FAR):
            yield case("ShaderNodeTexChecker", output, place, Scale=1.0)
        # On the borders of cells, as a plane or a cube of whole size is.
        borders = {"origin": (-3.0, -2.5, 0.0, 0.0), "step": (0.25, 0.125, 0.0, 0.0)}
        yield case("ShaderNodeTexChecker", output, borders, Scale=2.0)
        yield case("ShaderNodeTexBrick", output)
        yield case("ShaderNodeTexBrick", output, FAR, Scale=2.0, Bias=0.3)
        yield case(
            "ShaderNodeTexBrick",
            output,
            offset=0.3,
            offset_frequency=3,
            squash=0.6,
            squash_frequency=2,
            Mortar_Size=0.07,
            Mortar_Smooth=0.6,
            Bias=-0.3,
            Brick_Width=0.7,
            Row_Height=0.3,
        )
        yield case("ShaderNodeTexBrick", output, Mortar_Smooth=0.0, Row_Height=0.0)
    for kind in ("LINEAR", "QUADRATIC", "EASING", "DIAGONAL", "SPHERICAL", "QUADRATIC_SPHERE", "RADIAL"):
        yield case("ShaderNodeTexGradient", "Color" if kind == "LINEAR" else "Fac", gradient_type=kind)
    for dimensions, output in itertools.product(("2D", "3D"), ("Value", "Phase", "Intensity")):
        yield case("ShaderNodeTexGabor", output, gabor_type=dimensions)
        yield case("ShaderNodeTexGabor", output, gabor_type=dimensions, Anisotropy=0.4, Frequency=3.3, Scale=1.7)
        yield case("ShaderNodeTexGabor", output, FAR, gabor_type=dimensions, Anisotropy=0.0)


def _few():
    """Every node, with kernels that take few seconds to compile."""
    rough = dict(Detail=3.4, Roughness=0.7, Lacunarity=2.25, Offset=0.7, Gain=1.5)
    node = "ShaderNodeTexNoise"
    yield case(node, "Color", Distortion=0.75, Detail=3.5)
    yield case(node, "Fac", noise_dimensions="1D", noise_type="HETERO_TERRAIN", **rough)
    yield case(node, "Fac", noise_dimensions="2D", noise_type="RIDGED_MULTIFRACTAL", **rough)
    yield case(node, "Fac", noise_dimensions="4D", noise_type="HYBRID_MULTIFRACTAL", **rough)
    node = "ShaderNodeTexVoronoi"
    yield case(node, "W", voronoi_dimensions="1D")
    yield case(node, "Distance", voronoi_dimensions="2D", feature="F2", distance="MINKOWSKI", normalize=True)
    yield case(node, "Color", voronoi_dimensions="3D", Detail=1.5)
    yield case(node, "Distance", voronoi_dimensions="3D", feature="SMOOTH_F1", Smoothness=0.6)
    yield case(node, "Distance", voronoi_dimensions="2D", feature="DISTANCE_TO_EDGE")
    yield case(node, "Radius", voronoi_dimensions="4D", feature="N_SPHERE_RADIUS")
    yield from _others()


SLOW = {"noise": list(_noise()), "voronoi": list(_voronoi())}
FAST = {"few": list(_few())}


def points(origin, step) -> np.ndarray:
    """(SIZE, SIZE, 4) coordinates of a case."""
    i, j = np.meshgrid(np.arange(SIZE), np.arange(SIZE))
    return np.stack([i, j, i - j, i + j], axis=-1) * np.array(step) + np.array(origin)


class At(Inputs):
    """Variables of the coordinates (points, 4)."""

    def __init__(self, places: np.ndarray):
        self._places, self.count = places, len(places)

    def variable(self, name: str, component: int) -> np.ndarray:
        return self._places[..., component]


def _single(value):
    """As Blender keeps it."""
    return tuple(map(_single, value)) if isinstance(value, (tuple, list)) else float(np.float32(value))


def ours(given: dict, version: tuple[int, ...], every: int = 1, inputs_type=At) -> np.ndarray:
    """(points, 3) values of the case's output, by the definition of the node: row by row, those of one in ``every``."""
    x, y, z, w = (variable("place", component) for component in range(4))
    inputs = {name: _single(value) for name, value in given["inputs"].items()} | {"Vector": Vector(x, y, z), "W": w}
    settings = {
        name: _single(value) if isinstance(value, float) else value for name, value in given["settings"].items()
    }
    parameters: list = []
    outputs = node_outputs(
        given["node"], parameters, inputs, settings | {"blender_version": version}, {given["output"]}
    )
    found = outputs[given["output"]]
    formulas = tuple(found) if isinstance(found, Vector) else (found,) * 3
    places = points(given["origin"], given["step"]).reshape(-1, 4)[::every]
    values = evaluate_inputs(formulas, inputs_type(places), np.array(parameters))
    return np.stack([np.broadcast_to(value, len(places)) for value in values], axis=-1)
