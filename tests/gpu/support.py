# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Kernels by their GLSL reading, for many arguments at a time."""

from __future__ import annotations

import dataclasses
import functools
import inspect

import numpy as np
import pytest

from sdf_lights.graph import codegen_glsl
from sdf_lights.render.film import Film
from sdf_lights.render.gpu import images as gpu_images
from sdf_lights.render.gpu import packed_scene, replacements, thread_arrays
from sdf_lights.render.gpu.device import Device, DeviceError, device
from sdf_lights.render.gpu.tables import Tables
from sdf_lights.render.gpu.translate import BLOCK, FLOAT, INT, VECTOR, WORKSPACE, Translator, Tuple, Value, known
from sdf_lights.render.interfaces import LightPathTracer
from sdf_lights.render.kernels import samplers, textures
from sdf_lights.render.light_paths import traced_by_cpu
from sdf_lights.render.scene import Scene
from sdf_lights.render.settings import LampSampling
from support import scenes

GROUP = 64


@functools.cache
def device_or_skip() -> Device:
    try:
        return device()
    except DeviceError as error:
        pytest.skip(f"no GPU back end: {error}")


def with_light_paths(scene: Scene) -> tuple[Scene, Film, LightPathTracer | None]:
    """A scene, its film, and its light paths."""
    film = Film(scene, ())
    return scene, film, traced_by_cpu(scene, film, lambda: False, lambda text: None)


def _parts(kind, text: str) -> list[str]:
    """GLSL of each number in a value."""
    if not isinstance(kind, Tuple):
        return [text]
    if kind.vector:
        return [f"{text}.{'xyzw'[index]}" for index in range(len(kind.items))]
    return [part for index, item in enumerate(kind.items) for part in _parts(item, f"{text}.v{index}")]


def _flat(value) -> list[float]:
    return [number for item in value for number in _flat(item)] if isinstance(value, tuple) else [float(value)]


