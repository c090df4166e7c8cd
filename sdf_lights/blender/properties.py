# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Properties on Blender's data: ``Scene.sdf_lights`` and ``Light.sdf_lamp``.

Scene properties are generated from the fields of ``Settings``, lamp properties from the parameters of every shape. A
new field or shape appears in Blender automatically.
"""

import dataclasses
import enum
import math
import zlib

import bpy
from bpy.app.handlers import persistent

from ..render.settings import CausticPaths, Device, Filter, LampPaths, PathReuse, Settings
from ..sdf.catalogue import grouped
from ..sdf.shapes import SHAPES, Shape
from . import cycles, objects, parameters
from .emission_properties import SDFLIGHTS_LampEmission
from .naming import NODE_TREE

# Settings for which Blender has a property already.
BLENDERS_OWN = {
    "transparent_film": lambda scene: scene.render.film_transparent,
    "threads": lambda scene: scene.render.threads if scene.render.threads_mode == "FIXED" else 0,
}

# Settings with separate values for the viewport, and their defaults there.
VIEWPORT = {"samples": 1024, "noise_threshold": 0.1, "min_samples": 1, "time_limit": 0.0, "denoise": False}

# Tooltips of the choices of settings that panels show.
CHOICES = {
    Device.AUTOMATIC: "The CPU. Without Numba, the slow NumPy reference",
    Device.CPU: "The processor, with all its cores",
    Device.REFERENCE: "The slow NumPy reference, which tests compare the others with",
    Device.GPU: "The graphics card. Without a suitable one, the CPU",
    LampPaths.AUTOMATIC: "Use them in final renders, if the first samples show that they reduce the noise",
    LampPaths.ALWAYS: "Use them wherever the scene allows it",
    LampPaths.NEVER: "Do not use them",
    PathReuse.AUTOMATIC: "Use it in final renders without denoising, if the first samples show that it reduces the noise",
    PathReuse.ALWAYS: "Use it wherever the scene allows it",
    PathReuse.NEVER: "Do not use it",
    CausticPaths.AUTOMATIC: "Use them in final renders, if the first paths show that they reduce the noise",
    CausticPaths.ALWAYS: "Use them in final renders wherever the scene allows it",
    CausticPaths.NEVER: "Do not use them",
    Filter.BOX: "All samples within the width count equally. Edges are sharp, and may look jagged",
    Filter.GAUSSIAN: "Samples near the middle of the pixel count more. Edges are soft",
    Filter.BLACKMAN_HARRIS: "Like Gaussian, with a narrower middle. The default of Cycles",
}

_ABBREVIATIONS = {"CPU", "GPU", "MIS", "BSDF"}

LARGEST_INT = (1 << 31) - 1


FORMS = [
    ("SOLID", "Solid", "Filled parts are extruded, with their bevel; an open curve is a tube", 0),
    ("NEON", "Neon", "A glass tube along every curve or letter, with a gap where it is closed", 1),
]


OF_DATA = {"OBJECT": "an object", "IMAGE": "a picture", "NETWORK": "a network"}
"""Sources of shapes that have no text, and their names in a sentence."""


def tag(self, context):
    """Blender tags the owner of a property for the dependency graph only if the property has a callback."""


def _passes_changed(self, context):
    """Let Blender ask the engine again for its passes, so the compositor shows their sockets."""
    for scene in bpy.data.scenes:
        for view_layer in scene.view_layers:
            view_layer.update_render_passes()


def _items(kind: type[enum.Enum]) -> list[tuple]:
    """Items of an EnumProperty. Files store the numbers, so members of the enumerations keep their order."""
    return [(member.value, _label(member.name), CHOICES.get(member, ""), number) for number, member in enumerate(kind)]


def _label(name: str) -> str:
    return name if name in _ABBREVIATIONS else name.replace("_", " ").title()


def _setting(field: dataclasses.Field, default):
    """The bpy property of one field of ``Settings``."""
    about = field.metadata
    common = dict(
        name=about["label"] or _label(field.name),
        description=about["description"],
        update=cycles.changed,
        options={"HIDDEN"} if about["developer"] else {"ANIMATABLE"},
    )
    if isinstance(default, enum.Enum):
        return bpy.props.EnumProperty(items=_items(type(default)), default=default.value, **common)
    if isinstance(default, bool):
        return bpy.props.BoolProperty(default=default, **common)
    limits = {key: value for key, value in (("min", about["minimum"]), ("max", about["maximum"])) if value is not None}
    if isinstance(default, int):
        return bpy.props.IntProperty(default=default, **limits, **common)
    if about["unit"]:
        # Blender's TIME counts frames.
        common["unit"] = "TIME_ABSOLUTE" if about["unit"] == "TIME" else about["unit"]
    # Three digits hide a threshold of 0.0005.
    return bpy.props.FloatProperty(default=default, precision=4, **limits, **common)


def group(name: str, doc: str, annotations: dict) -> type:
    """A class of property group made from a dictionary of properties."""
    return type(name, (bpy.types.PropertyGroup,), {"__doc__": doc, "__slots__": (), "__annotations__": annotations})


def _version():
    """Version of the settings of a scene or light, for ``versions.py``; 0: not saved yet, or saved by the first
    version."""
    return bpy.props.IntProperty(name="Version", description="Version of the settings", min=0, options={"HIDDEN"})


_FIELDS = {field.name: field for field in dataclasses.fields(Settings) if field.name not in BLENDERS_OWN}

SDFLIGHTS_ViewportSettings = group(
    "SDFLIGHTS_ViewportSettings",
    "Settings of rendering in the viewport",
    {name: _setting(_FIELDS[name], default) for name, default in VIEWPORT.items()},
)

SDFLIGHTS_SceneSettings = group(
    "SDFLIGHTS_SceneSettings",
    "Settings of the SDF Lights render engine",
    {name: _setting(field, field.default) for name, field in _FIELDS.items()}
    | {
        "viewport": bpy.props.PointerProperty(type=SDFLIGHTS_ViewportSettings),
        "layer_samples": bpy.props.EnumProperty(
            name="Layer Samples",
            description="How the samples of a view layer are used",
            update=cycles.changed,
            items=[
                ("USE", "Use", "They replace those of the scene", 0),
                ("BOUNDED", "Bounded", "They replace those of the scene only if they are fewer", 1),
                ("IGNORE", "Ignore", "Nothing", 2),
            ],
        ),
        "beside": bpy.props.PointerProperty(
            name="Beside",
            description="Scene with the lamps whose light is added to the Cycles render of this scene",
            type=bpy.types.Scene,
            options={"HIDDEN"},
        ),
        "is_beside": bpy.props.BoolProperty(
            name="Is Beside",
            description=(
                "The scene renders the light of lamps for another scene, so all its lamps are in one light group"
            ),
            options={"HIDDEN"},
            update=tag,
        ),
        "version": _version(),
        "origin": bpy.props.EnumProperty(
            name="Origin", description="Origin of the settings", items=cycles.ORIGINS, options={"HIDDEN"}
        ),
    },
)


def settings_of(scene: bpy.types.Scene, viewport: bool = False) -> Settings:
    """``Settings`` of the scene, or those copied from Cycles, for the final render or the viewport."""
    source, pending = scene.sdf_lights, cycles.pending(scene)
    values = {name: pending.get(name, getattr(source, name)) for name in _FIELDS}
    if viewport:
        values |= {name: pending.get(f"viewport.{name}", getattr(source.viewport, name)) for name in VIEWPORT}
    for name, field in _FIELDS.items():
        if isinstance(field.default, enum.Enum):
            values[name] = type(field.default)(values[name])
    return Settings(**values, **{name: read(scene) for name, read in BLENDERS_OWN.items()})


def layer_samples(scene: bpy.types.Scene, samples: int, asked: int) -> int:
    """Samples of a view layer that sets its own (0: it does not), if the scene has ``samples``."""
    rule = cycles.pending(scene).get("layer_samples", scene.sdf_lights.layer_samples)
    if asked <= 0 or rule == "IGNORE":
        return samples
    return min(asked, samples) if rule == "BOUNDED" else asked


# -- lamps -------------------------------------------------------------------------------------------------------------


def parameter_property(about):
    """The bpy property of one parameter of a shape."""
    common = dict(name=about.label, description=about.description, update=tag)
    limits = {"default": about.default, "min": about.minimum, "max": about.maximum, "soft_max": about.soft_maximum}
    if about.whole and about.size == 1:
        limits = {key: int(min(max(value, -LARGEST_INT), LARGEST_INT)) for key, value in limits.items()}
        return bpy.props.IntProperty(**limits, **common)
    common |= {key: value for key, value in limits.items() if key == "default" or math.isfinite(value)}
    if about.unit == "ANGLE":
        common["subtype"] = "ANGLE" if about.size == 1 else "EULER"
    elif about.unit != "NONE":
        common["unit"] = about.unit
    if about.size == 3:
        return bpy.props.FloatVectorProperty(size=3, precision=3, **common)
    return bpy.props.FloatProperty(precision=3, **common)


def _is_primitive(shape: type[Shape]) -> bool:
    """Whether the shape is a lamp by its parameters alone.

    An operator needs other shapes, and an unbounded shape needs an intersection: both need an expression.
    """
    return len(shape.fields()) == len(dataclasses.fields(shape)) and shape().bounded


PRIMITIVES = {name: shape for name, shape in SHAPES.items() if _is_primitive(shape)}

_SHAPE_GROUPS = {
    name: group(
        f"SDFLIGHTS_Shape_{name}",
        f"Parameters of the shape {shape.label()}",
        parameters.overridable({about.name: parameter_property(about) for about in shape.fields()}),
    )
    for name, shape in PRIMITIVES.items()
}


def values_of(group, shape: str) -> dict:
    """Parameters of a primitive, in the form of its properties."""
    found = {about.name: getattr(group, about.name) for about in PRIMITIVES[shape].fields()}
    return {name: value if isinstance(value, (int, float)) else tuple(value) for name, value in found.items()}


def _summary(shape: type[Shape]) -> str:
    """First sentence about a shape, without the full stop, like Blender's tooltips."""
    return (shape.__doc__ or shape.label()).strip().splitlines()[0].rstrip(".")


