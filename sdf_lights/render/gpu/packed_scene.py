# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A scene in the form that a GPU reads: the words of its tables, its triangles, and the source of its path tracer."""

from __future__ import annotations

import pathlib
from collections.abc import Callable

import numpy as np

from ...emitter import lamps as emitter_lamps
from ...emitter.intersection import intervals
from ...emitter.sampling import cut
from ...emitter.tree import interior
from ...graph import codegen_glsl
from ...graph.codegen_native import LANES
from ...graph.tables import address_slots, as_float32, with_places
from ..film import CHANNELS, HALF_BIT, SCATTERED, Film
from ..interfaces import LightPathTracer
from ..kernels import camera, geometry, integrator, lamp_tree, lights, path, rays, samplers, shading
from ..kernels.light_paths import code_table as light_path_code
from ..kernels.media import code_table as media_code
from ..kernels.media import pack as media
from ..kernels.media.grids import least_section
from ..kernels.media.records import NOTHING
from ..kernels.outputs import code_table as output_code
from ..kernels.outputs import dispatch as outputs
from ..kernels.outputs.pack import bits_of, pack_outputs, workspace_counts
from ..kernels.outputs.records import DATA
from ..kernels.packing import build_lamps, emissive_triangles, emitter_tables, instance_boxes, integrator_scalars
from ..kernels.shading.material_records import LOBE_PRINCIPLED
from ..kernels.shading.operands import run
from ..kernels.shading.records import HAS_SUBSURFACE, HAS_TRANSPARENCY
from ..kernels.shading.special_lobes import LOBE_SUBSURFACE, WITH_SUBSURFACE, WITH_THIN_SCATTERING
from ..kernels.strands import dispatch as strands
from ..kernels.strands.surface import fill as fill_strand
from ..kernels.subsurface import code_table as subsurface_code
from ..kernels.workspace import WORKSPACE_TABLES
from ..medium import some_varies
from ..passes import CATCHER_SUMS
from ..scene import Scene
from ..settings import LampSampling
from . import catchers, closed_lamp_parts, lamp_kernels, light_paths, replacements, special, varying_media
from . import crossings as field_crossings
from . import images as gpu_images
from .bvh import KINDS, MOST_IN_LEAF, Hierarchy
from .device import GROUP, DeviceError
from .graphs import GraphSource, graphs_of_volumes
from .layout import Record
from .tables import NEAR, Tables
from .thread_arrays import ThreadArrays
from .translate import BLOCK, INT, WORKSPACE, Translator, Value, known
from .translate.values import SECONDARY

FOLDER = pathlib.Path(__file__).resolve().parents[3] / "shaders_glsl"

MOST_ROWS = 1024  # intervals for which a thread has memory: 8 kB
PRINCIPLED_CLOSURES = 8
# Maximum number of bounces at which lamps are sampled by cuts: with more, most noise has other sources, and threads
# wait for cuts at every bounce.
CUT_BOUNCES = 0
TEXTURE_BITS = 14  # width of a texture row: the minimum that OpenGL 4.3 guarantees

# Scalars of the block that are constants of a program.
SETTLED = frozenset(
    {
        "caustics",
        "transparent_film",
        "shows_environment",
        "emitters_hit",
        "transparent_shadows",
        "stops_light_rays",
        "emission_graphs",
        "finite_lights",
        "lamp_strategy",
        "few_lamps",
        "has_media",
        "camera_in_media",
        "has_subsurface",
        "light_paths",
        "light_path_follows",
        "light_path_all",
        "light_path_roulette",
        "light_path_first_node",
        "caustic_paths",
        "reuses_paths",
        "has_strands",
        "outputs",
        "light_columns",
        "data_columns",
        "matte_kinds",
        "matte_slots",
    }
)

