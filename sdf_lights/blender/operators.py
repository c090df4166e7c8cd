# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Add > Light > SDF Lamp, and the operators in the panels of a lamp."""

import math

import bpy
import numpy as np
from bpy_extras.object_utils import AddObjectHelper, object_data_add

from ..render.errors import RenderError
from ..sdf.catalogue import grouped
from ..sdf.declarations import USAGE
from ..sdf.examples import examples
from ..sdf.shapes import SHAPES
from ..sdf.shapes.profiles import PROFILES
from ..sdf.surface_nets import surface_net
from ..sdf.syntax import ExpressionError
from . import areas, emission, fallback, labels, parameters, preset_sources, readout
from .context import LampOperator, light_of
from .lamp import pattern_of, shape_of
from .lamp_presets import load_preset, set_expression
from .nodes import editor, writing
from .nodes.tree import output_of, trees
from .preset_pictures import icon_of
from .presets import presets
from .properties import PRIMITIVES, shape_items
from .shader_trees import use_nodes

_DIALOG_WIDTH, _DIALOG_LETTERS = 700, 100


def example_items() -> list[tuple]:
    """Items of an EnumProperty with every example."""
    return [(name.upper(), example.title, "") for name, example in examples().items()]


def preset_items() -> list[tuple]:
    """Items of an EnumProperty with every preset."""
    return [(name.upper(), preset.title, "") for name, preset in presets().items()]


def _profiles() -> dict[str, type]:
    """Profiles defined only by numbers."""
    return {name: profile for name, profile in PROFILES.items() if profile.fields()}


def profile_items() -> list[tuple]:
    """Items of an EnumProperty with every profile defined by numbers."""
    return [(name.upper(), profile.label(), profile.summary().rstrip(".")) for name, profile in _profiles().items()]


def _written(value: float) -> str:
    return f"{value:.7g}"


def profile_expression(name: str, sweep: str) -> str:
    """A profile extruded or revolved, with a parameter for each of its numbers."""
    profile, solid = PROFILES[name], SHAPES[sweep]
    lines, named = [], {}
    for kind in (profile, solid):
        for about in kind.fields():
            default, maximum = about.default, about.soft_maximum
            if kind is solid and about.name == "offset":
                default = 0.6  # placed beside the axis so that it does not cross it
            key = f"{sweep}_{about.name}" if about.name in named or about.name in USAGE else about.name
            minimum = max(about.minimum, 0.001) if about.unit == "LENGTH" and about.minimum > 0.0 else about.minimum
            word = "integer" if about.whole else "angle" if about.unit == "ANGLE" else "slider"
            numbers = [default, minimum, maximum]
            shown = ", ".join(_written(math.degrees(n) if word == "angle" else n) for n in numbers)
            lines.append(f"{key} = {word}({shown})  # {about.description}")
            named[key] = kind, about.name
    inner, outer = (
        ", ".join(f"{argument}={key}" for key, (owner, argument) in named.items() if owner is kind)
        for kind in (profile, solid)
    )
    return "\n".join([*lines, f"{sweep}({name}({inner}), {outer})", ""])


def load_example(light: bpy.types.Light, name: str) -> None:
    """Make the light a lamp with an example as its expression, in a new text block."""
    example = examples()[name.lower()]
    set_expression(light, example.title, example.text)