def on_gpu(kernel, *columns: np.ndarray) -> np.ndarray:
    """(n, numbers of a result) of a kernel without block or workspace; columns are (n,) numbers or (n, k) tuples."""
    found = device_or_skip()
    tables = Tables(samplers.TABLES, {}, frozenset(), {})
    translator = Translator(
        tables, replacements.together(replacements.ALWAYS, replacements.WITH_BOXES), replacements.ROUNDING
    )
    arguments, inputs, loads = [], [], []
    for index, column in enumerate(columns):
        column = np.asarray(column)
        flat = column.reshape(len(column), -1)
        whole = column.dtype.kind in "iu"
        kind = INT if whole else FLOAT
        reads = [
            f"{'int_at' if whole else 'float_at'}(thread * INPUTS + {len(inputs) + part})"
            for part in range(flat.shape[1])
        ]
        inputs += [
            flat[:, part].astype(np.int32).view(np.uint32)
            if whole
            else flat[:, part].astype(np.float32).view(np.uint32)
            for part in range(flat.shape[1])
        ]
        if column.ndim > 1:
            kind = Tuple((kind,) * flat.shape[1])
        glsl = translator.glsl_type(kind)
        loads.append(f"    {glsl} a{index} = {glsl}({', '.join(reads)});")
        arguments.append(Value(kind, f"a{index}"))
    native = translator.natives.get(inspect.unwrap(kernel))
    if native is not None:
        name, kind = native.name, native.result
    else:
        name, value = translator.function(kernel, arguments)
        kind = value.type
    outputs = _parts(kind, "found")
    members = "".join(f" int {name};" for name in sorted(tables.used_scalars))
    rows = len(columns[0])
    source = "\n".join(
        [
            "#version 430 core",
            "layout(local_size_x = 64) in;",
            f"#define INPUTS {len(inputs)}",
            f"layout(std140, binding = 0) uniform Scene {{{members} int rows; }} scene;",
            packed_scene.glsl("maths.glsl"),
            *codegen_glsl.helpers("angle"),
            packed_scene.glsl("words.glsl"),
            packed_scene.glsl("hashing.glsl"),
            translator.structure_source(),
            *translator.globals,
            *translator.functions,
            "layout(std430, binding = 1) writeonly buffer Found { float found_numbers[]; };",
            "void main()",
            "{",
            "    int thread = int(gl_GlobalInvocationID.x);",
            "    if (thread >= scene.rows) {",
            "        return;",
            "    }",
            *loads,
            f"    {translator.glsl_type(kind)} found = {name}({', '.join(argument.text for argument in arguments)});",
            *(
                f"    found_numbers[thread * {len(outputs)} + {index}] = float({part});"
                for index, part in enumerate(outputs)
            ),
            "}",
            "",
        ]
    )
    words = np.stack(inputs, axis=1).ravel()
    starts = {}
    for name, table in samplers.TABLES.items():
        starts[f"{name}_start"], starts[f"{name}_rows"] = len(words), len(table)
        words = np.concatenate([words, table])
    uniforms = np.array([*(starts[name] for name in sorted(tables.used_scalars)), rows], np.int32)
    uniforms = np.pad(uniforms, (0, -len(uniforms) % 4))

    def run(context):
        shader = found.program(context, source)
        buffers = context.buffer(uniforms), context.buffer(words), context.buffer(reserve=4 * rows * len(outputs))
        buffers[0].bind_to_uniform_block(0)
        for binding, buffer in enumerate(buffers[1:]):
            buffer.bind_to_storage_buffer(binding)
        shader.run(-(-rows // GROUP))
        values = np.frombuffer(buffers[2].read(), np.float32).reshape(rows, len(outputs)).astype(np.float64)
        for buffer in buffers:
            buffer.release()
        return values

    return found.submit(run).result()


_MAIN = """
layout(local_size_x = GROUP) in;
layout(std430, binding = 1) buffer Numbers { float numbers[]; };
vec3 number(int place) { return vec3(numbers[place], numbers[place + 1], numbers[place + 2]); }
void main()
{
    int at = int(gl_GlobalInvocationID.x) * INPUTS;
    clear_workspace();
    choose_noted_lamp(int(gl_GlobalInvocationID.x));
    RESULT found = NAME(ARGUMENTS);
    OUTPUTS
    write_lengths();
}
"""


def with_lamp(
    kernel, shape, numbers: np.ndarray, sampling: LampSampling = LampSampling.CUT
) -> tuple[np.ndarray, np.ndarray]:
    """(n, k) numbers that a kernel gives for block, workspace and the vectors in the rows of ``numbers`` (n, 3 ·
    vectors), in a scene with one lamp; and what was noted of its lengths (2,): unresolved, and inside. n is a multiple
    of ``GROUP``."""
    found = device_or_skip()
    scene = scenes.SCENES["torus_room"](8, 6)
    scene.lamps = [dataclasses.replace(scene.lamps[0], shape=shape, matrix=np.eye(4))]
    scene.settings.lamp_sampling, scene.settings.max_bounces = sampling, 0  # else the GPU has no cuts
    packed = packed_scene.GpuScene(scene, Film(scene, ()), found.software)
    assert packed.cuts == (sampling is LampSampling.CUT)
    translator = packed.translator()
    given = [f"number(at + {place})" for place in range(0, numbers.shape[1], 3)]
    name, value = translator.function(
        kernel, [known(BLOCK), known(WORKSPACE), *(Value(VECTOR, text) for text in given)]
    )
    parts = _parts(value.type, "found")
    assert len(parts) <= numbers.shape[1]
    main = _MAIN
    for word, text in {
        "INPUTS": str(numbers.shape[1]),
        "RESULT": translator.glsl_type(value.type),
        "NAME": name,
        "ARGUMENTS": ", ".join(given),
        "OUTPUTS": " ".join(f"numbers[at + {index}] = {part};" for index, part in enumerate(parts)),
    }.items():
        main = main.replace(word, text)
    source = packed.assembled(translator, main)
    words, second, uniforms = packed.tables.pack(packed.scalars)

    def run(context):
        shader = found.program(context, source)
        buffers = [
            context.buffer(np.ascontiguousarray(array).tobytes())
            for array in (words, numbers.astype(np.float32), np.zeros(1, np.uint32), np.zeros(2, np.float32), second)
        ]
        own = context.buffer(reserve=4 * max(packed.tables.arrays.words, 1) * len(numbers))
        for binding in thread_arrays.KINDS.values():
            own.bind_to_storage_buffer(binding)
        block = context.buffer(uniforms.tobytes())
        block.bind_to_uniform_block(0)
        for binding, buffer in enumerate(buffers):
            buffer.bind_to_storage_buffer(binding)
        shader.run(len(numbers) // packed.group)
        values = np.frombuffer(buffers[1].read(), np.float32).reshape(numbers.shape)[:, : len(parts)].astype(float)
        lengths = np.frombuffer(buffers[3].read(), np.float32).astype(float)
        for buffer in (*buffers, block, own):
            buffer.release()
        return values, lengths

    return found.submit(run).result()


def on_cpu(kernel, *columns: np.ndarray) -> np.ndarray:
    """The same by the CPU's kernel, in float64 from arguments that are rounded to float32."""
    rows = []
    for row in zip(*columns):
        rows.append(_flat(kernel(*(tuple(map(_rounded, item)) if np.ndim(item) else _rounded(item) for item in row))))
    return np.array(rows)


def _rounded(number):
    return int(number) if isinstance(number, (int, np.integer)) else float(np.float32(number))


_LOOK_UP = """
layout(local_size_x = 64) in;
layout(std430, binding = 1) buffer Numbers { float numbers[]; };
void main()
{
    int at = int(gl_GlobalInvocationID.x) * 4;
    vec4 found = NAME(PLACE, numbers[at], numbers[at + 1]);
    for (int channel = 0; channel < 4; channel++) {
        numbers[at + channel] = found[channel];
    }
}
"""


def with_textures(images: list, looked_up: list, place: int, uv: np.ndarray) -> np.ndarray:
    """(n, 4) RGBA of a texture of ``looked_up`` at uv (n, 2), of these images."""
    found = device_or_skip()
    scene = scenes.SCENES["textured"](8, 6)
    scene.images, scene.materials = images, []
    tables = textures.pack_textures(scene, looked_up)
    del tables["decoding"]
    tables |= gpu_images.placed(images, tables["images"])
    packed = Tables({**samplers.TABLES, **tables}, {}, frozenset(), {})
    translator = Translator(
        packed, replacements.together(replacements.ALWAYS, replacements.WITH_BOXES), replacements.ROUNDING
    )
    arguments = [Value(FLOAT, "place"), Value(FLOAT, "u"), Value(FLOAT, "v")]
    name, _ = translator.function(textures.texture_lookup, [known(BLOCK), known(WORKSPACE), *arguments])
    main = _LOOK_UP.replace("NAME", name).replace("PLACE", f"{place}.0")
    source = "\n".join(
        [
            "#version 430 core",
            packed.uniform_source(),
            packed_scene.glsl("maths.glsl"),
            packed.buffer_source(),
            *codegen_glsl.helpers("angle"),
            packed_scene.glsl("words.glsl"),
            packed_scene.glsl("hashing.glsl"),
            translator.structure_source(),
            *translator.globals,
            *translator.functions,
            main,
        ]
    )
    words, _, uniforms = packed.pack({})
    numbers = np.zeros((-(-len(uv) // GROUP) * GROUP, 4), np.float32)
    numbers[: len(uv), :2] = uv

    def run(context):
        shader = found.program(context, source)
        buffers = [context.buffer(np.ascontiguousarray(array).tobytes()) for array in (words, numbers)]
        block = context.buffer(uniforms.tobytes())
        block.bind_to_uniform_block(0)
        for binding, buffer in enumerate(buffers):
            buffer.bind_to_storage_buffer(binding)
        shader.run(len(numbers) // GROUP)
        values = np.frombuffer(buffers[1].read(), np.float32).reshape(numbers.shape).astype(float)
        for buffer in (*buffers, block):
            buffer.release()
        return values

    return found.submit(run).result()[: len(uv)]