# Tables of a film that kernels write into: here those of a thread's pixel, by the first of its sums.
WRITTEN = {
    "film_count": "sums[FILM_COUNT + {}]",
    "film_light": "sums[FILM_LIGHT + {}]",
    "film_data": "sums[FILM_DATA + {}]",
    "film_mattes": "sums[FILM_MATTES + {}]",
}


MOST_NUMBERS = 1 << 24  # of lamps and their tables, whose indices are float32


def _kernels(code: dict[int, tuple]) -> dict[int, Callable]:
    """Those of a table of ``media_code``."""
    return {place: kernel for place, (kernel, _) in code.items()}


# Kernels that the CPU compiles separately, by the tables that hold their addresses there.
CODE = {
    "media_code": _kernels(media_code.KERNELS),
    "subsurface_code": subsurface_code.KERNELS,
    "output_code": {place: kernel for place, (_, kernel, _) in output_code.KERNELS.items()},
    "strand_code": {strands.FILL: fill_strand},
    "light_path_code": _kernels(light_path_code.KERNELS),
}


def _with_tables(numbers: np.ndarray, addresses: list[int]) -> np.ndarray:
    """Numbers of lamps, followed by the tables whose addresses they contain; the addresses become indices."""
    numbers, tables = with_places(numbers, addresses, len(numbers))
    found = np.concatenate([numbers, *(as_float32(table) for table in tables)])
    if len(found) > MOST_NUMBERS:
        raise DeviceError(
            f"outlines, curves and grids of lamps have {len(found):,} numbers, but it can address at most {MOST_NUMBERS:,}"
        )
    return found