class SDFLIGHTS_OT_lamp_add(bpy.types.Operator, AddObjectHelper):
    """Add a lamp whose inside glows"""

    bl_idname = "sdf_lights.lamp_add"
    bl_label = "Add SDF Lamp"
    bl_options = {"REGISTER", "UNDO"}

    source: bpy.props.EnumProperty(
        name="Source",
        description="Source of the shape of the lamp",
        items=[
            ("PRIMITIVE", "Primitive", "One shape with its parameters", 0),
            ("EXPRESSION", "Expression", "A few lines of text that combine shapes", 1),
            ("EXAMPLE", "Example", "A worked example of an expression", 2),
            ("PRESET", "Preset", "A lamp with a color and a power", 3),
            ("PROFILE", "Profile", "An outline that is extruded or revolved about an axis", 4),
            ("NODES", "Nodes", "A node tree that combines shapes", 5),
        ],
    )
    shape: bpy.props.EnumProperty(name="Shape", description="Shape that glows", items=shape_items(), default="SPHERE")
    example: bpy.props.EnumProperty(name="Example", description="Expression to start from", items=example_items())
    preset: bpy.props.EnumProperty(name="Preset", description="Lamp to start from", items=preset_items())
    profile: bpy.props.EnumProperty(name="Profile", description="Outline of the solid", items=profile_items())
    sweep: bpy.props.EnumProperty(
        name="Solid",
        description="How the outline becomes a solid",
        items=[
            (name.upper(), SHAPES[name].label(), SHAPES[name].summary().rstrip("."))
            for name in ("extrusion", "revolution", "partial_revolution")
        ],
    )
    tree: bpy.props.StringProperty(name="Node Tree", description="Node tree of the lamp; an empty name makes a new one")
    power: bpy.props.FloatProperty(
        name="Power", description="Power of the whole lamp", default=100.0, min=0.0, soft_max=1000.0, unit="POWER"
    )

    @classmethod
    def poll(cls, context):
        return context.mode == "OBJECT"

    def _title(self) -> str:
        if self.source == "PRIMITIVE":
            return f"{PRIMITIVES[self.shape.lower()].label()} Lamp"
        if self.source == "PROFILE":
            return f"{PROFILES[self.profile.lower()].label()} Lamp"
        if self.source == "EXAMPLE":
            return examples()[self.example.lower()].title
        return presets()[self.preset.lower()].title if self.source == "PRESET" else "SDF Lamp"

    def execute(self, context):
        name = self._title()
        light = bpy.data.lights.new(name, "POINT")
        light.energy = self.power
        lamp = light.sdf_lamp
        lamp.use = True
        if self.source == "EXAMPLE":
            load_example(light, self.example)
        elif self.source == "PRESET":
            load_preset(light, self.preset)
        elif self.source == "PROFILE":
            set_expression(light, name, profile_expression(self.profile.lower(), self.sweep.lower()))
        elif self.source == "NODES":
            lamp.nodes = bpy.data.node_groups.get(self.tree) if self.tree else writing.tree_of(name, "sphere(0.5)")
            lamp.source = "NODES"
            if lamp.nodes is not None:
                editor.show(context, lamp.nodes)
        else:
            lamp.source, lamp.shape = self.source, self.shape
        parameters.update(light)
        try:
            shape_of(lamp)
        except RenderError as error:  # the node tree has a mistake
            self.report({"WARNING"}, str(error))
        fallback.follow(light)
        made = object_data_add(context, light, operator=self, name=name)
        if self.source == "PRESET":
            preset_sources.place(parameters.things_of(light), made)
        return {"FINISHED"}

    def draw(self, context):
        layout = self.layout
        layout.use_property_split = True
        layout.prop(self, "source")
        for prop in {
            "PRIMITIVE": ("shape",),
            "EXAMPLE": ("example",),
            "PRESET": ("preset",),
            "PROFILE": ("profile", "sweep"),
        }.get(self.source, ()):
            layout.prop(self, prop)
        if self.source == "NODES":
            layout.prop_search(self, "tree", bpy.data, "node_groups")
        if self.source != "PRESET":
            layout.prop(self, "power")
        layout.prop(self, "align")
        layout.prop(self, "location")
        layout.prop(self, "rotation")


class SDFLIGHTS_OT_example_load(LampOperator, bpy.types.Operator):
    """Load a worked example into a new text block, as the lamp's expression"""

    bl_idname = "sdf_lights.example_load"
    bl_label = "Load Example"

    example: bpy.props.EnumProperty(name="Example", description="Expression to start from", items=example_items())

    def execute(self, context):
        load_example(light_of(context), self.example)
        return {"FINISHED"}


class SDFLIGHTS_OT_expression_to_text(LampOperator, bpy.types.Operator):
    """Put the lamp's expression into a new text block, where it can have several lines"""

    bl_idname = "sdf_lights.expression_to_text"
    bl_label = "Edit as Text"

    def execute(self, context):
        light = light_of(context)
        light.sdf_lamp.text = parameters.new_text(light.name, parameters.text_of(light.sdf_lamp))
        return {"FINISHED"}


class SDFLIGHTS_OT_parameters_remove(LampOperator, bpy.types.Operator):
    """Remove parameters of earlier expressions of the lamp"""

    bl_idname = "sdf_lights.parameters_remove"
    bl_label = "Remove Unused Parameters"

    def execute(self, context):
        parameters.remove_unused(light_of(context))
        return {"FINISHED"}


