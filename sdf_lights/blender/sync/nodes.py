# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's shader nodes as ``render.material``: closures as its nodes, values as formulas.

``_TABLE`` maps closures and sockets to closures and inputs. Value nodes are defined in ``render.nodes``, which see a
node through ``_Inputs``. Groups, reroutes and muted nodes are resolved. README.md one folder up lists the replacements
of unsupported nodes.
"""

from __future__ import annotations

import pathlib
from collections.abc import Callable
from typing import NamedTuple

import bpy
import mathutils
import numpy as np

from ...graph.folding import Folding
from ...graph.formula import CONSTANT, Formula, Vector, call, constant, parameter
from ...render import bsdfs
from ...render.images import Texture
from ...render.material import NODES, Attribute, Material, Node, Table
from ...render.nodes import DEFINITIONS
from ...render.nodes.colors import luminance_weights
from ...render.nodes.definition import mean
from ...render.nodes.geometry import generated, strand_random, to_object, transformed_normal, uv
from ...render.nodes.lookups import ATTRIBUTE
from ...render.nodes.variables import BARYCENTRIC, INCOMING, NORMAL, POSITION, as_vector
from . import zones
from .attributes import property_of
from .common import Warnings, matrix_of, rgb
from .images import Images
from .links import INLINED, NOWHERE, Links
from .zones import Stack, by_identifier


def _incoming(node) -> Vector:
    """The direction to the viewer, in the space of the object or the light."""
    turn = node.setting("light_normals")
    return to_object(INCOMING, "NORMAL") if turn is None else transformed_normal(node, turn, INCOMING)


# The value of an unlinked Vector socket of these textures; for all others, Generated coordinates.
_IMPLICIT = {"ShaderNodeTexImage": uv, "ShaderNodeTexEnvironment": lambda node: POSITION, "ShaderNodeTexIES": _incoming}
# For these nodes it is zero, although they hide its value like textures.
_NO_COORDINATES = {"ShaderNodeMapRange", "ShaderNodeVectorRotate", "ShaderNodeTexWhiteNoise"}

_TEXTURES = "Brick", "Checker", "Gabor", "Gradient", "Magic", "Noise", "Voronoi", "Wave"
_FOLDED = {f"ShaderNodeTex{name}" for name in _TEXTURES}  # nodes that Blender computes if all inputs are constants

BLACK = (0.0, 0.0, 0.0)


class _Missing:
    """Result of an unsupported node: the socket that it is linked to uses its own value."""


MISSING = _Missing()

_ONLY_EEVEE = "(only EEVEE has it: a path tracer cannot read a shader's result as a colour)"


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


_PRINCIPLED = {name: name.replace("_", " ").title() for name in NODES["principled"]} | {
    "ior": "IOR",
    "specular_ior_level": "Specular IOR Level",
    "coat_ior": "Coat IOR",
    "thin_film_ior": "Thin Film IOR",
    "subsurface_ior": "Subsurface IOR",
}
_ROUGH = dict(roughness="Roughness", normal="Normal", anisotropy="Anisotropy", rotation="Rotation", tangent="Tangent")
_FILM = dict(thin_film_thickness="Thin Film Thickness", thin_film_ior="Thin Film IOR")

_TABLE = {
    "ShaderNodeBsdfPrincipled": _Entry(
        "principled", _PRINCIPLED, lambda node: _distribution(node) | _subsurface(node.subsurface_method)
    ),
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
for _bsdf in bsdfs.ALL:
    _TABLE[_bsdf.blender] = _Entry(
        _bsdf.kind,
        {name: _bsdf.socket(name) for name in _bsdf.inputs},
        lambda node, names=_bsdf.settings: {name: getattr(node, name).upper() for name in names},
    )
_TABLE["ShaderNodeBsdfGlossy"] = _TABLE["ShaderNodeBsdfAnisotropic"]


MOST_INPUTS = 20_000  # of a tree with all groups written out: a malicious file may double them at each level
MOST_IES_BYTES = 16 << 20  # of an IES text; reading a device would never end


class Reader:
    """Reads one node tree. ``owner`` names it in warnings: "Material 'Wood'". Time, view layer and world come from
    ``depsgraph``, because a window may show a different scene than the rendered one.

    ``parameters`` are the values of the slots of all formulas read so far. ``domain`` is "SURFACE", "WORLD" (where the
    position is the direction of the ray) or "LIGHT". ``light`` has data for nodes of lights: "light_matrix" (3, 4) maps
    from the world to the light, without its scale; "light_normals" (3, 3) does so for normals, with the scale, as in
    Cycles; "light_shape": see ``projections.light_place``; "object_info": the result of ``lookups.OBJECT_INFO``;
    "owners": the data whose properties are its attributes.
    """

    def __init__(
        self,
        tree: bpy.types.NodeTree,
        owner: str,
        depsgraph: bpy.types.Depsgraph,
        images: Images | None,
        warn: Warnings,
        domain: str = "SURFACE",
        material_index: int = 0,
        light: dict[str, object] | None = None,
    ):
        self.tree, self._owner, self.images, self._warn = tree, owner, images, warn
        self.scene, self._view_layer = depsgraph.scene_eval, depsgraph.view_layer_eval
        self.domain, self.material_index = domain, material_index
        self.light = light or {}
        self.parameters: list[float | Attribute | Table | Texture] = []
        self._followed, self._reading = 0, False  # number of inputs read; whether one is being read
        self.links = Links()
        self._values: dict[tuple, object] = {}
        self._constants: dict[tuple, Formula | Vector] = {}

    # -- walking -------------------------------------------------------------------------------------------------------

    def output(self) -> bpy.types.Node | None:
        """The active output node: Blender's choice for engines that read Cycles' nodes. Warns with the reason if there
        is none."""
        if self.links.circular(self.tree):
            self._warn(f"{self._owner}: its links form a circle, so it is black: remove one of them.")
            return None
        found = self.tree.get_output_node("CYCLES")
        if found is None and self.domain == "SURFACE":
            self._warn(
                f"{self._owner} has no Material Output node, so it is black: add one and link a shader to its Surface."
            )
        return found

    def resolve(self, socket, stack: Stack = ()):
        """The source of an input socket, through groups, reroutes and muted nodes.

        Returns (node, output socket, stack), or (None, input socket, stack) with the socket whose own value is used, or
        ``NOWHERE``.
        """
        return self._walk(socket, stack)[:3]

    def _walk(self, socket, stack: Stack):
        """As ``resolve``, with the types of the sockets on the way, from the input on, and whether they convert only
        constants: if Blender resolves groups, varying values pass such sockets unchanged."""
        receiver, passing = socket, False  # whether reroutes or muted nodes came since the receiver
        types: list[tuple[str, bool]] = []  # whether it converts only constants
        known = 0  # number of types up to the receiver
        self._followed += 1
        if self._followed > MOST_INPUTS:
            if self._followed == MOST_INPUTS + 1:
                self._warn(
                    f"{self._owner}: its groups are nested so often that it has more than {MOST_INPUTS:,} inputs, so "
                    "parts of it are left out: nest fewer groups."
                )
            return None, receiver, stack, types
        while True:
            link = self.links.into(socket)
            if link is None:
                found = NOWHERE if passing and not INLINED else receiver
                return None, found, stack, types[:known]
            if len(stack) > zones.DEEPEST:
                self.report(link.from_node, "its groups or zones are nested too deeply, so it is left out")
                return None, receiver, stack, types[:known]
            node, output = link.from_node, link.from_socket
            if node.bl_idname == "NodeReroute":
                socket, passing = node.inputs[0], True
                continue
            if node.mute:
                socket = next((inner.from_socket for inner in node.internal_links if inner.to_socket == output), None)
                if socket is None:
                    return None, receiver, stack, types[:known]
                types += [(output.type, INLINED), (socket.type if INLINED else output.type, INLINED)]
                passing = True
                continue
            if node.bl_idname in zones.PASSES:
                found = zones.PASSES[node.bl_idname](self, node, output, stack)
                if found is None:
                    return node, output, stack, types
                socket, stack = found
            else:
                return node, output, stack, types
            if socket is None:
                return None, receiver, stack, types[:known]
            if socket is NOWHERE:
                return None, NOWHERE, stack, types
            kept = INLINED and node.bl_idname != zones.CONVERSION
            types += [(output.type, kept), (socket.type, kept)]
            receiver, passing, known = socket, False, len(types)

    # -- reading -------------------------------------------------------------------------------------------------------

    def read(self, socket, like, stack: Stack = ()):
        """Value of an input of a closure: a formula, a vector or a ``Node``, for an input with the default ``like``.

        None if ``like`` is None and nothing is linked: the input then has its default. A value at a shader input
        becomes an emission of that value.
        """
        outermost, self._reading = not self._reading, True
        try:
            value = self._read(socket, like, stack)
        except RecursionError:
            if not outermost:
                raise
            self._warn(
                f"{self._owner}: its chains of nodes are too long, so it is left out: join some of the nodes into one."
            )
            return None
        finally:
            self._reading = self._reading and not outermost
        if socket.type == "SHADER" and isinstance(value, (Formula, Vector)):
            return Node("emission", {"color": _converted(value, "VECTOR", BLACK)})
        return value

    def _read(self, socket, like, stack: Stack):
        node, end, inner, types = self._walk(socket, stack)
        if node is not None:
            value = self._value(node, end, inner)
            if value is not MISSING:
                return _converted(*self._carried(value, end.type, types), like)
            end, types = socket, []
        if like is None and not _replaces(end, socket):
            return None
        value = self._constant(end, inner)
        return None if value is None else _converted(*self._carried(value, end.type, types), like)

    def _carried(self, value, socket_type: str, types: list[tuple[str, bool]]):
        """Convert a value through sockets of these ``types``, the last one first. Returns it with its final type."""
        if isinstance(value, (Formula, Vector)):
            for passed, of_constants in reversed(types):
                if passed in _LIKE and passed != socket_type:
                    if not of_constants or numbers_of(self, value) is not None:
                        value, socket_type = _converted(value, socket_type, _LIKE[passed]), passed
        return value, socket_type

    def number_of(self, socket, stack: Stack) -> float | None:
        """The number at an input; None if it varies."""
        value, kind = self.value(socket, stack)
        return None if value is None else numbers_of(self, _converted(value, kind, 0.0))

    def value(self, socket, stack: Stack) -> tuple[Formula | Vector | None, str]:
        """The value of an input of a value node, and the type of the last socket on its way; None if it is not a
        value."""
        node, end, inner, types = self._walk(socket, stack)
        if node is not None:
            value = self._value(node, end, inner)
            if value is not MISSING and isinstance(value, (Formula, Vector)):
                return self._carried(value, end.type, types)
            end, types = socket, []
        return self._carried(self._constant(end, inner), end.type, types)

    def _constant(self, socket, stack: Stack) -> Formula | Vector | None:
        """A socket's own value, as parameters."""
        key = socket.as_pointer(), zones.key_of(stack)
        if key not in self._constants:
            self._constants[key] = self.parametric(constant_of(socket))
        return self._constants[key]

    def parametric(self, value) -> Formula | Vector | None:
        """A number, a triple or a position, as parameters."""
        if value is None:
            return None
        if isinstance(value, tuple):
            return Vector(*map(self.parametric, value))
        if isinstance(value, float) and value != value:
            self._warn(f"{self._owner}: a value of a node is not a finite number: 0 is used; set it again.")
            value = 0.0
        self.parameters.append(value)
        return parameter(len(self.parameters) - 1)

    def _value(self, node, output, stack: Stack):
        """The value of a node's output. All outputs of a node are computed at once, unless it is a closure."""
        groups = zones.key_of(stack)
        key = (node.as_pointer(), output.identifier, groups)
        if key not in self._values:
            definition = DEFINITIONS.get(node.bl_idname)
            number = zones.constant_of(node, output, stack)
            if number is not None:
                self._values[key] = self.parametric(number)
            elif definition is None:
                self._values[key] = self._closure(node, output, stack)
            else:
                inputs = _Inputs(self, node, stack, output)
                for identifier, value in definition(inputs).items():
                    self._values[node.as_pointer(), identifier, groups] = value
                self._values.setdefault(key, MISSING)
        return self._values[key]

    def _closure(self, node, output, stack: Stack):
        entry = _TABLE.get(node.bl_idname)
        if entry is None:
            return self._unsupported(node, output, stack)
        inputs = {}
        for name, identifier in entry.inputs.items():
            socket = by_identifier(node.inputs, identifier)
            value = None if socket is None else self.read(socket, NODES[entry.kind][name], stack)
            if value is not None:
                inputs[name] = value
        if entry.kind == "principled_hair" and self._varies(node, stack):
            place = self.parametric(Attribute("strand", "random"))
            inputs["random"] = strand_random(place, inputs["random"])
        if entry.kind == "principled_hair" and node.model == "HUANG":
            place = self.parametric(Attribute("strand", "normal"))
            inputs["axis"] = as_vector(call(ATTRIBUTE, place, *BARYCENTRIC))
        return Node(entry.kind, inputs, entry.settings(node))

    def _varies(self, node, stack: Stack) -> bool:
        """Whether Principled Hair varies from strand to strand by its random inputs."""
        sockets = {socket.identifier: socket for socket in node.inputs}
        if self.resolve(sockets["Random"], stack)[0] is not None:
            return False
        amounts = [sockets[name] for name in ("Random Roughness", "Random Color")]
        return any(self.resolve(each, stack)[0] is not None or each.default_value != 0.0 for each in amounts)

    def _unsupported(self, node, output, stack: Stack):
        if output.type != "SHADER":
            return self._passed_on(node, output, stack)
        socket = next((socket for socket in node.inputs if socket.name in {"Color", "Base Color"}), None)
        if socket is None:
            self.report(node, "not supported, so it is black")
            return None
        self.report(node, "not supported, so it is a Diffuse BSDF of the same colour")
        return Node("diffuse", {"color": self.read(socket, BLACK, stack)})

    def _passed_on(self, node, output, stack: Stack):
        """The first input of the same kind, which a muted node passes on."""
        socket = next((socket for socket in node.inputs if socket.enabled and socket.type == output.type), None)
        value = None if socket is None else self.value(socket, stack)[0]
        if value is None:
            why = _ONLY_EEVEE if node.bl_idname == "ShaderNodeShaderToRGB" else ""
            self.report(node, f"not supported{why}, so the socket it is linked to uses its own value")
            return MISSING
        self.report(node, f"not supported, so its input {socket.name} is passed on, as if it was muted")
        return value

    def attribute_value(self, node) -> list[float] | None:
        """Components of the property named by an Attribute node, for a light or the view layer; None if there is
        none."""
        owners = self.light.get("owners", ())
        if node.attribute_type == "VIEW_LAYER":
            owners = self._view_layer, self.scene, self.scene.world
        elif node.attribute_type == "GEOMETRY":
            owners = ()
        found = next(
            (found for found in (property_of(owner, node.attribute_name) for owner in owners) if found is not None),
            None,
        )
        return None if found is None else found[0].tolist()

    def report(self, node, what: str) -> None:
        """Warn about a node, with the name that the node editor shows."""
        kind = node.bl_rna.name
        name = f"'{node.name}'" if node.name == kind else f"'{node.name}' ({kind})"
        self._warn(f"{self._owner}: node {name}: {what}.")


