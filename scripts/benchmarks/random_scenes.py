# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Scenes drawn at random from what files for Cycles hold: meshes, materials, lights, worlds, cameras, limits.

Each feature has a name and random numbers of its own. So a scene is the same without some features but for these, and
what makes two engines differ can be found by leaving out one after the other.
"""

from __future__ import annotations

import math
import random

import bpy
import host
import numpy as np
from mathutils import Vector
from scenery.materials import Graph

from sdf_lights.blender.shader_trees import node_tree_of, use_nodes

from . import simple_scenes
from .node_pictures import OURS

TEXTURES = ("Noise", "Voronoi", "Wave", "Checker", "Brick", "Magic", "Gradient", "Image")
COORDINATES = ("Generated", "Normal", "UV", "Object", "Camera", "Window", "Reflection")
CLOSURES = dict(
    Diffuse="BsdfDiffuse",
    Glossy="BsdfAnisotropic",
    Glass="BsdfGlass",
    Refraction="BsdfRefraction",
    Translucent="BsdfTranslucent",
    Sheen="BsdfSheen",
    Toon="BsdfToon",
    Subsurface="SubsurfaceScattering",
    Metallic="BsdfMetallic",
    Transparent="BsdfTransparent",
    Emission="Emission",
    Hair="BsdfHair",
)
FRACTIONS = ("Roughness", "Size", "Smooth", "Anisotropy", "RoughnessU", "RoughnessV", "Offset")
KINDS = ("distribution", "component", "falloff")  # enumerations of closures
# Inputs of Principled BSDF that are set together: name of the feature, its probability, ranges of the inputs.
PRINCIPLED = (
    ("metallic", 0.3, {"Metallic": (0.0, 1.0)}),
    ("ior", 0.4, {"IOR": (1.0, 2.5)}),
    ("transmission", 0.25, {"Transmission Weight": (0.0, 1.0)}),
    ("alpha", 0.15, {"Alpha": (0.0, 1.0)}),
    ("coat", 0.25, {"Coat Weight": (0.0, 1.0), "Coat Roughness": (0.0, 0.5), "Coat IOR": (1.1, 2.0)}),
    ("sheen", 0.25, {"Sheen Weight": (0.0, 1.0), "Sheen Roughness": (0.0, 1.0)}),
    ("anisotropy", 0.2, {"Anisotropic": (0.0, 1.0), "Anisotropic Rotation": (0.0, 1.0)}),
    ("film", 0.12, {"Thin Film Thickness": (50.0, 900.0), "Thin Film IOR": (1.1, 2.0)}),
    ("subsurface", 0.15, {"Subsurface Weight": (0.0, 1.0), "Subsurface Scale": (0.01, 0.5)}),
    ("emission", 0.15, {"Emission Strength": (0.1, 3.0)}),
    ("rough", 0.1, {"Diffuse Roughness": (0.0, 1.0)}),
)
MESHES = ("cube", "uv_sphere", "ico_sphere", "cone", "cylinder", "torus", "monkey", "grid")
SIZES = dict(
    cube=dict(size=1.4),
    uv_sphere=dict(radius=0.8),
    ico_sphere=dict(radius=0.8, subdivisions=2),
    cone=dict(radius1=0.8, depth=1.5),
    cylinder=dict(radius=0.7, depth=1.4),
    torus=dict(major_radius=0.7, minor_radius=0.28),
    monkey=dict(size=1.4),
    grid=dict(size=1.8, x_subdivisions=6, y_subdivisions=6),
)


class Choices:
    """The features of the scene of this ``seed``, but for those ``without``; ``names`` has those that it got."""

    def __init__(self, seed: int, without: frozenset[str] = frozenset()):
        self.seed, self.without, self.names = seed, without, []

    def numbers(self, name: str) -> random.Random:
        """Random numbers of that name, whatever else the scene has."""
        return random.Random(f"{self.seed} {name}")

    def feature(self, name: str, probability: float) -> random.Random | None:
        """The random numbers of a feature, if the scene has it."""
        numbers = self.numbers(name)
        if numbers.random() >= probability or name in self.without:
            return None
        self.names.append(name)
        return numbers


def color(numbers: random.Random, least: float = 0.05) -> tuple[float, ...]:
    return (*(numbers.uniform(least, 0.95) for _ in "rgb"), 1.0)


def angles(numbers: random.Random) -> list[float]:
    return [numbers.uniform(-math.pi, math.pi) for _ in "xyz"]


def _image(numbers: random.Random) -> bpy.types.Image:
    has_alpha = numbers.random() < 0.4
    made = bpy.data.images.new(f"Image {numbers.random()}", 32, 16, alpha=has_alpha)
    pixels = np.random.default_rng(numbers.randrange(1 << 30)).random((16, 32, 4), np.float32)
    if not has_alpha:
        pixels[..., 3] = 1.0
    made.pixels.foreach_set(pixels.ravel())
    made.pack()
    return made


def texture(numbers: random.Random, graph: Graph, is_number: bool):
    """The output of a texture in random coordinates, between 0 and 1."""
    kind = numbers.choice(TEXTURES)
    settings = {}
    if kind == "Image":
        settings = dict(
            image=_image(numbers),
            extension=numbers.choice(("REPEAT", "EXTEND", "CLIP", "MIRROR")),
            interpolation=numbers.choice(("Linear", "Closest", "Cubic")),
            projection=numbers.choice(("FLAT", "BOX", "SPHERE", "TUBE")),
        )
    elif kind == "Voronoi":
        settings = dict(
            feature=numbers.choice(("F1", "F2", "SMOOTH_F1", "DISTANCE_TO_EDGE")),
            distance=numbers.choice(("EUCLIDEAN", "MANHATTAN", "CHEBYCHEV")),
        )
    place = graph.node("ShaderNodeTexCoord", numbers.choice(COORDINATES))
    place = graph.node(
        "ShaderNodeMapping",
        vector_type=numbers.choice(("POINT", "TEXTURE", "VECTOR", "NORMAL")),
        Vector=place,
        Rotation=angles(numbers),
        Scale=[numbers.uniform(0.3, 3.0) for _ in "xyz"],
    )
    made = graph.node(f"ShaderNodeTex{kind}", Vector=place, **settings).node
    found = next((output for output in made.outputs if output.enabled and output.type == "RGBA"), None)
    found = found or next(output for output in made.outputs if output.enabled)
    if numbers.random() < 0.5:
        ramp = graph.node("ShaderNodeValToRGB", _0=found)
        ramp.node.color_ramp.interpolation = numbers.choice(("LINEAR", "EASE", "CONSTANT", "CARDINAL", "B_SPLINE"))
        ramp.node.color_ramp.elements.new(numbers.random()).color = color(numbers)
        found = ramp
    if is_number:
        low, high = numbers.uniform(0.0, 0.4), numbers.uniform(0.5, 0.95)
        return graph.node("ShaderNodeMapRange", Value=found, To_Min=low, To_Max=high)
    return graph.node("ShaderNodeMapRange", "Vector", data_type="FLOAT_VECTOR", Vector=found)


def _principled(choices: Choices, name: str, numbers: random.Random, graph: Graph):
    made = graph.node("ShaderNodeBsdfPrincipled", distribution=numbers.choice(("GGX", "MULTI_GGX")))
    inputs = made.node.inputs
    inputs["Base Color"].default_value = color(numbers)
    inputs["Roughness"].default_value = numbers.choice((0.0, numbers.random(), numbers.random(), 1.0))
    for feature, probability, ranges in PRINCIPLED:
        own = choices.feature(f"{name} {feature}", probability)
        if own is None:
            continue
        for key, (low, high) in ranges.items():
            inputs[key].default_value = own.choice((own.uniform(low, high), own.uniform(low, high), high))
        for key in ("Coat Tint", "Sheen Tint", "Emission Color"):
            if key.split()[0].lower() == feature:
                inputs[key].default_value = color(own, 0.3)
        if feature == "subsurface":
            inputs["Subsurface Radius"].default_value = [own.uniform(0.05, 1.0) for _ in "rgb"]
            made.node.subsurface_method = own.choice(("BURLEY", "RANDOM_WALK", "RANDOM_WALK_SKIN"))
    for key, feature, probability in (("Base Color", "color texture", 0.4), ("Roughness", "roughness texture", 0.2)):
        own = choices.feature(f"{name} {feature}", probability)
        if own is not None:
            graph.feed(inputs[key], texture(own, graph, key == "Roughness"))
    own = choices.feature(f"{name} bump", 0.2)
    if own is not None:
        height = texture(own, graph, True)
        graph.feed(inputs["Normal"], graph.bump(height, own.uniform(0.02, 0.3), own.uniform(0.1, 1.0)))
    return made


def _closure(choices: Choices, name: str, numbers: random.Random, graph: Graph):
    kind = numbers.choice(("Principled",) * 8 + tuple(CLOSURES))
    if kind == "Principled":
        return _principled(choices, name, numbers, graph)
    made = graph.node(f"ShaderNode{CLOSURES[kind]}")
    for socket in made.node.inputs:
        if socket.type == "RGBA":
            socket.default_value = color(numbers)
        elif socket.type == "VALUE" and socket.name in FRACTIONS:
            socket.default_value = numbers.random()
        elif socket.type == "VALUE" and socket.name == "IOR":
            socket.default_value = numbers.uniform(1.05, 2.0)
        elif socket.name == "Scale":
            socket.default_value = numbers.uniform(0.02, 0.4)
        elif socket.name == "Strength":
            socket.default_value = numbers.uniform(0.2, 3.0)
    for key in KINDS:
        found = made.node.bl_rna.properties.get(key)
        if found is not None:
            setattr(made.node, key, numbers.choice([item.identifier for item in found.enum_items]))
    return made


def _factor(numbers: random.Random, graph: Graph):
    """What a mix of two closures depends on."""
    kind = numbers.choice(("constant", "fresnel", "facing", "ray", "side"))
    if kind == "fresnel":
        return graph.node("ShaderNodeFresnel")
    if kind == "facing":
        return graph.node("ShaderNodeLayerWeight", "Facing")
    if kind == "ray":
        return graph.node("ShaderNodeLightPath", numbers.choice(("Is Camera Ray", "Is Shadow Ray", "Is Glossy Ray")))
    return graph.node("ShaderNodeNewGeometry", "Backfacing") if kind == "side" else numbers.random()


def material(choices: Choices, name: str) -> bpy.types.Material:
    numbers, graph = choices.numbers(name), Graph(name)
    found = _closure(choices, f"{name} first", numbers, graph)
    own = choices.feature(f"{name} mix", 0.3)
    if own is not None:
        other = _closure(choices, f"{name} second", own, graph)
        if own.random() < 0.2:
            found = graph.node("ShaderNodeAddShader", _0=found, _1=other)
        else:
            found = graph.node("ShaderNodeMixShader", _0=_factor(own, graph), _1=found, _2=other)
    made = graph.finish(found)
    own = choices.feature(f"{name} volume", 0.06)
    if own is not None:
        kind = own.choice(("Scatter", "Absorption", "Principled"))
        volume = graph.node(f"ShaderNodeVolume{kind}", Color=color(own, 0.2), Density=own.uniform(0.2, 2.0))
        graph.links.new(volume, found.links[0].to_node.inputs["Volume"])
    return made


def _thing(choices: Choices, name: str) -> None:
    numbers = choices.numbers(name)
    kind = numbers.choice(MESHES)
    getattr(bpy.ops.mesh, f"primitive_{kind}_add")(**SIZES[kind])
    made = bpy.context.object
    made.location = numbers.uniform(-2.0, 2.0), numbers.uniform(-1.5, 2.0), numbers.uniform(0.4, 2.2)
    made.rotation_euler, made.scale = angles(numbers), (numbers.uniform(0.6, 1.3),) * 3
    own = choices.feature(f"{name} stretched", 0.25)
    if own is not None:
        made.scale = [own.uniform(0.4, 1.4) for _ in "xyz"]
    own = choices.feature(f"{name} mirrored", 0.12)
    if own is not None:
        made.scale[own.randrange(3)] *= -1.0
    if choices.feature(f"{name} smooth", 0.5) is not None:
        made.data.shade_smooth()
    if choices.feature(f"{name} subdivided", 0.15) is not None:
        modifier = made.modifiers.new("Subdivision", "SUBSURF")
        modifier.levels = modifier.render_levels = 1
    if choices.feature(f"{name} repeated", 0.08) is not None:
        made.modifiers.new("Array", "ARRAY").count = 2
    own = choices.feature(f"{name} hidden from some rays", 0.12)
    if own is not None:
        kinds = ("camera", "diffuse", "glossy", "transmission", "shadow")
        setattr(made, f"visible_{own.choice(kinds)}", False)
    made.is_holdout = choices.feature(f"{name} holdout", 0.03) is not None
    made.data.materials.append(material(choices, f"{name} material"))


def _light(choices: Choices, name: str) -> None:
    numbers = choices.numbers(name)
    kind = numbers.choice(("POINT", "SPOT", "SUN", "AREA", "AREA"))
    data = bpy.data.lights.new(name, kind)
    made = bpy.data.objects.new(name, data)
    bpy.context.scene.collection.objects.link(made)
    made.location = numbers.uniform(-3.0, 3.0), numbers.uniform(-4.0, 2.0), numbers.uniform(2.5, 5.0)
    target = Vector((numbers.uniform(-1.0, 1.0), numbers.uniform(-1.0, 1.0), 1.0))
    made.rotation_euler = (target - made.location).to_track_quat("-Z", "Y").to_euler()
    data.color = color(numbers, 0.3)[:3]
    data.energy = numbers.uniform(1.0, 4.0) if kind == "SUN" else numbers.uniform(100.0, 600.0)
    if kind in ("POINT", "SPOT"):
        data.shadow_soft_size, data.use_soft_falloff = numbers.choice((0.0, 0.1, 0.6)), numbers.random() < 0.5
    if kind == "SPOT":
        data.spot_size, data.spot_blend = numbers.uniform(0.4, 2.6), numbers.random()
    if kind == "SUN":
        data.angle = numbers.choice((0.0, 0.05, 0.5))
    if kind == "AREA":
        data.shape = numbers.choice(("SQUARE", "RECTANGLE", "DISK", "ELLIPSE"))
        data.size, data.size_y = numbers.uniform(0.2, 2.0), numbers.uniform(0.2, 2.0)
        data.spread = numbers.choice((math.pi, math.pi, numbers.uniform(0.3, 3.0)))
    data.use_shadow = choices.feature(f"{name} without shadow", 0.05) is None
    own = choices.feature(f"{name} of few bounces", 0.1)
    if own is not None:
        data.cycles.max_bounces = own.randint(0, 2)
    own = choices.feature(f"{name} hidden from some rays", 0.12)
    if own is not None:
        setattr(made, f"visible_{own.choice(('camera', 'diffuse', 'glossy', 'transmission'))}", False)
    own = choices.feature(f"{name} stretched", 0.15)
    if own is not None:
        made.scale = [own.uniform(0.5, 2.0) for _ in "xyz"]
    own = choices.feature(f"{name} nodes", 0.12)
    if own is not None:
        graph = Graph(data)
        emission = graph.node("ShaderNodeEmission")
        if own.random() < 0.5:
            falloff = own.choice(("Quadratic", "Linear", "Constant"))
            graph.feed(emission.node.inputs["Strength"], graph.node("ShaderNodeLightFalloff", falloff, Strength=1.0))
        else:
            graph.feed(emission.node.inputs["Color"], texture(own, graph, False))
        graph.finish(emission)
    own = choices.feature(f"{name} linked", 0.1)
    if own is not None:
        members = bpy.data.collections.new(name)
        for each in [obj for obj in bpy.context.scene.objects if obj.type == "MESH"][: own.randint(1, 4)]:
            members.objects.link(each)
        setattr(made.light_linking, own.choice(("receiver_collection", "blocker_collection")), members)


def _world(choices: Choices, scene: bpy.types.Scene) -> None:
    numbers = choices.numbers("world")
    scene.world = bpy.data.worlds.new("World")
    use_nodes(scene.world)
    graph = Graph(scene.world)
    background = graph.node("ShaderNodeBackground", Color=color(numbers), Strength=numbers.choice((0.0, 0.2, 0.5, 1.0)))
    own = choices.feature("world texture", 0.2)
    if own is not None:
        graph.feed(background.node.inputs["Color"], texture(own, graph, False))
    graph.finish(background)
    own = choices.feature("fog", 0.05)
    if own is not None:
        fog = graph.node("ShaderNodeVolumeScatter", Density=own.uniform(0.01, 0.1))
        output = next(node for node in node_tree_of(scene.world).nodes if node.type == "OUTPUT_WORLD")
        graph.links.new(fog, output.inputs["Volume"])


def _camera(choices: Choices, scene: bpy.types.Scene) -> None:
    numbers = choices.numbers("camera")
    data = bpy.data.cameras.new("Camera")
    made = scene.camera = bpy.data.objects.new("Camera", data)
    scene.collection.objects.link(made)
    made.location = numbers.uniform(-3.0, 3.0), numbers.uniform(-8.0, -5.0), numbers.uniform(1.5, 5.0)
    made.rotation_euler = (Vector((0.0, 0.3, 1.0)) - made.location).to_track_quat("-Z", "Y").to_euler()
    data.lens = numbers.uniform(25.0, 50.0)
    own = choices.feature("camera shifted", 0.2)
    if own is not None:
        data.shift_x, data.shift_y = own.uniform(-0.2, 0.2), own.uniform(-0.2, 0.2)
    own = choices.feature("depth of field", 0.2)
    if own is not None:
        data.dof.use_dof, data.dof.focus_distance = True, own.uniform(4.0, 9.0)
        data.dof.aperture_fstop, data.dof.aperture_blades = own.uniform(0.1, 1.0), own.choice((0, 5, 6))
    own = choices.feature("orthographic", 0.1)
    if own is not None:
        data.type, data.ortho_scale = "ORTHO", own.uniform(4.0, 9.0)
    scene.render.film_transparent = choices.feature("transparent film", 0.15) is not None


def _limits(choices: Choices, scene: bpy.types.Scene) -> None:
    own = choices.feature("limits of bounces", 0.5)
    found = dict(max_bounces=8, diffuse_bounces=8, glossy_bounces=8, transmission_bounces=8, volume_bounces=8)
    if own is not None:
        found = {name: own.randint(0, 8) for name in found}
    for name, value in found.items():
        setattr(scene.cycles, name, value)
        setattr(scene.sdf_lights, name, value)
    blurs = choices.feature("filter glossy", 0.3) is not None
    scene.cycles.blur_glossy = scene.sdf_lights.filter_glossy = float(blurs)
    for name in ("caustics_reflective", "caustics_refractive"):
        wanted = choices.feature(f"no {name}", 0.1) is None
        setattr(scene.cycles, name, wanted)
        setattr(scene.sdf_lights, name, wanted)


def build(seed: int, size: int, samples: int, device: str, without: frozenset[str] = frozenset()) -> Choices:
    """Open a new file with the scene of this ``seed``, a square picture, for both engines."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    host.register_extension()
    simple_scenes.enable_cycles()
    scene, choices = bpy.context.scene, Choices(seed, without)
    scene.render.resolution_x = scene.render.resolution_y = size
    scene.render.resolution_percentage = 100
    bpy.ops.mesh.primitive_plane_add(size=9.0)
    bpy.context.object.data.materials.append(material(choices, "floor"))
    if choices.feature("wall", 0.5) is not None:
        bpy.ops.mesh.primitive_plane_add(size=9.0, location=(0.0, 3.5, 3.0), rotation=(0.5 * math.pi, 0.0, 0.0))
        bpy.context.object.data.materials.append(material(choices, "wall's material"))
    for place in range(choices.numbers("things").randint(2, 6)):
        if choices.feature(f"thing {place}", 1.0) is not None:
            _thing(choices, f"thing {place}")
    for place in range(choices.numbers("lights").choice((1, 1, 2, 3))):
        if choices.feature(f"light {place}", 1.0) is not None:
            _light(choices, f"light {place}")
    _world(choices, scene)
    _camera(choices, scene)
    simple_scenes.plain_cycles(scene, samples, 8)
    simple_scenes.plain_sdf_lights(scene, samples, 8, device)
    _limits(choices, scene)
    scene.render.engine = OURS
    return choices