class SDFLIGHTS_OT_preset_load(LampOperator, bpy.types.Operator):
    """Give the lamp the shape, color, emission and power of a preset"""

    bl_idname = "sdf_lights.preset_load"
    bl_label = "Use Preset"

    preset: bpy.props.EnumProperty(name="Preset", description="Lamp to start from", items=preset_items())

    def execute(self, context):
        light = light_of(context)
        load_preset(light, self.preset)
        owner = next((obj for obj in bpy.data.objects if obj.data == light and obj.users_collection), None)
        if owner is not None:
            preset_sources.place(parameters.things_of(light), owner)
        return {"FINISHED"}


class SDFLIGHTS_OT_expression_show(LampOperator, bpy.types.Operator):
    """Show the text block of the lamp in a text editor, at the line of a mistake. Opens an editor if none is open"""

    bl_idname = "sdf_lights.expression_show"
    bl_label = "Show in Text Editor"
    bl_options = {"REGISTER"}

    emission: bpy.props.BoolProperty(
        name="Emission", description="Show the text of the emission instead of the shape", options={"SKIP_SAVE"}
    )

    def execute(self, context):
        lamp = light_of(context).sdf_lamp
        text = lamp.emission.text if self.emission else lamp.text
        if text is None:
            self.report({"INFO"}, "The expression is not in a text block: make one with New.")
            return {"CANCELLED"}
        wrong = (emission if self.emission else parameters).parsed(text.as_string())
        if isinstance(wrong, ExpressionError):
            line = min(wrong.line, len(text.lines)) - 1
            text.cursor_set(line, character=min(wrong.column - 1, len(text.lines[line].body)))
        area = areas.area_of(context, "TEXT_EDITOR") or areas.opened(context, "TEXT_EDITOR")
        if area is None:
            self.report({"INFO"}, "No window has room for a text editor: open a window first.")
        else:
            area.spaces.active.text = text
            area.spaces.active.top = max(text.current_line_index - 5, 0)
            area.tag_redraw()
        return {"FINISHED"}


class SDFLIGHTS_OT_expression_edit(LampOperator, bpy.types.Operator):
    """Edit the expression in a wide field, with its mistakes below"""

    bl_idname = "sdf_lights.expression_edit"
    bl_label = "Edit Expression"

    emission: bpy.props.BoolProperty(
        name="Emission", description="Edit the text of the emission instead of the shape", options={"SKIP_SAVE"}
    )

    def invoke(self, context, event):
        return context.window_manager.invoke_props_dialog(self, width=_DIALOG_WIDTH)

    def draw(self, context):
        lamp = light_of(context).sdf_lamp
        owner, read = (lamp.emission, pattern_of) if self.emission else (lamp, shape_of)
        self.layout.prop(owner, "expression", text="")
        try:
            read(lamp)
        except RenderError as error:
            labels.draw_problem(self.layout, error, _DIALOG_LETTERS)

    def execute(self, context):
        return {"FINISHED"}


class SDFLIGHTS_OT_lamp_to_mesh(bpy.types.Operator):
    """Convert the selected lamps to meshes with a glowing material"""

    bl_idname = "sdf_lights.lamp_to_mesh"
    bl_label = "SDF Lamp to Mesh"
    bl_options = {"REGISTER", "UNDO"}

    resolution: bpy.props.IntProperty(
        name="Resolution",
        description="Cells along the longest side of the lamp",
        default=64,
        min=4,
        max=512,
        soft_max=256,
    )
    keep_original: bpy.props.BoolProperty(name="Keep Original", description="Keep the lamps as well", default=False)

    @classmethod
    def poll(cls, context):
        return context.mode == "OBJECT" and any(map(_is_lamp, context.selected_objects))

    def execute(self, context):
        made = 0
        for obj in list(filter(_is_lamp, context.selected_objects)):
            try:
                to_mesh(obj, self.resolution, self.keep_original)
                made += 1
            except RenderError as error:
                self.report({"ERROR"}, f"Lamp '{obj.name}' stays as it is. {error}")
        return {"FINISHED"} if made else {"CANCELLED"}


def _is_lamp(obj: bpy.types.Object) -> bool:
    return obj.type == "LIGHT" and obj.data.sdf_lamp.use