class _Inputs:
    """A value node as its definition sees it: ``render.nodes.NodeInputs``."""

    def __init__(self, reader: Reader, node, stack: Stack, output):
        self._reader, self._node, self._stack = reader, node, stack
        self.wanted = {socket.identifier for socket in node.outputs if socket.is_linked} | {output.identifier}

    def _socket(self, identifier: str):
        return by_identifier(self._node.inputs, identifier)

    def _read(self, identifier: str) -> tuple[Formula | Vector, str]:
        socket = self._socket(identifier)
        value, kind = (None, "VALUE") if socket is None else self._reader.value(socket, self._stack)
        return (constant(0.0), "VALUE") if value is None else (value, kind)

    def number(self, socket: str) -> Formula:
        return _converted(*self._read(socket), 0.0)

    def vector(self, socket: str) -> Vector:
        if (
            socket == "Vector"
            and not self.is_given(socket)
            and self._socket(socket) is not None
            and self._socket(socket).hide_value
            and self._node.bl_idname not in _NO_COORDINATES
        ):
            found = self.coordinates()
        else:
            found = _converted(*self._read(socket), BLACK)
        return self._mapped(found) if socket == "Vector" else found

    color = vector

    def normal(self, socket: str) -> Vector:
        return self.vector(socket) if self.is_given(socket) else NORMAL

    def coordinates(self) -> Vector:
        """The value of an unlinked Vector input of a texture."""
        if self._reader.domain == "WORLD":
            return POSITION
        return _IMPLICIT.get(self._node.bl_idname, generated)(self)

    def _mapped(self, vector: Vector) -> Vector:
        """A vector after the texture mapping that some nodes contain."""
        mapping = getattr(self._node, "texture_mapping", None)
        if mapping is None:
            return vector
        matrix = texture_matrix(mapping)
        if matrix is None:
            return vector
        rows = [[self.parameter(float(entry)) for entry in row] for row in matrix]
        return Vector(*(row[0] * vector.x + row[1] * vector.y + row[2] * vector.z + row[3] for row in rows))

    def has(self, socket: str) -> bool:
        return self._socket(socket) is not None

    def is_linked(self, socket: str) -> bool:
        found = self._socket(socket)
        return found is not None and self._reader.resolve(found, self._stack)[0] is not None

    def is_given(self, socket: str) -> bool:
        found = self._socket(socket)
        if found is None:
            return False
        node, end, _ = self._reader.resolve(found, self._stack)
        return node is not None or _replaces(end, found) or self._is_folded(end, found)

    def _is_folded(self, end, receiver) -> bool:
        """Whether Blender computes the node itself, like a texture of constants, and so uses even a hidden value of a
        group's input."""
        if not INLINED or end in (receiver, NOWHERE) or self._node.bl_idname not in _FOLDED:
            return False
        others = [socket for socket in self._node.inputs if socket.enabled and socket.identifier != receiver.identifier]
        values = [self._reader.value(socket, self._stack)[0] for socket in others]
        return not any(isinstance(each, Formula | Vector) and numbers_of(self._reader, each) is None for each in values)

    def own(self, output: str) -> Formula | Vector:
        return self._reader.parametric(constant_of(by_identifier(self._node.outputs, output)))

    def setting(self, name: str):
        if name == "working_space":
            return working_space()
        if name == "scene_time":
            scene = self._reader.scene
            frame = scene.frame_current_final
            return frame * scene.render.fps_base / scene.render.fps, frame
        if name == "object_matrix":
            other = self._node.object
            return None if other is None else matrix_of(other.matrix_world.inverted_safe())[:3]
        if name == "occlusion_distance":
            world = self._reader.scene.world
            return 10.0 if world is None else world.light_settings.distance
        if name == "material_index":
            return self._reader.material_index
        if name == "domain":
            return self._reader.domain
        if name in ("light_matrix", "light_normals", "light_shape", "object_info"):
            return self._reader.light.get(name)
        if name == "attribute_value":
            return self._reader.attribute_value(self._node)
        if name == "blender_version":
            return bpy.app.version[:2]
        if name == "ies_text":
            return ies_text(self._node)
        return getattr(self._node, name, None)

    def parameter(self, value: float | Attribute) -> Formula:
        return self._reader.parametric(value)

    def table(self, values: np.ndarray) -> Formula:
        return self._reader.parametric(Table(np.asarray(values, np.float64)))

    def image(self, straight: bool = False, tiled: bool = True) -> Formula:
        node = self._node
        # Textures of the world repeat.
        extension = getattr(node, "extension", "REPEAT")
        return self._reader.parametric(
            self._reader.images.texture(
                node.image,
                node.image_user,
                interpolation=node.interpolation,
                extension=extension,
                alpha=straight,
                tiled=tiled,
            )
        )

    def report(self, sentence: str) -> None:
        self._reader.report(self._node, sentence)


