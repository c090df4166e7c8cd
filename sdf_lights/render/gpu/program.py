# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A scene as a GPU reads it: the words of its tables, its triangles, and the source of its path tracer."""

from __future__ import annotations

import inspect
import pathlib

import numpy as np

from ...emitter import bounding, crossings, cut, cut_points, emission, fields, hashing, interior, intervals, surfaces
from ...emitter import lamps as emitter_lamps
from ...jit import stack_array
from ...sdf import read_glsl
from ..cpu import camera, gather, geometry, integrator, lamp_tree, lights, next_event, path, rays, sampler, shading
from ..cpu.block import LAMP_SLOT, build_lamps, emissive_triangles, emitter_tables, integrator_scalars
from ..cpu.shading.program import LOBE_PRINCIPLED
from ..cpu.shading.records import HAS_TRANSPARENCY
from ..cpu.workspace import WORKSPACE_TABLES, cut_of, light_cut_of, spans_of
from ..film import CHANNELS, HALF_BIT, SCATTERED, Film
from ..scene import Scene
from ..settings import LampSampling
from . import crossings as field_crossings
from . import lamps, parts
from .bvh import MOST_IN_LEAF, Hierarchy
from .device import DeviceError
from .layout import Array, Record
from .tables import NEAR, Tables
from .translate import BLOCK, BOOL, FLOAT, INT, UINT, VECTOR, WORKSPACE, Native, Ref, Translator, Tuple, Value, known

FOLDER = pathlib.Path(__file__).resolve().parents[3] / "shaders_glsl"

MOST_ROWS = 1024  # of intervals that a thread has room for: 8 kB
PRINCIPLED_CLOSURES = 7
# Bounces up to which lamps are sampled by cuts: with more, most noise is not theirs, and threads wait for them at
# every bounce.
CUT_BOUNCES = 0
TEXTURE_BITS = 14  # a row of a texture is so wide: what OpenGL 4.3 allows everywhere

# Numbers of the CPU's kernels that stand for the rounding of float64, in float32.
ROUNDING = {
    ("primitives", "QUARTIC_ROUNDING"): 4e-7, ("primitives", "POLISH"): 3e-2, ("sponge", "_ROUNDING"): 1e-6,
    ("cover", "SIGN"): 1e-30, ("cover", "LARGEST"): 1e30, ("crossings", "SIGN"): 1e-30,
    ("lamps", "SMALLEST_INTERVAL"): 2e-6, ("rectangle", "SMALL"): 3e-3, ("triangle", "SMALL"): 3e-2}

# Scalars of the block that a program is made for.
SETTLED = frozenset({
    "caustics", "transparent_film", "emitters_hit", "transparent_shadows", "finite_lights", "lamp_cuts",
    "lamp_slot", "uv_layer_count", "few_lamps"})


def _spans(function, arguments):
    rows = Array(Array("float", 2, packed=True), packed=True)
    return Value(Ref(rows, "spans_rows[{}]"), "0")


def _ray(name: str, any_hit: str):
    def call(function, arguments):
        block, workspace, *rest = arguments
        texts = [*function.passed(rest[:2]), *(function.converted(value, FLOAT).text for value in rest[2:4]),
                 function.converted(rest[4], INT).text]
        return Value(BOOL, f"hit_scene({workspace.constant.prefix}ray_row, {', '.join(texts)}, {any_hit})")

    return Native(call)


def _field_value(function, arguments):
    _, row, _, _, p = arguments
    return Value(FLOAT, f"field_value({', '.join(function.passed([row, p]))})")


def _stack(function, arguments):
    return function.translator.local_array(int(arguments[0].constant))


def _note(function, arguments):
    return Value(None, f"note_length({', '.join(function.passed(arguments[1:4]))})")