def shape_items() -> list[tuple]:
    """Items of an EnumProperty with every primitive, under the titles of their groups.

    Files store the number. It is made from the name, so it stays the same when shapes are added.
    """
    items = []
    for title, shapes in grouped(PRIMITIVES.values()).items():
        items.append(("", title, ""))
        for shape in shapes:
            number = zlib.crc32(shape.name().encode()) & LARGEST_INT
            items.append((shape.name().upper(), shape.label(), _summary(shape), number))
    return items


def expression_changed(self, context):
    """Make the properties of the parameters that the lamp's expression declares."""
    parameters.update(self.id_data)


def make_groups(lamp) -> None:
    """Let the file store the parameters of every shape, even defaults.

    Blender keeps library overrides of a group only if the linked file has the group.
    """
    if bpy.app.version[:2] == (5, 0):
        # There, pointers of add-ons in a light to what is removed are cleared only if it has a custom property.
        lamp.id_data["SDF Lights"] = True
    for name, kind in PRIMITIVES.items():
        values, first = getattr(lamp, name), kind.fields()[0].name
        if not values.is_property_set(first):
            setattr(values, first, getattr(values, first))
    if not lamp.emission.is_property_set("source"):
        lamp.emission.source = lamp.emission.source


def _use_changed(self, context):
    if self.use and self.id_data.is_editable:
        make_groups(self)