def _replaces(end, receiver) -> bool:
    """Whether the socket value at the end of a walk replaces the default coordinates or normal of an unlinked input: it
    does if it is the visible value of a group's input."""
    return INLINED and end is not receiver and not end.hide_value


def ies_text(node) -> str:
    """The IES file of a node, from a text or from disk; empty if there is none."""
    if node.mode == "INTERNAL":
        text = "" if node.ies is None else node.ies.as_string()
        return text if len(text) <= MOST_IES_BYTES else ""
    path = pathlib.Path(bpy.path.abspath(node.filepath, library=node.id_data.library))
    try:
        if not path.is_file() or path.stat().st_size > MOST_IES_BYTES:
            return ""
        return path.read_text(encoding="latin-1")
    except (OSError, ValueError):
        return ""


_AXES = {"NONE": None, "X": 0, "Y": 1, "Z": 2}


def texture_matrix(mapping) -> np.ndarray | None:
    """(3, 4) matrix of a texture node's own mapping; None if it is the identity."""
    axes = [_AXES[getattr(mapping, f"mapping_{axis}")] for axis in "xyz"]
    location, rotation, size = (tuple(getattr(mapping, name)) for name in ("translation", "rotation", "scale"))
    if axes == [0, 1, 2] and not any(location) and not any(rotation) and size == (1.0, 1.0, 1.0):
        return None
    swizzle = np.zeros((3, 3))
    for row, column in enumerate(axes):
        if column is not None:
            swizzle[row, column] = 1.0
    turn = np.array(mathutils.Euler(rotation, "XYZ").to_matrix(), np.float64)
    kind = mapping.vector_type
    inverse = np.divide(1.0, size, out=np.zeros(3), where=np.array(size) != 0.0)
    if kind == "TEXTURE":
        linear = np.diag(inverse) @ turn.T
        return np.column_stack([linear @ swizzle, -linear @ np.array(location)])
    linear = turn @ np.diag(inverse if kind == "NORMAL" else size)
    return np.column_stack([linear @ swizzle, location if kind == "POINT" else np.zeros(3)])