def _only_row(name: str) -> Native:
    """The one row of a table of the workspace, of which a thread needs no more: its path does not divide."""
    def call(function, arguments):
        table = function.translator.tables.table(name, None, arguments[0])
        return Value(Ref(table.type.layout.inner, table.type.lvalue))

    return Native(call)


def _plain(kernel):
    return inspect.unwrap(kernel)


def natives(cuts: bool, one_emitter: bool = False, project: bool = False) -> dict:
    """Kernels that have GLSL of their own, or other kernels in their place. ``project``: where cuts are asked for."""
    found = {
        sampler.pixel_seed: Native("pixel_seed", UINT), sampler.draw1: Native("draw1", FLOAT),
        sampler.draw2: Native("draw2", Tuple((FLOAT,) * 2)), sampler.draw3: Native("draw3", VECTOR),
        sampler.draw4: Native("draw4", Tuple((FLOAT,) * 4)),
        hashing.seeded: Native("counted_seeded", UINT), hashing.following: Native("counted_following", UINT),
        hashing.uniform: Native("counted_uniform", FLOAT), hashing.uniform_point: Native("counted_point", VECTOR),
        rays.intersect: _ray("nearest", "false"), rays.occluded: _ray("any", "true"),
        stack_array: Native(_stack), spans_of: Native(_spans),
        crossings.crossings: field_crossings.crossings, field_crossings.choose: Native("choose_field"),
        field_crossings.field_at: Native("field", FLOAT),
        field_crossings.halves: Native("unpackHalf2x16", Tuple((FLOAT, FLOAT))), fields.value: Native(_field_value),
        emitter_lamps.note_length: Native(_note), lamps.colour: Native("lamp_colour", VECTOR),
        emission.line_integral: lamps.line_integral, cut_points.sample_point: lamps.sample_point,
        cut_points.project_afar: cut.project, emitter_lamps.solve_all: parts.solve_all,
        cut_of: _only_row("lamp_cuts"), light_cut_of: _only_row("light_cut"),
        lamp_tree.lamps_along: lamps.lamps_along, lights.tree._prepare: lamps.prepare_light_cut}
    if one_emitter:
        found |= {lights.tree.select: lamps.select_only, lights.tree.selection_probability: lamps.only_probability}
    if cuts:
        found |= {cut.prepare: lamps.prepare, surfaces.sample: lamps.no_surface_direction,
                  surfaces.density: lamps.no_surface_density, bounding.sample: lamps.no_bounding_direction,
                  bounding.density: lamps.no_bounding_density}
    else:
        found |= {cut.sample: lamps.sample, cut.density: lamps.density}
    if project:
        found[next_event.prepare_lamp] = lamps.prepare_lamp
    return {_plain(kernel): value for kernel, value in found.items()}