def to_mesh(obj: bpy.types.Object, resolution: int, keep_original: bool) -> bpy.types.Object:
    """A mesh object that replaces a lamp; its surface gives as much light. Raises RenderError."""
    light = obj.data
    matrix = np.array(obj.matrix_world)
    shape = shape_of(light.sdf_lamp, matrix)
    vertices, faces = surface_net(shape, resolution)
    if not len(faces):
        raise RenderError("It is too thin for this resolution: choose a higher one.")
    mesh = bpy.data.meshes.new(light.name)
    mesh.from_pydata(vertices, [], faces.tolist())
    mesh.shade_smooth()
    power = readout.power_of(light, shape, matrix, pattern_of(light.sdf_lamp, matrix), wait=True)
    mesh.materials.append(_glowing(light, power, mesh, obj.matrix_world))
    name = obj.name
    made = bpy.data.objects.new(name, mesh)
    for collection in obj.users_collection:
        collection.objects.link(made)
    made.parent, made.parent_type, made.parent_bone = obj.parent, obj.parent_type, obj.parent_bone
    made.matrix_parent_inverse = obj.matrix_parent_inverse
    made.rotation_mode = obj.rotation_mode
    made.matrix_basis = obj.matrix_basis
    active = bpy.context.view_layer.objects.active == obj
    obj.select_set(False)
    made.select_set(True)
    if active:
        bpy.context.view_layer.objects.active = made
    if not keep_original:
        bpy.data.objects.remove(obj)
        made.name = name
    return made


def _glowing(light: bpy.types.Light, power: float, mesh: bpy.types.Mesh, matrix) -> bpy.types.Material:
    """A material that emits the lamp's colour with this power, spread over the surface."""
    copy = mesh.copy()
    copy.transform(matrix)
    area = sum(face.area for face in copy.polygons)
    bpy.data.meshes.remove(copy)
    material = bpy.data.materials.new(light.name)
    use_nodes(material)
    nodes, links = material.node_tree.nodes, material.node_tree.links
    nodes.clear()
    shader, output = nodes.new("ShaderNodeEmission"), nodes.new("ShaderNodeOutputMaterial")
    output.location = (200.0, 0.0)
    tint = light.temperature_color if light.use_temperature else (1.0, 1.0, 1.0)
    shader.inputs["Color"].default_value = (*(a * b for a, b in zip(light.color, tint)), 1.0)
    # A surface of radiance E gives π E A watts.
    shader.inputs["Strength"].default_value = power / (math.pi * area)
    links.new(shader.outputs[0], output.inputs["Surface"])
    return material


class SDFLIGHTS_MT_examples(bpy.types.Menu):
    """Worked examples of the language."""

    bl_label = "Load Example"
    bl_idname = "SDFLIGHTS_MT_examples"

    def draw(self, context):
        for name, title, _ in example_items():
            self.layout.operator(SDFLIGHTS_OT_example_load.bl_idname, text=title).example = name


def _add_menu(idname: str, title: str, source: str, prop: str, items, icon=lambda name: 0) -> type:
    """A menu that adds a lamp of one source, from the items of an enumeration. ``icon`` returns the icon number of an
    item."""

    def draw(self, context):
        for name, label, _ in items():
            operator = self.layout.operator(SDFLIGHTS_OT_lamp_add.bl_idname, text=label, icon_value=icon(name))
            operator.source = source
            setattr(operator, prop, name)

    doc = f"Adds a lamp: {title}."
    return type(idname, (bpy.types.Menu,), {"__doc__": doc, "bl_label": title, "bl_idname": idname, "draw": draw})


SDFLIGHTS_MT_examples_add = _add_menu("SDFLIGHTS_MT_examples_add", "Examples", "EXAMPLE", "example", example_items)
SDFLIGHTS_MT_presets_add = _add_menu(
    "SDFLIGHTS_MT_presets_add", "Presets", "PRESET", "preset", preset_items, lambda name: icon_of(name.lower())
)
SDFLIGHTS_MT_profiles_add = _add_menu("SDFLIGHTS_MT_profiles_add", "Profiles", "PROFILE", "profile", profile_items)


class SDFLIGHTS_MT_nodes_add(bpy.types.Menu):
    """Node trees from which a lamp can be made."""

    bl_label = "From Nodes"
    bl_idname = "SDFLIGHTS_MT_nodes_add"

    def draw(self, context):
        operator = self.layout.operator(SDFLIGHTS_OT_lamp_add.bl_idname, text="New Node Tree", icon="ADD")
        operator.source, operator.tree = "NODES", ""
        for tree in trees():
            if output_of(tree) is not None:
                operator = self.layout.operator(SDFLIGHTS_OT_lamp_add.bl_idname, text=tree.name, translate=False)
                operator.source, operator.tree = "NODES", tree.name