def working_space() -> str | None:
    """Name of the linear colour space of the file, which users can choose since Blender 5.0."""
    return getattr(getattr(bpy.data, "colorspace", None), "working_space", None)


def constant_of(socket):
    """A socket's own value: a float, a 3-tuple, or None for a shader."""
    value = getattr(socket, "default_value", None)
    if value is None or isinstance(value, (str, bpy.types.ID)):
        return None
    return rgb(value) if hasattr(value, "__len__") else float(value)


_LIKE = {"VALUE": 0.0, "VECTOR": BLACK, "RGBA": BLACK}  # type of a socket -> an example of its values


def _converted(value, socket_type: str, like):
    """A value converted between sockets as in Blender: colours to numbers by luminance, vectors by mean."""
    if isinstance(value, Vector) and isinstance(like, float):
        if socket_type == "RGBA":
            return value.dot(luminance_weights(working_space()))
        return mean(value)
    if isinstance(value, Formula) and isinstance(like, tuple):
        return Vector(value, value, value)
    return value


def numbers_of(reader: Reader, value):
    """A value of formulas as a float or a 3-tuple; None if it varies."""
    if value is None or isinstance(value, Node):
        return None
    if isinstance(value, (float, tuple)) and not isinstance(value, Vector):
        return value
    folding = Folding([entry if isinstance(entry, float) else 0.0 for entry in reader.parameters])
    folded = [folding.fold(formula) for formula in (value if isinstance(value, Vector) else (value,))]
    if any(formula.kind != CONSTANT for formula in folded):
        return None
    return tuple(formula.value for formula in folded) if len(folded) == 3 else folded[0].value


def emission_of(reader: Reader, name: str) -> tuple[np.ndarray, Material | None]:
    """The emission of the node tree of a light or a world: RGB if it is constant, else white and the nodes."""
    output = reader.output()
    surface = None if output is None else reader.read(output.inputs["Surface"], None)
    if surface is None:
        return np.zeros(3), None
    if isinstance(surface, Node) and surface.kind == "emission":
        color, strength = (numbers_of(reader, surface[name]) for name in ("color", "strength"))
        if color is not None and strength is not None:
            return np.array(color) * strength, None
    return np.ones(3), Material(name, surface, parameters=reader.parameters)