@persistent
def _make_all_groups(*_):
    """Update lamps of older files."""
    for light in bpy.data.lights:
        if light.library is None and light.override_library is None and light.sdf_lamp.use:
            make_groups(light.sdf_lamp)
            parameters.pin(light)


class SDFLIGHTS_LampData(bpy.types.PropertyGroup):
    """Something that the texts of a lamp name, by its ``kind`` and ``name`` there"""

    __slots__ = ()

    kind: bpy.props.StringProperty(name="Kind", description="Word of the expression", override={"LIBRARY_OVERRIDABLE"})
    object: bpy.props.PointerProperty(
        name="Object", description="The object", type=bpy.types.Object, override={"LIBRARY_OVERRIDABLE"}
    )
    image: bpy.props.PointerProperty(
        name="Image", description="The image", type=bpy.types.Image, override={"LIBRARY_OVERRIDABLE"}
    )

    def thing(self) -> bpy.types.ID | None:
        """The object or image, if it is still there."""
        return self.image if self.kind == "image" else self.object


SDFLIGHTS_LampSettings = group(
    "SDFLIGHTS_LampSettings",
    "Settings of an SDF lamp",
    parameters.overridable(
        {
            "use": bpy.props.BoolProperty(
                name="SDF Lamp",
                description=(
                    "The inside of a shape glows in the SDF Lights engine. Other engines render a normal light"
                ),
                default=False,
                update=_use_changed,
            ),
            "source": bpy.props.EnumProperty(
                name="Source",
                description="Source of the shape of the lamp",
                update=expression_changed,
                items=[
                    ("PRIMITIVE", "Primitive", "One shape with its parameters", 0),
                    ("EXPRESSION", "Expression", "Shapes combined by a few lines of text", 1),
                    ("NODES", "Nodes", "Shapes combined by a node tree", 2),
                    ("OBJECT", "Object", "A text, curve, mesh or volume of the scene. The lamp follows its edits", 3),
                    ("IMAGE", "Image", "The outline of a picture, extruded", 4),
                    ("NETWORK", "Network", "A network of sines that was fitted to a shape", 5),
                ],
            ),
            "network": bpy.props.StringProperty(
                name="Network",
                description="File (.npz) of the network. Without one, it is the example of the add-on, a rabbit",
                subtype="FILE_PATH",
                options={"ANIMATABLE", "PATH_SUPPORTS_BLEND_RELATIVE"},
                update=expression_changed,
            ),
            "image": bpy.props.PointerProperty(
                name="Image",
                description="Picture whose outline glows",
                type=bpy.types.Image,
                update=expression_changed,
            ),
            "image_part": bpy.props.EnumProperty(
                name="Part",
                description="Part of the picture that glows",
                update=tag,
                items=[
                    ("ALPHA", "Opaque", "Where alpha is above the threshold", 0),
                    ("BRIGHT", "Bright", "Where the picture is brighter than the threshold", 1),
                    ("DARK", "Dark", "Where the picture is darker than the threshold", 2),
                ],
            ),
            "image_threshold": bpy.props.FloatProperty(
                name="Threshold",
                description="Alpha or brightness at the edge",
                default=0.5,
                min=0.001,
                max=0.999,
                subtype="FACTOR",
                update=tag,
            ),
            "image_colors": bpy.props.BoolProperty(
                name="Own Colors",
                description="Multiply the light by the colors of the picture",
                default=False,
                update=tag,
            ),
            "image_size": bpy.props.FloatProperty(
                name="Width",
                description="Width of the whole picture",
                default=1.0,
                min=1e-5,
                soft_max=10.0,
                unit="LENGTH",
                update=tag,
            ),
            "object": bpy.props.PointerProperty(
                name="Object",
                description="Text, curve, mesh or volume whose shape glows. The lamp follows its edits",
                type=bpy.types.Object,
                poll=lambda self, obj: obj.type in objects.READERS,
                update=expression_changed,
            ),
            "object_form": bpy.props.EnumProperty(
                name="Form",
                description="Shape that the lamp makes from the object",
                update=tag,
                items=FORMS,
            ),
            "thickness": bpy.props.FloatProperty(
                name="Thickness",
                description="Thickness of the lamp if the object has no extrusion and no bevel",
                default=0.1,
                min=1e-5,
                soft_max=1.0,
                unit="LENGTH",
                update=tag,
            ),
            "voxel_size": bpy.props.FloatProperty(
                name="Voxel Size",
                description=(
                    "Size of the voxels that store the distance to a mesh. 0 divides its longest side into 128 voxels "
                    "in renders, 64 in viewports"
                ),
                default=0.0,
                min=0.0,
                soft_max=1.0,
                unit="LENGTH",
                update=tag,
            ),
            "neon_radius": bpy.props.FloatProperty(
                name="Tube Radius",
                description="Radius of the glass tube",
                default=0.02,
                min=1e-5,
                soft_max=0.2,
                unit="LENGTH",
                update=tag,
            ),
            "neon_gap": bpy.props.FloatProperty(
                name="Gap",
                description="Gap between the ends of a closed tube",
                default=0.03,
                min=0.0,
                soft_max=0.5,
                unit="LENGTH",
                update=tag,
            ),
            "shape": bpy.props.EnumProperty(
                name="Shape", description="Shape of the lamp", items=shape_items(), default="SPHERE", update=tag
            ),
            "expression": bpy.props.StringProperty(
                name="Expression",
                description="Formula of the shape, such as union(torus(1, 0.3), sphere(0.5))",
                default="union(torus(0.5, 0.1), sphere(0.2))",
                update=expression_changed,
            ),
            "text": bpy.props.PointerProperty(
                name="Text",
                description="Text block with the expression, if it has several lines",
                type=bpy.types.Text,
                update=expression_changed,
            ),
            "nodes": bpy.props.PointerProperty(
                name="Nodes",
                description="Node tree whose Lamp Output is the shape",
                type=bpy.types.NodeTree,
                poll=lambda self, tree: tree.bl_idname == NODE_TREE,
                update=expression_changed,
            ),
            "normalize": bpy.props.BoolProperty(
                name="Normalize",
                description="Keep the power of the whole lamp when its size or shape changes. "
                "Without it, the radiance per metre stays the same",
                default=True,
                update=tag,
            ),
            "density": bpy.props.FloatProperty(
                name="Radiance per Metre",
                description="Radiance (watts per square metre and steradian) that a ray gains in each metre inside the lamp",
                default=1.0,
                min=0.0,
                soft_max=100.0,
                precision=3,
                update=tag,
            ),
            "use_pass": bpy.props.BoolProperty(
                name="Pass",
                description="The light has a separate render pass in every view layer",
                default=False,
                update=_passes_changed,
            ),
            "visible_camera": bpy.props.BoolProperty(
                # Blender hides every new light from the camera. This suits lights without a visible shape.
                name="Camera",
                description=(
                    "The camera sees the lamp itself. The object's own switch is for the light in other engines"
                ),
                default=True,
                update=tag,
            ),
            "camera_brightness": bpy.props.FloatProperty(
                name="Camera Brightness",
                description="Brightness of the lamp itself to the camera, as a factor. "
                "The light that it casts stays the same",
                default=1.0,
                min=0.0,
                soft_max=1.0,
                precision=3,
                update=tag,
            ),
            "data": bpy.props.CollectionProperty(
                name="Data", description="Objects, images and files that its texts name", type=SDFLIGHTS_LampData
            ),
            "emission": bpy.props.PointerProperty(type=SDFLIGHTS_LampEmission),
            "version": _version(),
        }
        | {name: bpy.props.PointerProperty(type=kind) for name, kind in _SHAPE_GROUPS.items()}
    ),
)


# -- registration ------------------------------------------------------------------------------------------------------

CLASSES = (
    SDFLIGHTS_ViewportSettings,
    SDFLIGHTS_SceneSettings,
    *_SHAPE_GROUPS.values(),
    SDFLIGHTS_LampEmission,
    SDFLIGHTS_LampData,
    SDFLIGHTS_LampSettings,
)

POINTERS = (
    (bpy.types.Scene, "sdf_lights", SDFLIGHTS_SceneSettings),
    (bpy.types.Light, "sdf_lamp", SDFLIGHTS_LampSettings),
)


def register():
    for owner, name, group in POINTERS:
        pointer = bpy.props.PointerProperty(name="SDF Lights", type=group, override={"LIBRARY_OVERRIDABLE"})
        setattr(owner, name, pointer)
    bpy.app.handlers.load_post.append(_make_all_groups)


def unregister():
    bpy.app.handlers.load_post.remove(_make_all_groups)
    for owner, name, _ in POINTERS:
        delattr(owner, name)