def _shapes_menu(index: int, title: str, shapes: list) -> type:
    """The menu of one group of shapes."""

    def draw(self, context):
        for shape in shapes:
            operator = self.layout.operator(SDFLIGHTS_OT_lamp_add.bl_idname, text=shape.label())
            operator.source, operator.shape = "PRIMITIVE", shape.name().upper()

    name = f"SDFLIGHTS_MT_lamp_add_{index}"
    return type(name, (bpy.types.Menu,), {"bl_label": title, "bl_idname": name, "draw": draw})


_SHAPES_MENUS = [
    _shapes_menu(index, title, shapes) for index, (title, shapes) in enumerate(grouped(PRIMITIVES.values()).items())
]


_ICONS = {  # of the groups of shapes
    "Basic": "MESH_UVSPHERE",
    "Rounded": "MESH_CAPSULE",
    "Spherical": "SPHERE",
    "Swept": "MOD_SCREW",
    "Curved": "HEART",
    "Tubes": "CURVE_BEZCURVE",
    "Coils and Knots": "FORCE_VORTEX",
    "Polyhedra": "MESH_ICOSPHERE",
    "Minimal Surfaces": "MOD_CAST",
    "Fractals": "OUTLINER_OB_POINTCLOUD",
}


class SDFLIGHTS_MT_lamp_add(bpy.types.Menu):
    """Sources of a new SDF lamp."""

    bl_label = "SDF Lamp"
    bl_idname = "SDFLIGHTS_MT_lamp_add"

    def draw(self, context):
        layout = self.layout
        layout.operator_context = "INVOKE_REGION_WIN"
        for menu in _SHAPES_MENUS:
            layout.menu(menu.bl_idname, icon=_ICONS.get(menu.bl_label, "BLANK1"))
        layout.menu(SDFLIGHTS_MT_profiles_add.bl_idname, icon="MOD_SCREW")
        layout.separator()
        layout.menu(SDFLIGHTS_MT_presets_add.bl_idname, icon_value=icon_of("campfire"))
        layout.menu(SDFLIGHTS_MT_examples_add.bl_idname, icon="TEXT")
        layout.separator()
        layout.menu(SDFLIGHTS_MT_nodes_add.bl_idname, icon="NODETREE")
        layout.operator(SDFLIGHTS_OT_lamp_add.bl_idname, text="From an Expression", icon="SCRIPT").source = "EXPRESSION"


def draw_menu(self, context):
    """Entry in Add > Light."""
    self.layout.menu(SDFLIGHTS_MT_lamp_add.bl_idname, icon_value=icon_of("neon_ring"))


def draw_convert(self, context):
    """Entries in Object > Convert, if lamps are selected."""
    if SDFLIGHTS_OT_lamp_to_mesh.poll(context):
        self.layout.separator()
        self.layout.operator(SDFLIGHTS_OT_lamp_to_mesh.bl_idname, icon="OUTLINER_OB_MESH")
        self.layout.operator(editor.SDFLIGHTS_OT_nodes_new.bl_idname, text="SDF Lamp to Nodes", icon="NODETREE")
        self.layout.operator(
            editor.SDFLIGHTS_OT_nodes_to_expression.bl_idname, text="SDF Lamp to Expression", icon="TEXT"
        )


CLASSES = (
    SDFLIGHTS_OT_lamp_add,
    SDFLIGHTS_OT_example_load,
    SDFLIGHTS_OT_preset_load,
    SDFLIGHTS_OT_expression_to_text,
    SDFLIGHTS_OT_expression_show,
    SDFLIGHTS_OT_expression_edit,
    SDFLIGHTS_OT_parameters_remove,
    SDFLIGHTS_OT_lamp_to_mesh,
    SDFLIGHTS_MT_examples,
    SDFLIGHTS_MT_examples_add,
    SDFLIGHTS_MT_presets_add,
    SDFLIGHTS_MT_profiles_add,
    SDFLIGHTS_MT_nodes_add,
    *_SHAPES_MENUS,
    SDFLIGHTS_MT_lamp_add,
)

_ENTRIES = ((bpy.types.VIEW3D_MT_light_add, draw_menu), (bpy.types.VIEW3D_MT_object_convert, draw_convert))


def register():
    for menu, draw in _ENTRIES:
        menu.append(draw)


def unregister():
    for menu, draw in _ENTRIES:
        menu.remove(draw)