class GpuScene:
    """Tables and source for one scene, which stands still, and one film. ``software``: not for a graphics card. It
    reads textures faster as images, because there is no code for levels of detail then, and has the arrays of a thread
    as variables (see ``thread_arrays``); ``room``: bytes of a buffer; ``hierarchy``: that of the same triangles, curves
    and spheres, if there is one; ``moves``: whether the same scene at other times shares the program; ``group``:
    threads of a work group; ``tracer``: of the light paths with which paths are connected, if they are."""

    def __init__(
        self,
        scene: Scene,
        film: Film,
        software: bool = False,
        room: float = np.inf,
        hierarchy: Hierarchy | None = None,
        moves: bool = False,
        group: int = GROUP,
        tracer: LightPathTracer | None = None,
    ):
        if scene.settings.lamp_sampling is LampSampling.EXTERNAL:
            raise DeviceError("it has no such sampling of lamps")
        self._software = software
        self.group = group
        self.connects = tracer is not None
        self.formulas = lamp_kernels.Formulas()
        materials, graphs = shading.pack_materials(scene)
        self.lobes = materials["lobes"]
        self.graphs = GraphSource(graphs.structures, graphs_of_volumes(materials))
        materials["graph_addresses"] = np.zeros(1, np.int64)  # addresses of machine code, which is not used here
        flags = materials["materials"]["flags"]
        self.deep, transparent = bool((flags & HAS_SUBSURFACE).any()), flags & HAS_TRANSPARENCY != 0
        bits = lights.shadow_bits(scene)
        masks = rays.masks_of(scene.instances, transparent, bits)
        if film.catches:
            masks = [catchers.mask(scene, index, mask) for index, mask in enumerate(masks)]
        self.hierarchy = hierarchy or Hierarchy(scene, masks)
        built, sources, _ = build_lamps(scene)
        self.lamps = built
        emissive = emissive_triangles(scene, materials["materials"])
        emitters = emitter_tables(scene, built, sources, emissive, materials, graphs)
        self._place_fields(emitters, sources)
        self.asked_for_cuts = scene.settings.lamp_sampling is LampSampling.CUT
        self.cuts = self.asked_for_cuts and scene.settings.max_bounces <= CUT_BOUNCES
        if self.cuts:
            emitters |= cut.pack_cuts(built, sources)
            emitters["lamp_boxes"] = lamp_kernels.flat_boxes(emitters)
        elif self.asked_for_cuts:  # by projection, whose weight follows from the spread of a lamp
            emitters["lamp_placements"] = cut.pack_cuts(built, sources)["lamp_placements"]
        shapes = geometry.pack_geometry(scene, self.hierarchy.baked)
        view = camera.pack_camera(scene)
        media_tables, media_scalars = media.pack_media(scene)
        self.media = bool(media_scalars["has_media"])
        self.varies = self.media and some_varies(scene)
        self.all_vary = self.varies and bool((media_tables["media"]["varies"] != NOTHING).all())
        self.world_varies = scene.world.medium is not None and scene.world.medium.varying is not None
        if self.varies:
            read = {**materials, **shapes, **view, **media_tables}
            media_tables |= varying_media.grids_of(scene, read, camera.camera_scalars(scene), graphs)
            media_scalars["media_step"] = least_section(*instance_boxes(scene))
        self.images = materials.pop("images")
        del materials["decoding"]
        tables = {**materials, **shapes, **emitters, **view, **samplers.TABLES}
        tables |= gpu_images.placed(scene.images, self.images)
        if self.media:
            tables |= media_tables
            bounds = media_tables["media_bounds"]
            media_scalars |= media.camera_scalars(scene.camera, bounds, scene, *instance_boxes(scene))
        shown, more = {}, {"outputs": 0}
        if has_outputs(film):
            emitters_shown = [*sources, *scene.lights, scene.world]
            shown, more = pack_outputs(scene, film, emitters_shown, emissive.instance)
            if not (film.matte_places or film.data_places.keys() - set(CATCHER_SUMS)):
                more["outputs"] &= ~DATA  # catchers alone need no properties of surfaces
        tables |= {name: table for name, table in shown.items() if name not in WRITTEN}
        if tracer is not None:
            tables |= tracer.tables
        # Columns of data that are of the first sample of a pixel.
        self.first_alone = np.flatnonzero(shown.get("data_numbers", ()))
        varying = bool((materials["emissions"]["graph"] != shading.NO_GRAPH).any())
        scalars = {
            **media_scalars,
            "has_subsurface": int(self.deep),
            "has_strands": int(bool(self.hierarchy.strands)),
            "light_paths": int(self.connects),
            "caustic_paths": 0,
            "reuses_paths": 0,
            **more,
            **(tracer.scalars if tracer is not None else {}),
            "emission_graphs": varying,
            **camera.camera_scalars(scene),
            **integrator_scalars(scene, flags, tables),
            "hierarchy_root": self.hierarchy.root,
            "few_lamps": int(len(built) <= lamp_kernels.FEW),
            "lanes": LANES,
            "shows_environment": int(film.sums["environment"].size > 0),
        }
        shining = np.flatnonzero((tables["light_emitters"]["leaf"] >= 0) | (tables["light_emitters"]["infinite"] >= 0))
        self.one_emitter = len(shining) == 1 and len(tables["light_trees"]) == 1
        scalars["only_emitter"] = int(shining[0]) if len(shining) else -1
        settled = set(SETTLED)
        if len(built) < 2:  # with more, compilers would unroll loops over lamps
            settled.add("lamp_count")
        if scalars["camera_aperture"] == 0.0:
            settled.add("camera_aperture")
        changing = catchers.changing(more["outputs"]) if film.catches else {}
        self.film = film
        unknown = frozenset({"instances"} if moves else ())
        self.tables = Tables(
            tables,
            scalars,
            frozenset(settled),
            self._workspace(tables),
            room // 4,
            CODE | {"media_code": _kernels(media_code.VARYING)} if self.varies else CODE,
            changing,
            WRITTEN,
            unknown,
            ThreadArrays(buffered=not software),
            light_paths.streamed() if self.connects else None,
        )
        self.scalars = scalars

    def _place_fields(self, tables, sources) -> None:
        """A table that tells how to evaluate lamps' fields; it replaces the CPU's compiled terms in the rows of
        lamps."""
        rows = tables["lamps"]
        found = np.zeros(len(rows), closed_lamp_parts.FIELD)
        numbers, used, addresses = [np.zeros(0)], 0, list[int]()
        self._numbers: dict[int, set[int]] = {}  # possible starts of the parameters of each formula
        self.written_out = closed_lamp_parts.WrittenOut.of(self.lamps)
        pieces, first_part = [np.zeros(0, closed_lamp_parts.PART)], 0
        for index, (row, field, source) in enumerate(zip(rows, found, sources)):
            row["direct"] = row["instruction_count"] > 0
            row["first_term"] = index
            if row["kind"] == emitter_lamps.CLOSED:
                if self.written_out is not None:
                    self._first_written_out = int(row["first_instruction"])
                pieces.append(closed_lamp_parts.parts_of(self.lamps[index].program))
                field["first_part"], field["part_count"] = first_part, len(pieces[-1])
                first_part += len(pieces[-1])
            if row["kind"] == emitter_lamps.FIELD:
                shape, tree = source.shape, interior.tree(source.shape)
                field["formula"] = self.formulas.add(self.formulas.fields, (shape.formula(),))
                field["parameters"], field["center"] = used, tree.center
                self._numbers.setdefault(int(field["formula"]), set()).add(used)
                values = np.array(shape.parameters(), np.float64)
                addresses += [used + slot for slot in address_slots(shape.formula())]
                numbers.append(values)
                used += len(values)
        for glow, lamp in zip(tables["lamp_glows"], [lamp for lamp in self.lamps if lamp.emission is not None]):
            compiled = lamp.emission.compiled
            glow["address"] = self.formulas.add(self.formulas.colours, tuple(compiled.placed.colour))
            glow["parameters"] = used
            addresses += [used + slot for slot in address_slots(*compiled.placed.colour)]
            numbers.append(compiled.parameters)
            used += len(compiled.parameters)
        if self.formulas.nodes > lamp_kernels.MOST_NODES:
            raise DeviceError(
                f"the formulas of the scene's lamps have {self.formulas.nodes} nodes together, but the "
                f"limit is {lamp_kernels.MOST_NODES}"
            )
        tables["lamp_parameters"] = _with_tables(np.concatenate(numbers), addresses)
        tables["lamp_walk"] = field_crossings.flat_nodes(tables["lamp_nodes"])
        tables["lamp_fields"], tables["lamp_parts"] = found, np.concatenate(pieces)

    def _workspace(self, tables) -> dict:
        lobes = tables["lobes"]
        deep = lobes["features"] & (WITH_SUBSURFACE | WITH_THIN_SCATTERING) != 0
        each = np.where(lobes["kind"] == LOBE_PRINCIPLED, PRINCIPLED_CLOSURES + 2 * deep, 1)
        each[lobes["kind"] == LOBE_SUBSURFACE] = 2  # and nodes that are not deep
        materials = tables["materials"]["lobes"]
        closures = max((int(each[first:last].sum()) for first, last in materials), default=1)
        rows = [1]
        for lamp in self.lamps:
            if lamp.row["kind"][0] == emitter_lamps.FIELD:
                rows.append(field_crossings.INTERVALS + 1)
            else:
                needed = intervals.rows_needed(lamp.program)[0]
                if needed > MOST_ROWS:
                    raise DeviceError(
                        f"lamp “{lamp.name}” has too many parts: a ray may need room for {needed} "
                        f"intervals, and a thread has it for {MOST_ROWS}"
                    )
                rows.append(needed + len(closed_lamp_parts.parts_of(lamp.program)))
        if self.written_out is not None:
            rows.append(self.written_out.rows)
        counts = {
            "spans": 2 * max(rows),
            "light_hits": lights.hit_capacity(tables),
            **path.COUNTS,
            "path": 1,
            "sample": 1,
            "ray": 3 if self.film.catches else 2 if self.media or self.deep else 1,  # the kept ones
            "surface": 1,
            "closures": max(min(closures, 64), 2),
            "registers": self.graphs.registers(),
            "lamp_cuts": 1,
            "light_cut": 1,
            **lamp_tree.workspace_counts(len(self.lamps)),
        }
        if self.connects:
            counts["light_path_choice"] = 1
        if self.media:
            counts["inside"] = 2  # of the path and of a light ray
        if self.varies:
            # The translator reads an array of three floats as a vector.
            counts |= {"media_weights": max(len(tables["media_parts"]), 4), "media_random": 1}
        if has_outputs(self.film):
            counts |= workspace_counts(self.film)
            counts["first_scatterings"] = min(counts["first_scatterings"], 2)  # of the path and of a light ray
            counts["output_sums"] = max(counts["output_sums"], 4)  # three numbers would be a vector
            counts = {name: count for name, count in counts.items() if count}
        if self.film.catches:
            counts |= {"path": 2, "sample": 2}
        dtypes = {
            **WORKSPACE_TABLES,
            **lamp_kernels.ROWS,
            "media_random": np.dtype(np.uint32),
            "lamp_cuts": lamp_kernels.FLAT_CUT if self.cuts else lamp_kernels.WITHOUT_BOXES,
        }
        return {name: (dtypes[name], count) for name, count in counts.items()}

    def shares_program_with(self, other: GpuScene) -> bool:
        """Whether the program of this scene is also that of another one, which differs by motion."""
        return self._constants() == other._constants() and self.tables.shares_program_with(other.tables)

    def _constants(self) -> tuple:
        """What a program has in it beside its tables, as far as things that move can change it."""
        flags = self.cuts, self.one_emitter, len(self.lamps), self.scalars["transparent_shadows"]
        return flags, self._defines(), self._numbers, self.formulas.fields, self.formulas.colours

    def source(self) -> str:
        """GLSL of the path tracer."""
        translator = self.translator()
        scene, workspace = known(BLOCK), known(WORKSPACE)
        translator.function(path.clear_sample, [workspace])
        translator.function(integrator.start_path, [scene, workspace, Value(INT, "x"), Value(INT, "y")])
        translator.function(integrator.prepare_ray, [scene, workspace])
        translator.function(integrator.advance, [scene, workspace, known(False)])
        seed, _ = translator.function(samplers.pixel_seed, [Value(INT, name) for name in ("x", "y", "film_seed")])
        calls = ["", f"#define PIXEL_SEED {seed}"]
        if has_outputs(self.film):
            name, _ = translator.function(outputs.clear, [scene, workspace])
            calls.append(f"#define CLEAR {name}")
            name, _ = translator.function(outputs.add_sample, [scene, workspace, Value(INT, "0")])
            calls.append(f"#define ADD_OUTPUTS {name}")
        if self.film.catches:
            translator.function(integrator.intersect_and_gather, [scene, workspace])
            translator.function(integrator.shade_and_scatter, [scene, workspace, known(False)])
            for kernel in (outputs.release, outputs.add_bare):
                name, _ = translator.function(kernel, [scene, workspace])
                calls.append(f"#define {kernel.__name__.upper()} {name}")
        return self.assembled(translator, "\n".join(calls) + "\n" + glsl("film.glsl"))

    def translator(self) -> Translator:
        """The translator of kernels to GLSL for this scene."""
        groups = [replacements.ALWAYS, replacements.WITH_BOXES if self.cuts else replacements.WITHOUT_BOXES]
        if self.asked_for_cuts and not self.cuts:
            groups.append(replacements.BY_PROJECTION)
        if self.one_emitter:
            groups.append(replacements.ONE_EMITTER)
            if not self.scalars["transparent_shadows"]:
                groups.append(replacements.ONE_LIGHT_RAY)
        if not self.lamps:
            groups.append(replacements.NO_LAMPS)
        if self.film.catches:
            groups.append(replacements.CATCHERS)
        if self.connects:
            groups.append(replacements.LIGHT_PATHS)
        constants = replacements.ROUNDING | replacements.ROWS | replacements.SETS
        if self.varies and not self.world_varies:
            groups.append(replacements.WITHOUT_VARYING_WORLD)
            constants |= varying_media.FEW_NUMBERS
        if self.all_vary:
            groups.append(replacements.ALL_MEDIA_VARY)
        written = {run: self.graphs.native}
        if self.written_out is not None:
            written[intervals.solve] = self.written_out.native(self._first_written_out)
        chosen = replacements.together(*groups, special.natives(self.lobes), written)
        return Translator(self.tables, chosen, constants)

    def assembled(self, translator: Translator, main: str) -> str:
        """A whole shader: the translated functions, and its ``main``."""
        graphs = self.graphs.source(translator)
        kernels = "\n\n".join(translator.functions)
        self.tables.used_scalars |= dict.fromkeys(
            ("hierarchy_root", "lamp_fields_start", "lamp_parameters_start"), "int"
        )
        workspace = self.tables.workspace_source(secondary=SECONDARY.prefix in kernels or SECONDARY.prefix in graphs)
        return "\n".join(
            [
                "#version 430 core",
                # NVIDIA's compiler unrolls loops of constant length; that took it twice as long, for no more speed.
                "#pragma optionNV(unroll none)",
                self.tables.uniform_source(),
                *self._defines(),
                glsl("maths.glsl"),
                self.tables.buffer_source(),
                *codegen_glsl.helpers("angle"),
                self.tables.arrays.source(),
                workspace,
                glsl("words.glsl"),
                glsl("hashing.glsl"),
                glsl("rays.glsl"),
                *([glsl("strands.glsl")] if self.hierarchy.strands else []),
                self._lamp_source(),
                translator.structure_source(),
                *translator.globals,
                self.graphs.declarations(),
                kernels,
                graphs,
                "",
                main,
            ]
        )

    def _defines(self) -> list[str]:
        field = Record("lamp_fields", closed_lamp_parts.FIELD)
        numbers = {
            "GROUP": self.group,
            "STACK": -(-self.hierarchy.depth // 16) * 16,
            "ITEMS_IN_LEAF": MOST_IN_LEAF,
            "TEXTURE_BITS": TEXTURE_BITS,
            "FIELD_SIZE": field.size,
            **{f"FIELD_{name.upper()}": offset for name, (offset, _) in field.fields.items()},
            "HALF_BIT": HALF_BIT,
            "GOES_ON": integrator.GOES_ON,
        }
        if self.hierarchy.strands:
            numbers |= {f"HAS_{kind.name}": int(kind) for kind in self.hierarchy.strands} | {"KINDS": KINDS}
        places, used = film_places(self.film)
        if has_outputs(self.film):  # loops over no columns name them all the same
            numbers |= {"FILM_LIGHT": used, "FILM_DATA": used, "FILM_MATTES": used}
        numbers |= {f"FILM_{name.upper()}": place for name, place in places.items()}
        numbers["PIXEL_SIZE"] = used
        numbers["EACH_SUM(what)"] = " ".join(f"what({place})" for place in range(used))
        rows = "rows[0]" if self.film.catches else "row"
        numbers |= {"PATH": f"path_{rows}", "SAMPLE": f"sample_{rows}"}
        switches = {
            "INSTANCES": self.hierarchy.instanced,
            "IMAGES": self._software,
            "ONE_INSTANCE": self.deep,
            "CATCHERS": self.film.catches,
            "OUTPUTS": has_outputs(self.film),
            "MEDIA": self.media,
            "STRANDS": bool(self.hierarchy.strands),
        }
        return [
            *(f"#define {name} {value}" for name, value in numbers.items()),
            *(f"#define {name}" for name, on in switches.items() if on),
            "float sums[PIXEL_SIZE];  // of this thread's pixel",
        ]

    def _lamp_source(self) -> str:
        no_lengths = (
            "void note_length(int lamp, int column, float amount) {}\n"
            "void choose_noted_lamp(int thread) {}\n"
            "void write_lengths() {}"
        )
        reader = self.tables.reader("lamp_parameters")
        parts = [
            glsl("lengths.glsl") if self.formulas.fields else no_lengths,
            "int lamp_numbers;",
            f"float field_number(int slot) {{ return {reader}float_at(lamp_numbers + slot); }}",
            f"#define table_number(i) {reader}float_at(scene.lamp_parameters_start + (i))",
        ]
        functions: set[str] = set()
        # if only one shape has a formula, its numbers have fixed indices
        near = self.tables.near_place("lamp_parameters")
        kinds = (self.formulas.fields, "field", "float"), (self.formulas.colours, "colour", "vec3")
        for formulas, name, kind in kinds:
            if not formulas:
                continue
            for index, formula in enumerate(formulas):
                reading = "field_number({})"
                if name == "field" and near is not None and len(self._numbers[index]) == 1:
                    (place,) = self._numbers[index]
                    reading = f"{NEAR}float_at({near + place} + {{}})"
                written = formula if name == "colour" else formula[0]
                try:
                    parts.append(codegen_glsl.function(written, f"{name}_{index}", reading, functions))
                except codegen_glsl.UnwrittenError as error:
                    raise DeviceError(str(error)) from None
            cases = [f"    case {index}: return {name}_{index}(p);" for index in range(len(formulas) - 1)]
            parts.append(
                "\n".join(
                    [
                        f"{kind} lamp_{name}_of(int formula, vec3 p)",
                        "{",
                        "    switch (formula) {",
                        *cases,
                        f"    default: return {name}_{len(formulas) - 1}(p);",
                        "    }",
                        "}",
                    ]
                )
            )
        if self.formulas.colours:
            parts.append(
                "vec3 lamp_colour(int formula, int first, vec3 p)\n{\n"
                "    lamp_numbers = scene.lamp_parameters_start + first;\n"
                "    return lamp_colour_of(formula, p);\n}"
            )
        else:
            parts.append("vec3 lamp_colour(int formula, int first, vec3 p) { return vec3(0.0); }")
        if not self.formulas.fields:
            parts += [
                "void choose_field(int row) {}",
                "float field(vec3 p) { return 1.0; }",
                "float field_value(int row, vec3 p) { return 1.0; }",
            ]
        else:
            term = Record("lamps", emitter_lamps.LAMP).fields["first_term"][0]
            parts.append(f"int first_term(int row) {{ return {self.tables.reader('lamps')}int_at(row + {term}); }}")
            parts.append(glsl("lamps.glsl"))
        return "\n".join(parts)


def film_places(film: Film) -> tuple[dict[str, int], int]:
    """Index of each sum among the floats of a pixel, and their number."""
    places, used = {}, 0
    for name, count in CHANNELS.items():
        if len(film.sums[name]) and name not in SCATTERED.values():  # paths do not split here
            places[name] = used
            used += count
    for name in ("count", "surfaces", "nan", "infinite"):
        places[name] = used
        used += 1
    for name, sums in (("light", film.light_sums), ("data", film.data_sums), ("mattes", film.matte_sums)):
        if sums.size:
            places[name] = used
            used += sums[0].size
    return places, used


def has_outputs(film: Film) -> bool:
    """Whether a film has passes beside ``film.CHANNELS``."""
    return bool(bits_of(film))


def glsl(name: str) -> str:
    """Text of a file of ``shaders_glsl/``."""
    return (FOLDER / name).read_text(encoding="utf-8")
