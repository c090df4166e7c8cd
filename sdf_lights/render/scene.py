# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The scene for every back end: plain dataclasses and NumPy arrays, copied once out of Blender.

Units: metres, watts, radians, scene-linear RGB. Matrices are 4 × 4, float64, column vectors (world = matrix @ local).
Images and pixel coordinates have row 0 at the bottom, like Blender's render result.
"""

from __future__ import annotations

import enum
from dataclasses import dataclass, field, replace

import numpy as np

from ..sdf.emission import Emission
from ..sdf.shapes import Shape
from .images import Image
from .material import Attribute, Material, attributes_of
from .medium import Medium
from .passes import Pass
from .settings import Settings

RGB = tuple[float, float, float]

_ROUNDING = 1e-6  # of Blender's single precision


class Ray(enum.IntFlag):
    """Kinds of rays, to which an object can be visible (Blender's Ray Visibility)."""

    CAMERA = 1
    DIFFUSE = 2
    GLOSSY = 4
    TRANSMISSION = 8
    SHADOW = 16
    VOLUME = 32  # scattered in a medium
    ALL = 63


class Domain(enum.IntEnum):
    """The elements to which the rows of an attribute belong."""

    CORNER = 0  # three rows a triangle
    VERTEX = 1
    TRIANGLE = 2
    WHOLE = 3  # one row; of a grid of voxels it has any number of values


@dataclass
class AttributeValues:
    """An attribute of a mesh or an instance: ``values`` (rows, 1 to 4) float32."""

    domain: Domain
    values: np.ndarray


class Primitive(enum.IntEnum):
    """The meaning of the rows of ``Mesh.triangles``."""

    TRIANGLES = 0
    RIBBONS = 1  # segments of Catmull-Rom curves; their flat side faces every ray, and they are shaded as if round
    STRANDS = 2  # the same, round
    CONES = 3  # round segments of straight lines
    SPHERES = 4


@dataclass
class Mesh:
    """Triangles in local space. Corner arrays hold three values a triangle, in the order of its vertices.

    For curves a row is a segment (a, a + 1, a). Its barycentric coordinates are the position along it, and the position
    across it, from −1 to 1. The vertices of a curve follow each other. For spheres a row is (a, a, a). Both have no
    corners, and attributes instead of UV maps.
    """

    name: str
    positions: np.ndarray  # (V, 3) float32
    triangles: np.ndarray  # (T, 3) int32, counter-clockwise from outside
    normals: np.ndarray | None = None  # (T, 3, 3) float32 unit corner normals; None: flat everywhere
    uvs: dict[str, np.ndarray] = field(default_factory=dict)  # name -> (T, 3, 2) float32; "" is the active map
    tangents: dict[str, np.ndarray] = field(default_factory=dict)  # name -> (T, 3, 4) float32, w = sign of bitangent
    slots: np.ndarray | None = None  # (T,) int32 material slot; None: all in slot 0
    # all other attributes that materials look up
    attributes: dict[Attribute, AttributeValues] = field(default_factory=dict)
    motion: np.ndarray | None = None  # (K, V, 3) float32 positions at even times of the shutter; None: no deformation
    shifts: np.ndarray | None = (
        None  # (2, V, 3) float32 offsets to the positions at the previous and the next frame; None: no deformation
    )
    motion_normals: np.ndarray | None = None  # (K, T, 3, 3) float32, if there are ``normals``
    primitive: Primitive = Primitive.TRIANGLES
    radii: np.ndarray | None = None  # (V,) float32 of curves and spheres
    motion_radii: np.ndarray | None = None  # (K, V) float32, if they have ``motion``
    subdivisions: int = 2  # of ribbons: each segment has 2 to this power flat pieces


ALL_SETS = -1  # bits of all sets of instances
OPEN_SET = 0  # the set of objects in no collection of light or shadow linking, and of the medium of the world
MANY_BOUNCES = 1024


@dataclass(kw_only=True)
class Emitter:
    """Light control. If emission lights all objects and all cast its shadows, as without light linking, both masks are
    all ones.

    ``receivers``: bits of the sets ``Instance.light_set`` that it lights. ``blockers``: bits of the sets
    ``Instance.shadow_set`` that cast its shadows. ``max_bounces``: it lights no surface after more bounces.
    ``light_group``: the pass of light that contains it. ``sampled_only``: only camera rays hit it by chance.
    ``lights_catchers``: a lamp or light counts for shadow catchers.
    """

    receivers: int = ALL_SETS
    blockers: int = ALL_SETS
    max_bounces: int = MANY_BOUNCES
    sampled_only: bool = False
    light_group: str = ""
    own_pass: str = ""  # name of a separate pass of its light
    lights_catchers: bool = True


@dataclass
class Instance(Emitter):
    """One mesh placed in the world."""

    mesh: int
    matrix: np.ndarray
    materials: tuple[int, ...]  # material of each slot, at least one
    name: str = ""
    visibility: Ray = Ray.ALL
    holdout: bool = False
    attributes: dict[Attribute, AttributeValues] = field(default_factory=dict)  # of the object, before the mesh's own
    color: tuple[float, float, float, float] = (1.0, 1.0, 1.0, 1.0)  # values of Object Info
    index: int = 0
    random: float = 0.0  # 0 to 1
    motion: np.ndarray | None = None  # (K, 4, 4) matrices at even times of the shutter; None: no motion
    around: np.ndarray | None = None  # (2, 4, 4) matrices at the previous and the next frame; None: the same
    light_set: int = OPEN_SET
    shadow_set: int = OPEN_SET
    catcher: bool = False  # a shadow catcher
    terminator: float = 0.0  # cosine below which light rays start above triangles with smooth normals; 0: none does
    asset: str = ""  # for Cryptomatte: the name of the object that all its parents end in


@dataclass
class Shutter:
    """Times run from 0, where the shutter opens, to 1. A moving object has its state at K times, evenly from 0 to 1,
    with linear motion in between. ``motion`` of a lamp, a light or the camera is K copies of itself; empty: no motion.
    A lamp keeps the shape and the emission of each copy until the time of the next one.

    ``times`` divide the exposure into equal parts. With ``rolling``, lines are exposed from the top of the frame to its
    bottom, each for this fraction of the time.
    """

    times: np.ndarray = field(default_factory=lambda: np.linspace(0.0, 1.0, 2))
    rolling: float | None = None


@dataclass
class Lamp(Emitter):
    """An SDF lamp: the interior of ``shape`` glows, and neither absorbs nor scatters.

    Its world volume is V = shape volume × |det matrix|. Emission per metre is ρ = power · color / (4π V), in watts per
    steradian and cubic metre. So far away, the lamp lights like a Blender point light of the same power. With a
    ``density``, ρ = density · color instead, for any volume.

    With a relative ``emission`` e(x), ρ(x) = power · color · e(x) / (4π V ē), where ē is the mean of e over the volume
    and its channels; or ρ(x) = density · color · e(x). Rays of the camera see ``camera_brightness`` times as much.
    """

    name: str
    shape: Shape
    matrix: np.ndarray
    power: float = 10.0
    density: float | None = None
    color: RGB = (1.0, 1.0, 1.0)
    visibility: Ray = Ray.ALL
    emission: Emission | None = None  # None: uniform
    motion: tuple = ()
    camera_brightness: float = 1.0


@dataclass
class Light(Emitter):
    """One of Blender's lights; ``render.lights`` has their classes, each with its ``color``. ``emission``: nodes whose
    Emission closures multiply its radiance."""

    name: str
    matrix: np.ndarray  # shines along its local −z
    visibility: Ray = field(default=Ray.ALL, kw_only=True)
    cast_shadow: bool = field(default=True, kw_only=True)
    emission: Material | None = field(default=None, kw_only=True)
    motion: tuple = field(default=(), kw_only=True)


@dataclass
class Portal:
    """A rectangle or ellipse through which light of the world is sampled, on the side of its local −z. It emits no
    light."""

    name: str
    matrix: np.ndarray
    ellipse: bool = False
    size: tuple[float, float] = (1.0, 1.0)  # this and the spread as those of an area light
    spread: float = np.pi


@dataclass
class World:
    """Background radiance: ``color`` × ``strength``, times the equirectangular ``image`` if there is one, or times the
    Emission closures of ``emission``, whose position is the direction of the ray. So are the shader AOVs of ``aovs``.
    ``medium`` fills all space."""

    color: RGB = (0.0, 0.0, 0.0)
    strength: float = 1.0
    image: int | None = None
    rotation: np.ndarray = field(default_factory=lambda: np.eye(3))  # world direction -> image direction
    visibility: Ray = Ray.ALL
    emission: Material | None = None
    aovs: Material | None = None
    medium: Medium | None = None
    max_bounces: int = MANY_BOUNCES
    light_group: str = ""
    own_pass: str = ""


class Projection(enum.IntEnum):
    """How a point (x, y) of ``Camera.window`` becomes a ray. The third and later ones are panoramas."""

    PERSPECTIVE = 0  # on the plane z = −1
    ORTHOGRAPHIC = 1  # metres
    EQUIRECTANGULAR = 2  # longitude and latitude
    FISHEYE_EQUIDISTANT = 3  # the distance from (0, 0) is the angle θ from the viewing axis
    FISHEYE_EQUISOLID = 4  # it is sin(θ / 2)
    FISHEYE_POLYNOMIAL = 5  # millimetres r of a sensor; −θ is the polynomial of r with the coefficients ``Camera.lens``
    MIRROR_BALL = 6  # a mirror ball of radius 1, seen from infinitely far; its middle shows the view ahead
    CUBEMAP_FACE = 7  # angles from the viewing axis, to the right and upwards
    CYLINDER = 8  # longitude, and height on a cylinder of radius 1


FULL_SPHERE = (-np.pi, np.pi, -np.pi / 2, np.pi / 2)  # window of an equirectangular camera that sees everything


@dataclass
class Eye:
    """Position of one of two eyes that turn with the viewing direction (spherical stereo)."""

    offset: float  # metres to the right of the camera, half the distance between the eyes
    convergence: float = np.inf  # metres at which both eyes see the same
    merge: tuple[float, float] | None = (
        None  # angles above and below the horizon where the eyes begin to converge, and where they coincide
    )


@dataclass
class Camera:
    """Looks along its local −z, y up.

    ``window`` is (left, right, bottom, top) of the whole frame in the plane of its projection, including sensor fit,
    shift and pixel aspect.
    """

    matrix: np.ndarray  # camera to world, without scale
    projection: Projection = Projection.PERSPECTIVE
    window: tuple[float, float, float, float] = (-0.5, 0.5, -0.5, 0.5)
    clip: tuple[float, float] = (0.1, 1000.0)  # along the viewing axis (radius for panoramas)
    field: float = np.inf  # of a fisheye: angle from edge to edge, outside of which there is no picture
    lens: tuple[float, ...] = (0.0, 0.0, 0.0, 0.0, 0.0)  # of a polynomial fisheye: coefficients of r⁰ … r⁴
    eye: Eye | None = None  # of panoramas
    aperture: float = 0.0  # lens radius in metres; 0: pinhole
    focus: float = 10.0  # distance of the plane in focus
    blades: int = 0  # fewer than 3: round
    blade_rotation: float = 0.0
    blade_ratio: float = 1.0
    motion: tuple = ()
    around: tuple = ()  # itself at the previous and the next frame; empty: the same


@dataclass
class Mist:
    """The pass of that name: the position of the distance between ``start`` and ``depth`` behind it (metres), from 0 to
    1, to the ``power``."""

    start: float = 5.0
    depth: float = 25.0
    power: float = 2.0


@dataclass
class Scene:
    """Everything to be rendered. Indices (mesh, material, image) point into the lists here."""

    camera: Camera
    width: int
    height: int
    border: tuple[int, int, int, int] | None = None  # x0, y0, x1, y1 in pixels of the full frame
    meshes: list[Mesh] = field(default_factory=list)
    instances: list[Instance] = field(default_factory=list)
    materials: list[Material] = field(default_factory=list)
    images: list[Image] = field(default_factory=list)
    lamps: list[Lamp] = field(default_factory=list)
    lights: list[Light] = field(default_factory=list)
    portals: list[Portal] = field(default_factory=list)
    world: World = field(default_factory=World)
    mist: Mist = field(default_factory=Mist)
    alpha_threshold: float = 0.5  # alpha from which on a surface has depth, a normal, numbers and other data
    occlusion_distance: float = 10.0  # metres within which the pass Ambient Occlusion looks for surfaces
    passes: list[Pass] = field(default_factory=list)  # that exist in addition to ``passes.PASSES``
    attributes: list[Attribute] = field(default_factory=list)  # that passes look up, in addition to those of materials
    settings: Settings = field(default_factory=Settings)
    shutter: Shutter | None = None  # None: nothing moves
    background_moves: bool = False  # whether the pass Vector also includes the background
    warnings: list[str] = field(default_factory=list)
    kept: dict | None = (
        None  # data that a back end keeps for the next render, whose scene may be nearly the same; None: nothing
    )

    @property
    def clearest(self) -> float:
        """The greatest transparency of a surface that has data, by the ``alpha_threshold``; all have with 0."""
        return 1.0 - self.alpha_threshold + _ROUNDING if self.alpha_threshold > 0.0 else np.inf

    def looked_up(self) -> list[Attribute]:
        """Every attribute that is looked up, in the order of their indices."""
        return attributes_of(self.materials, self.attributes)


def catches_shadows(scene: Scene) -> bool:
    """Whether there are shadow catchers."""
    return any(instance.catcher for instance in scene.instances)


def catchers_only(scene: Scene) -> Scene:
    """The scene whose only objects are its shadow catchers. Indices of instances and of their triangles stay; the other
    instances have no triangles. Lamps and lights that do not count for catchers are missing. No medium fills the world.
    Warnings are not repeated."""
    empty = Mesh("", np.zeros((0, 3), np.float32), np.zeros((0, 3), np.int32))
    kept = {instance.mesh for instance in scene.instances if instance.catcher}
    return replace(
        scene,
        meshes=[*(mesh if index in kept else empty for index, mesh in enumerate(scene.meshes)), empty],
        instances=[
            instance if instance.catcher else replace(instance, mesh=len(scene.meshes), attributes={}, motion=None)
            for instance in scene.instances
        ],
        lamps=[lamp for lamp in scene.lamps if lamp.lights_catchers],
        lights=[light for light in scene.lights if light.lights_catchers],
        world=replace(scene.world, medium=None),
        warnings=[],
        kept=None,
    )