class GpuScene:
    """Tables and source for one scene and one film. ``images``: whether textures are read faster as images;
    ``room``: bytes of a buffer."""

    def __init__(self, scene: Scene, film: Film, images: bool = False, room: float = np.inf):
        if scene.settings.lamp_sampling in LAMP_SLOT:
            raise DeviceError("it has no such sampling of lamps")
        self._images = images
        self.formulas = lamps.Formulas()
        materials = shading.pack_materials(scene)
        flags = materials["materials"]["flags"]
        transparent = flags & HAS_TRANSPARENCY != 0
        self.hierarchy = Hierarchy(scene, [rays.mask_of(instance, transparent) for instance in scene.instances])
        layers = shading.uv_layers(scene)
        built, sources = build_lamps(scene)
        self.lamps = built
        emitters = emitter_tables(scene, built, emissive_triangles(scene, materials["materials"]))
        self._place_fields(emitters, sources)
        self.asked_for_cuts = scene.settings.lamp_sampling is LampSampling.CUT
        self.cuts = self.asked_for_cuts and scene.settings.max_bounces <= CUT_BOUNCES
        if self.cuts:
            emitters |= cut.pack_cuts(built, sources)
            emitters["lamp_boxes"] = lamps.flat_boxes(emitters)
        elif self.asked_for_cuts:  # by projection, whose weight follows from how spread out a lamp is
            emitters["lamp_placements"] = cut.pack_cuts(built, sources)["lamp_placements"]
        self.images = materials.pop("images")
        tables = {
            **materials, **geometry.pack_geometry(scene, self.hierarchy.baked, layers), **emitters,
            **camera.pack_camera(scene), "sobol": sampler.tables()}
        self._place_images(scene, tables)
        scalars = {
            **camera.camera_scalars(scene), "uv_layer_count": len(layers),
            **integrator_scalars(scene, flags, tables), "hierarchy_root": self.hierarchy.root,
            "tree_width": lamp_tree.WIDTH, "few_lamps": int(len(built) <= lamps.FEW)}
        shining = np.flatnonzero((tables["light_emitters"]["leaf"] >= 0) | (tables["light_emitters"]["infinite"] >= 0))
        self.one_emitter = len(shining) == 1
        scalars["only_emitter"] = int(shining[0]) if len(shining) else -1
        settled = set(SETTLED)
        if len(built) < 2:  # with more, compilers would unroll loops over lamps
            settled.add("lamp_count")
        if scalars["camera_aperture"] == 0.0:
            settled.add("camera_aperture")
        self.tables = Tables(tables, scalars, frozenset(settled), self._workspace(tables), room // 4)
        self.film = film
        self.textured = bool(tables["light_triangles"]["textured"].any())
        self.scalars = scalars

    def _place_fields(self, tables, sources) -> None:
        """A table of how lamps' fields are read; the rows of lamps point at it where the CPU has compiled terms."""
        rows = tables["lamps"]
        found = np.zeros(len(rows), parts.FIELD)
        numbers, used = [np.zeros(0)], 0
        self._numbers: dict[int, set[int]] = {}  # of each formula where its parameters may begin
        self.written_out = parts.WrittenOut.of(self.lamps)
        pieces, first_part = [np.zeros(0, parts.PART)], 0
        for index, (row, field, source) in enumerate(zip(rows, found, sources)):
            row["direct"] = row["instruction_count"] > 0
            row["first_term"] = index
            if row["kind"] == emitter_lamps.CLOSED:
                if self.written_out is not None:
                    self._first_written_out = int(row["first_instruction"])
                pieces.append(parts.parts_of(self.lamps[index].program))
                field["first_part"], field["part_count"] = first_part, len(pieces[-1])
                first_part += len(pieces[-1])
            if row["kind"] == emitter_lamps.FIELD:
                shape, tree = source.shape, interior.tree(source.shape)
                field["formula"] = self.formulas.add(self.formulas.fields, (shape.formula(),))
                field["parameters"], field["center"] = used, tree.center
                self._numbers.setdefault(int(field["formula"]), set()).add(used)
                numbers.append(np.asarray(shape.parameters(), np.float64))
                used += len(numbers[-1])
        for glow, lamp in zip(tables["lamp_glows"], [lamp for lamp in self.lamps if lamp.emission is not None]):
            compiled = lamp.emission.compiled
            glow["address"] = self.formulas.add(self.formulas.colours, tuple(compiled.placed.colour))
            glow["parameters"] = used
            numbers.append(compiled.parameters)
            used += len(compiled.parameters)
        if self.formulas.nodes > lamps.MOST_NODES:
            raise DeviceError(f"the formulas of the scene's lamps have {self.formulas.nodes} nodes together, and drivers "
                              f"are given {lamps.MOST_NODES} at most")
        tables["lamp_parameters"] = np.concatenate(numbers)
        tables["lamp_walk"] = field_crossings.flat_nodes(tables["lamp_nodes"])
        tables["lamp_fields"], tables["lamp_parts"] = found, np.concatenate(pieces)

    def _place_images(self, scene, tables) -> None:
        records, parts, used = self.images.copy(), [], 0
        for record, image in zip(records, scene.images):
            if record["width"] > 0:
                record["texels_address"] = used
                parts.append(np.asarray(image.pixels, np.float32).ravel())
                used += parts[-1].size
        texels = np.concatenate([np.zeros(0, np.float32), *parts])
        tables["images"], tables["texels"] = records, texels

    def _workspace(self, tables) -> dict:
        lobes = tables["lobes"]
        each = np.where(lobes["kind"] == LOBE_PRINCIPLED, PRINCIPLED_CLOSURES, 1)
        materials = tables["materials"]["lobes"]
        closures = max((int(each[first:last].sum()) for first, last in materials), default=1)
        registers = int(tables["instructions"]["out"].max()) + 4
        rows = [field_crossings.INTERVALS + 1]
        for lamp in self.lamps:
            if lamp.row["kind"][0] != emitter_lamps.FIELD:
                needed = intervals.rows_needed(lamp.program)[0]
                if needed > MOST_ROWS:
                    raise DeviceError(f"lamp “{lamp.name}” has too many parts: a ray may need room for {needed} "
                                      f"intervals, and a thread has it for {MOST_ROWS}")
                rows.append(needed + len(parts.parts_of(lamp.program)))
        if self.written_out is not None:
            rows.append(self.written_out.rows)
        counts = {
            "spans": 2 * max(rows), "light_hits": lights.hit_capacity(tables), **path.COUNTS, "path": 1, "ray": 1,
            "surface": 1, "closures": max(min(closures, 64), 2), "registers": registers, "lamp_cuts": 1, "light_cut": 1,
            **lamp_tree.workspace_counts(len(self.lamps))}
        dtypes = {**WORKSPACE_TABLES, **lamps.ROWS,
                  "lamp_cuts": lamps.FLAT_CUT if self.cuts else lamps.WITHOUT_BOXES}
        return {name: (dtypes[name], count) for name, count in counts.items()}

    def source(self) -> str:
        """GLSL of the path tracer."""
        translator = self.translator()
        scene, workspace = known(BLOCK), known(WORKSPACE)
        translator.function(path.clear_sample, [workspace])
        translator.function(integrator.start_path, [scene, workspace, Value(INT, "x"), Value(INT, "y")])
        translator.function(integrator.expects, [scene, workspace])
        translator.function(integrator.advance, [scene, workspace, known(False)])
        return self.assembled(translator, glsl("film.glsl"))

    def translator(self) -> Translator:
        """What reads kernels as GLSL for this scene."""
        chosen = natives(self.cuts, self.one_emitter, self.asked_for_cuts and not self.cuts)
        if self.one_emitter and not self.scalars["transparent_shadows"]:
            chosen[inspect.unwrap(next_event.renew_lamp)] = lamps.keep_lamp
        if not self.lamps:
            chosen |= {inspect.unwrap(next_event.light_lamp): lamps.no_light,
                       inspect.unwrap(gather.lamp_reach): lamps.no_reach}
        if self.written_out is not None:
            chosen[inspect.unwrap(intervals.solve)] = self.written_out.native(self._first_written_out)
        return Translator(self.tables, chosen, ROUNDING)

    def assembled(self, translator: Translator, main: str) -> str:
        """A whole shader: what the translator has read, and its ``main``."""
        kernels = "\n\n".join(translator.functions)
        self.tables.used_scalars |= dict.fromkeys(
            ("hierarchy_root", "sobol_start", "lamp_fields_start", "lamp_parameters_start"), "int")
        workspace = self.tables.workspace_source(aside=self.textured)
        return "\n".join([
            "#version 430 core", self.tables.uniform_source(), *self._defines(), glsl("maths.glsl"),
            self.tables.second_source(),
            *read_glsl.helpers("angle"), workspace, glsl("random.glsl"), glsl("rays.glsl"), self._lamp_source(),
            translator.structure_source(), *translator.globals, "", kernels, "", main])

    def _defines(self) -> list[str]:
        field = Record("lamp_fields", parts.FIELD)
        numbers = {
            "STACK": -(-self.hierarchy.depth // 16) * 16, "ITEMS_IN_LEAF": MOST_IN_LEAF,
            "TEXTURE_BITS": TEXTURE_BITS,
            "FIELD_SIZE": field.size, **{f"FIELD_{name.upper()}": offset for name, (offset, _) in field.fields.items()},
            "HALF_BIT": HALF_BIT, "GOES_ON": integrator.GOES_ON}
        places, used = film_places(self.film)
        numbers |= {f"FILM_{name.upper()}": place for name, place in places.items()}
        numbers["PIXEL_SIZE"] = used
        switches = {"INSTANCES": self.hierarchy.instanced, "IMAGES": self._images}
        return [f"#define {name} {value}" for name, value in numbers.items()] + [
            f"#define {name}" for name, on in switches.items() if on]

    def _lamp_source(self) -> str:
        no_lengths = "void note_length(int lamp, int column, float amount) {}"
        reader = self.tables.reader("lamp_parameters")
        parts = [glsl("lengths.glsl") if self.formulas.fields else no_lengths, "int lamp_numbers;",
                 f"float field_number(int slot) {{ return {reader}float_at(lamp_numbers + slot); }}"]
        near = self.tables.near_place("lamp_parameters")  # where one shape alone has a formula, its numbers have places
        kinds = (self.formulas.fields, "field", "float"), (self.formulas.colours, "colour", "vec3")
        for formulas, name, kind in kinds:
            if not formulas:
                continue
            for index, formula in enumerate(formulas):
                reading = "field_number({})"
                if name == "field" and near is not None and len(self._numbers[index]) == 1:
                    place, = self._numbers[index]
                    reading = f"{NEAR}float_at({near + place} + {{}})"
                written = formula if name == "colour" else formula[0]
                parts.append(read_glsl.function(written, f"{name}_{index}", reading))
            cases = [f"    case {index}: return {name}_{index}(p);" for index in range(len(formulas) - 1)]
            parts.append("\n".join([
                f"{kind} lamp_{name}_of(int formula, vec3 p)", "{", "    switch (formula) {", *cases,
                f"    default: return {name}_{len(formulas) - 1}(p);", "    }", "}"]))
        if self.formulas.colours:
            parts.append("vec3 lamp_colour(int formula, int first, vec3 p)\n{\n"
                         "    lamp_numbers = scene.lamp_parameters_start + first;\n"
                         "    return lamp_colour_of(formula, p);\n}")
        else:
            parts.append("vec3 lamp_colour(int formula, int first, vec3 p) { return vec3(0.0); }")
        if not self.formulas.fields:
            parts += ["void choose_field(int row) {}", "float field(vec3 p) { return 1.0; }",
                      "float field_value(int row, vec3 p) { return 1.0; }"]
        else:
            term = Record("lamps", emitter_lamps.LAMP).fields["first_term"][0]
            parts.append(f"int first_term(int row) {{ return {self.tables.reader('lamps')}int_at(row + {term}); }}")
            parts.append(glsl("lamps.glsl"))
        return "\n".join(parts)


def film_places(film: Film) -> tuple[dict[str, int], int]:
    """Place of each sum among the floats of a pixel, and how many there are."""
    places, used = {}, 0
    for name, count in CHANNELS.items():
        if len(film.sums[name]) and name not in SCATTERED.values():  # paths do not divide here
            places[name] = used
            used += count
    for name in ("count", "surfaces", "nan", "infinite"):
        places[name] = used
        used += 1
    return places, used


def glsl(name: str) -> str:
    """Text of a file of ``shaders_glsl/``."""
    return (FOLDER / name).read_text(encoding="utf-8")
