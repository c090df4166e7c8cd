# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Images as sync reads them and the reference looks them up, against what Cycles shows of them."""

import contextlib
import struct
import tracemalloc
import types
import zlib

import bpy
import numpy as np
import pytest

from sdf_lights.blender.sync.common import Warnings
from sdf_lights.blender.sync.images import Images, frame_of, path_of
from sdf_lights.render.kernels.textures import pack_textures
from sdf_lights.render.reference.images import lookup
from sdf_lights.render.scene import Scene

OpenImageIO = pytest.importorskip("OpenImageIO")

SIZE = 8  # of images
PIXELS = 26  # of pictures: their centres lie on no edge of a texel
LOW, HIGH = -0.62, 1.71  # texture coordinates of the picture's edges

RNG = np.random.default_rng(1)
COLORS = RNG.uniform(0.05, 0.95, (SIZE, SIZE, 4))
COLORS[..., 3] = RNG.choice([0.0, 0.4, 0.8, 1.0], (SIZE, SIZE))
OPAQUE = COLORS.copy()
OPAQUE[..., 3] = 1.0

# What two pictures may differ by: Cycles' samples lie up to 0.005 pixels off the centre, and its half floats are
# rounded.
CLOSE = dict(abs=6e-3, rel=2e-3)


def saved(path, pixels, kind: str = "uint8", **attributes) -> str:
    """An image file of these pixels (height, width, channels), row 0 at the bottom, as they are."""
    height, width, channels = pixels.shape
    specification = OpenImageIO.ImageSpec(width, height, channels, kind)
    specification["oiio:UnassociatedAlpha"] = 1
    for name, value in attributes.items():
        specification[name.replace("_", ":", 1)] = value
    output = OpenImageIO.ImageOutput.create(str(path))
    assert output.open(str(path), specification), OpenImageIO.geterror()
    assert output.write_image(np.ascontiguousarray(pixels[::-1], np.float32)), output.geterror()
    output.close()
    return str(path)


def associated(pixels):
    """Colours times alpha: what would be divided by less than it is else gets too steep to be compared."""
    return np.concatenate([pixels[..., :3] * pixels[..., 3:], pixels[..., 3:]], axis=2)


def load(path, **settings):
    image = bpy.data.images.load(str(path))
    for name, value in settings.items():
        if name == "space":
            image.colorspace_settings.name = value
        else:
            setattr(image, name, value)
    return image


@pytest.fixture
def shown(file, add, quad, material):
    """Function: RGB of an image texture (and times Alpha, where ``alpha``) as sync and the reference give it, and as
    Cycles renders it; and what sync warned of. ``settings`` are those of the node, ``user`` those of its image user."""
    pytest.importorskip("_cycles")
    bpy.ops.preferences.addon_enable(module="cycles")
    scene = file.scene
    made, tree, output = material()
    data = quad()
    data.uv_layers[0].uv.foreach_set("vector", [LOW, LOW, HIGH, LOW, HIGH, HIGH, LOW, HIGH])
    data.materials.append(made)
    add("Quad", data)
    file.camera.location, file.camera.rotation_euler = (0.0, 0.0, 5.0), (0.0, 0.0, 0.0)
    file.camera.data.type, file.camera.data.ortho_scale = "ORTHO", 2.0
    scene.render.resolution_x = scene.render.resolution_y = PIXELS

    def run(image, alpha: bool = False, user=None, **settings):
        tree.nodes.clear()
        output = tree.nodes.new("ShaderNodeOutputMaterial").inputs["Surface"]
        node, emission = tree.nodes.new("ShaderNodeTexImage"), tree.nodes.new("ShaderNodeEmission")
        node.image = image
        for name, value in settings.items():
            setattr(node, name, value)
        for name, value in (user or {}).items():
            setattr(node.image_user, name, value)
        tree.links.new(node.outputs["Color"], emission.inputs["Color"])
        if alpha:
            tree.links.new(node.outputs["Alpha"], emission.inputs["Strength"])
        tree.links.new(emission.outputs[0], output)
        known = Scene(None, 1, 1)
        images = Images(known, Warnings(known.warnings), scene.frame_current)
        texture = images.texture(
            node.image, node.image_user, interpolation=node.interpolation, extension=node.extension, alpha=alpha
        )
        images.load()
        centers = LOW + (np.arange(PIXELS) + 0.5) / PIXELS * (HIGH - LOW)
        u, v = np.meshgrid(centers, centers)
        rgba = lookup(known.images, texture, u.ravel(), v.ravel()).reshape(PIXELS, PIXELS, 4)
        return types.SimpleNamespace(
            read=rgba[..., :3] * rgba[..., 3:] if alpha else rgba[..., :3],
            picture=rendered(scene),
            rgba=rgba,
            images=known.images,
            texture=texture,
            warnings=known.warnings,
        )

    return run


def rendered(scene, engine: str = "CYCLES") -> np.ndarray:
    """RGB of a picture of one sample a pixel, row 0 at the bottom."""
    scene.render.engine, cycles = engine, scene.cycles
    cycles.samples, cycles.use_denoising, cycles.filter_width, cycles.pixel_filter_type = (
        1,
        False,
        0.01,
        "BLACKMAN_HARRIS",
    )
    settings = scene.render.image_settings
    with contextlib.suppress(AttributeError):  # new in 5.0
        settings.media_type = "IMAGE"
    settings.file_format, settings.color_depth = "OPEN_EXR", "32"
    scene.render.filepath = bpy.app.tempdir + "picture.exr"
    bpy.ops.render.render(write_still=True)
    picture = OpenImageIO.ImageBuf(scene.render.filepath).get_pixels(OpenImageIO.FLOAT)
    return picture[::-1, :, :3]


def check(found) -> None:
    assert found.warnings == []
    assert np.ptp(found.read) > 0.3
    assert found.read == pytest.approx(found.picture, **CLOSE)


# -- look-ups ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("extension", ["REPEAT", "EXTEND", "CLIP", "MIRROR"])
@pytest.mark.parametrize("interpolation", ["Linear", "Closest", "Cubic", "Smart"])
def test_interpolation_and_extension(shown, tmp_path, interpolation, extension):
    image = load(saved(tmp_path / "image.png", COLORS))
    check(shown(image, interpolation=interpolation, extension=extension))
    check(shown(image, alpha=True, interpolation=interpolation, extension=extension))


# -- files -------------------------------------------------------------------------------------------------------------

FILES = [("png", "uint8"), ("png", "uint16"), ("exr", "half"), ("exr", "float"), ("tif", "uint8"), ("tga", "uint8")]


@pytest.mark.parametrize(
    "space, alpha",
    [
        ("sRGB", True),
        ("Non-Color", False),
        ("Non-Color", True),
        ("Linear Rec.709", True),
        ("Display P3", False),
        ("ACES2065-1", True),
    ],
)
@pytest.mark.parametrize("suffix, kind", FILES[:4])
def test_colour_spaces(shown, tmp_path, suffix, kind, space, alpha):
    colors = associated(COLORS) if suffix == "exr" else COLORS
    image = load(saved(tmp_path / f"image.{suffix}", colors, kind), space=space)
    check(shown(image, alpha))


@pytest.mark.parametrize("mode", ["STRAIGHT", "PREMUL", "CHANNEL_PACKED", "NONE"])
@pytest.mark.parametrize("suffix, kind", FILES[:3] + FILES[5:])
@pytest.mark.parametrize("alpha", [False, True])
def test_alpha_modes(shown, tmp_path, suffix, kind, mode, alpha):
    colors = associated(COLORS) if mode == "PREMUL" or suffix == "exr" else COLORS
    image = load(saved(tmp_path / f"image.{suffix}", colors, kind), alpha_mode=mode, space="sRGB")
    check(shown(image, alpha))


@pytest.mark.parametrize("mode", ["STRAIGHT", "PREMUL", "CHANNEL_PACKED", "NONE"])
@pytest.mark.parametrize("alpha", [False, True])
def test_alpha_of_converted_images(shown, tmp_path, mode, alpha):
    if mode == "CHANNEL_PACKED" and bpy.app.version < (5, 0, 0):
        pytest.skip("this Cycles divides packed channels by each other when it converts colours")
    colors = associated(COLORS) if mode == "PREMUL" else COLORS
    image = load(saved(tmp_path / "image.png", colors), alpha_mode=mode, space="Display P3")
    check(shown(image, alpha))


@pytest.mark.parametrize("channels", [1, 2, 3, 4])
@pytest.mark.parametrize("suffix, kind", FILES[:4])
def test_channels(shown, tmp_path, suffix, kind, channels):
    pixels = np.maximum(COLORS, 0.4)[..., (0, 3)] if channels == 2 else associated(COLORS)[..., :channels]
    image = load(saved(tmp_path / f"image.{suffix}", pixels, kind))
    for alpha in False, True:
        found = shown(image, alpha, extension="CLIP")
        check(found)
        assert found.images[0].pixels.shape[2] == {2: 4}.get(channels, channels)


def test_layers_of_an_exr_file(shown, tmp_path):
    more = np.concatenate([COLORS, 1.0 - COLORS], axis=2)
    check(shown(load(saved(tmp_path / "image.exr", more, "half"))))


def test_tiled_and_compressed_files(shown, tmp_path):
    pixels = np.repeat(np.repeat(OPAQUE, 6, 0), 5, 1)
    specification = OpenImageIO.ImageSpec(40, 48, 4, "uint8")
    specification.tile_width = specification.tile_height = 16
    output = OpenImageIO.ImageOutput.create("tiled.tif")
    output.open(str(tmp_path / "tiled.tif"), specification)
    output.write_image(np.ascontiguousarray(pixels[::-1], np.float32))
    output.close()
    check(shown(load(tmp_path / "tiled.tif")))
    check(shown(load(saved(tmp_path / "image.jpg", pixels[..., :3]))))
    check(shown(load(saved(tmp_path / "grey.jpg", pixels[..., :1]))))


def test_palettes(shown, tmp_path):
    def chunk(name: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))

    palette = RNG.integers(0, 256, (16, 3), np.uint8)
    rows = RNG.integers(0, 16, (SIZE, SIZE), np.uint8)
    (tmp_path / "image.png").write_bytes(
        b"\x89PNG\r\n\x1a\n"
        + chunk(b"IHDR", struct.pack(">IIBBBBB", SIZE, SIZE, 8, 3, 0, 0, 0))
        + chunk(b"PLTE", palette.tobytes())
        + chunk(b"IDAT", zlib.compress(b"".join(b"\0" + row.tobytes() for row in rows)))
        + chunk(b"IEND", b"")
    )
    found = shown(load(tmp_path / "image.png"), interpolation="Closest")
    check(found)
    assert np.array_equal(found.images[0].pixels, palette[rows[::-1]])


def test_inks(shown, tmp_path):
    check(shown(load(saved(tmp_path / "image.tif", COLORS, tiff_ColorSpace="CMYK"))))


def test_hdr_pictures(shown, tmp_path):
    found = shown(load(saved(tmp_path / "image.hdr", 4.0 * OPAQUE[..., :3], "float")))
    check(found)
    assert found.read.max() > 2.0 and found.images[0].pixels.dtype == np.float32


def test_files_stay_what_they_are(shown, tmp_path):
    for suffix, kind in FILES[:4]:
        pixels = shown(load(saved(tmp_path / f"image.{suffix}", COLORS, kind))).images[0].pixels
        assert pixels.dtype.name == {"half": "float16", "float": "float32"}.get(kind, kind)


# -- where pixels come from --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("suffix, kind", FILES[:3])
@pytest.mark.parametrize("mode", ["STRAIGHT", "PREMUL", "CHANNEL_PACKED", "NONE"])
@pytest.mark.parametrize("alpha", [False, True])
def test_packed(shown, tmp_path, suffix, kind, mode, alpha):
    path = tmp_path / f"image.{suffix}"
    colors = associated(COLORS) if mode == "PREMUL" or suffix == "exr" else COLORS
    image = load(saved(path, colors, kind), alpha_mode=mode)
    image.pack()
    path.unlink()
    check(shown(image, alpha))


@pytest.mark.parametrize("space", ["sRGB", "Non-Color", "Display P3"])
@pytest.mark.parametrize("suffix, kind", FILES[:3])
def test_packed_colour_spaces(shown, tmp_path, suffix, kind, space):
    image = load(saved(tmp_path / f"image.{suffix}", COLORS, kind), space=space)
    image.pack()
    check(shown(image))


@pytest.mark.parametrize("kind", ["BLANK", "UV_GRID", "COLOR_GRID"])
@pytest.mark.parametrize("is_float", [False, True])
def test_generated(shown, kind, is_float):
    image = bpy.data.images.new("Generated", 64, 32, alpha=True, float_buffer=is_float)
    image.generated_type, image.generated_color = kind, (0.2, 0.5, 0.9, 0.7)
    for alpha in False, True:
        found = shown(image, alpha)
        assert found.warnings == [] and found.read == pytest.approx(found.picture, **CLOSE)
        assert found.images[0].pixels.dtype == (np.float32 if is_float else np.uint8)


@pytest.mark.parametrize("mode", ["STRAIGHT", "PREMUL", "CHANNEL_PACKED", "NONE"])
@pytest.mark.parametrize("is_float", [False, True])
def test_painted(shown, mode, is_float):
    image = bpy.data.images.new("Painted", SIZE, SIZE, alpha=True, float_buffer=is_float)
    image.alpha_mode = mode
    image.pixels.foreach_set((associated(COLORS) if mode == "PREMUL" else COLORS).astype(np.float32).ravel())
    for alpha in False, True:
        check(shown(image, alpha))


def test_paint_on_a_file_is_seen_before_it_is_saved(shown, tmp_path):
    image = load(saved(tmp_path / "image.png", OPAQUE))
    image.pixels.foreach_set(OPAQUE[::-1].astype(np.float32).ravel())
    found = shown(image, interpolation="Closest")
    assert found.images[0].pixels == pytest.approx(OPAQUE[::-1] * 255.0, abs=0.51)


def test_files_are_not_loaded_by_blender(shown, tmp_path):
    image = load(saved(tmp_path / "image.png", COLORS))
    known = Scene(None, 1, 1)
    images = Images(known, Warnings(known.warnings))
    images.texture(image, alpha=True)
    images.load()
    assert known.images[0].pixels.size and not image.has_data


def test_an_image_is_read_once(tmp_path):
    image = load(saved(tmp_path / "image.png", COLORS))
    known = Scene(None, 1, 1)
    images = Images(known, Warnings(known.warnings))
    first, second = images.texture(image), images.texture(image, alpha=True, extension="CLIP")
    assert first.image == second.image == 0 and second.straight and not first.straight


# -- tiles and frames --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "token, names",
    [
        ("<UDIM>", {1001: "1001", 1002: "1002", 1011: "1011", 1012: "1012"}),
        ("<UVTILE>", {1001: "u1_v1", 1002: "u2_v1", 1011: "u1_v2", 1012: "u2_v2"}),
    ],
)
@pytest.mark.parametrize("extension", ["REPEAT", "CLIP"])
def test_udim_tiles(shown, tmp_path, token, names, extension):
    for place, (number, name) in enumerate(names.items()):
        saved(tmp_path / f"tile.{name}.png", np.roll(OPAQUE, place, axis=2 if place < 3 else 0))
    image = load(tmp_path / f"tile.{names[1001]}.png")
    image.source = "TILED"
    image.filepath = str(tmp_path / f"tile.{token}.png")
    for number in (1002, 1011, 1012):
        image.tiles.new(number)
    found = shown(image, extension=extension)
    check(found)
    assert len(found.images) == 4 and len(found.texture.tiles) == 4


def test_udim_tiles_that_are_missing(shown, tmp_path):
    saved(tmp_path / "tile.1001.png", OPAQUE)
    image = load(tmp_path / "tile.1001.png")
    image.source, image.filepath = "TILED", str(tmp_path / "tile.<UDIM>.png")
    image.tiles.new(1002)
    found = shown(image)
    assert found.read == pytest.approx(found.picture, **CLOSE)
    [warning] = found.warnings
    assert "tile.1002.png" in warning and "magenta" in warning


@pytest.mark.skipif(bpy.app.version < (5, 1, 0), reason="this Cycles loses tiles that are not in files")
def test_generated_udim_tiles(shown):
    image = bpy.data.images.new("Tiles", SIZE, SIZE, alpha=True, tiled=True)
    image.generated_color = (0.2, 0.5, 0.9, 1.0)
    image.pixels.foreach_set(OPAQUE.astype(np.float32).ravel())
    check(shown(image))


def sequence(tmp_path, frames=(1, 2, 3)):
    for frame in frames:
        saved(tmp_path / f"frame{frame:03d}.png", np.roll(OPAQUE, frame, axis=0))
    image = load(tmp_path / f"frame{frames[0]:03d}.png")
    image.source = "SEQUENCE"
    return image


@pytest.mark.parametrize("frame", [-1, 1, 3, 4, 5, 9])
@pytest.mark.parametrize(
    "user",
    [
        dict(frame_duration=3),
        dict(frame_duration=3, frame_start=3, use_cyclic=True),
        dict(frame_duration=2, frame_offset=1, frame_start=4),
        dict(frame_duration=3, use_auto_refresh=True),
    ],
)
def test_sequences(shown, file, tmp_path, frame, user):
    file.scene.frame_set(frame)
    found = shown(sequence(tmp_path), user=user)
    assert found.read == pytest.approx(found.picture, **CLOSE)
    missing = found.texture.image is None
    assert missing == bool(found.warnings) and (not missing or "frame00" in found.warnings[0])


def test_frames_of_a_sequence():
    user = types.SimpleNamespace(frame_duration=5, frame_start=11, frame_offset=100, use_cyclic=False)
    image = types.SimpleNamespace(source="SEQUENCE")
    assert [frame_of(image, user, frame) for frame in (1, 11, 13, 15, 40)] == [100, 101, 103, 105, 105]
    user.use_cyclic = True
    assert [frame_of(image, user, frame) for frame in (1, 10, 11, 15, 16)] == [101, 105, 101, 105, 101]
    assert frame_of(types.SimpleNamespace(source="FILE"), user, 13) == 0


def test_names_of_frames(tmp_path):
    image = types.SimpleNamespace(source="SEQUENCE", library=None, filepath=str(tmp_path / "shot2_img0098.v2.jp2"))
    assert path_of(image, 7, 0) == str(tmp_path / "shot2_img0098.v7.jp2")
    image.filepath = str(tmp_path / "a0098b.png")
    assert path_of(image, 12345, 0) == str(tmp_path / "a12345b.png")


@pytest.fixture
def movie(file, tmp_path):
    """A movie of three frames: red, green, blue."""
    if not bpy.app.ffmpeg.supported:
        pytest.skip("this Blender has no FFmpeg")
    scene = bpy.data.scenes.new("Movie")
    settings = scene.render.image_settings
    with contextlib.suppress(AttributeError):
        settings.media_type = "VIDEO"
    settings.file_format = "FFMPEG"
    scene.render.ffmpeg.format, scene.render.ffmpeg.codec = "AVI", "FFV1"
    scene.render.resolution_x = scene.render.resolution_y = 16
    scene.frame_end, scene.render.filepath = 3, str(tmp_path / "movie.avi")
    editor = scene.sequence_editor_create()
    strips = editor.strips if hasattr(editor, "strips") else editor.sequences
    for index, color in enumerate(np.eye(3)):
        end = dict(length=1) if bpy.app.version >= (5, 0, 0) else dict(frame_end=index + 2)
        strips.new_effect(name=str(index), type="COLOR", channel=1, frame_start=index + 1, **end).color = color
    bpy.ops.render.render(animation=True, scene=scene.name)
    return load(tmp_path / "movie.avi")


@pytest.mark.parametrize("frame", [1, 2, 3, 7])
def test_movies(shown, file, movie, frame):
    assert movie.source == "MOVIE"
    file.scene.frame_set(frame)
    count = len(bpy.data.textures)
    found = shown(movie, user=dict(frame_duration=3))
    assert found.read == pytest.approx(found.picture, **CLOSE) and found.warnings == []
    assert found.read[0, 0].argmax() == min(frame, 3) - 1
    assert len(bpy.data.textures) == count


# -- what cannot be shown ----------------------------------------------------------------------------------------------


def test_no_image_is_magenta(shown):
    found = shown(None)
    assert found.read == pytest.approx(found.picture) and found.read[0, 0].tolist() == [1.0, 0.0, 1.0]


def test_deleted_file_is_magenta_and_named(shown, tmp_path):
    image = load(saved(tmp_path / "image.png", COLORS))
    (tmp_path / "image.png").unlink()
    for extension in ("REPEAT", "CLIP") if bpy.app.version >= (5, 1, 0) else ("REPEAT",):
        found = shown(image, extension=extension)
        assert found.read == pytest.approx(found.picture)
        assert found.read[0, 0].tolist() == [1.0, 0.0, 1.0]
        [warning] = found.warnings
        assert f"'{image.name}'" in warning and "Find Missing Files" in warning


def test_damaged_files_are_named(shown, tmp_path):
    path = tmp_path / "image.png"
    image = load(saved(path, COLORS))
    path.write_bytes(path.read_bytes()[:100])
    [warning] = shown(image).warnings
    assert "'image.png'" in warning and "magenta" in warning
    path.write_bytes(b"no picture at all")
    [warning] = shown(image).warnings
    assert "'image.png'" in warning and "magenta" in warning


def test_pixels_that_are_not_numbers(shown):
    image = bpy.data.images.new("Broken", SIZE, SIZE, float_buffer=True)
    pixels = OPAQUE.astype(np.float32)
    pixels[0, 0, 0] = np.nan
    image.pixels.foreach_set(pixels.ravel())
    found = shown(image, interpolation="Closest")
    assert np.isfinite(found.rgba).all() and not found.images[0].pixels[0, 0].any()
    assert "'Broken'" in found.warnings[0]


def test_colour_spaces_that_are_not_known(tmp_path, monkeypatch):
    from sdf_lights.blender.sync import colorspaces

    monkeypatch.setattr(colorspaces, "_converted", lambda *arguments: None)
    colorspaces._kind.cache_clear()
    image = load(saved(tmp_path / "image.png", COLORS), space="Display P3")
    known = Scene(None, 1, 1)
    images = Images(known, Warnings(known.warnings))
    images.texture(image)
    images.load()
    colorspaces._kind.cache_clear()
    assert known.images[0].encoded and "Display P3" in known.warnings[0]


# -- memory ------------------------------------------------------------------------------------------------------------

MEGABYTE = 1 << 20


@pytest.mark.parametrize("channels, megabytes", [(1, 16), (3, 48), (4, 64)])
def test_a_map_of_bytes_takes_its_bytes(tmp_path, channels, megabytes):
    """At the peak, too, but for a few megabytes of the band that is being read."""
    ramp = np.arange(4096, dtype=np.uint8)
    pixels = np.repeat((ramp[:, None] ^ ramp)[..., None], channels, axis=2)
    output = OpenImageIO.ImageOutput.create(str(tmp_path / "image.png"))
    specification = OpenImageIO.ImageSpec(4096, 4096, channels, "uint8")
    specification["png:compressionLevel"] = 1
    output.open(str(tmp_path / "image.png"), specification)
    output.write_image(pixels)
    output.close()
    image = load(tmp_path / "image.png")
    known = Scene(None, 1, 1)
    images = Images(known, Warnings(known.warnings))
    tracemalloc.start()
    images.texture(image)
    images.load()
    held, peak = (amount / MEGABYTE for amount in tracemalloc.get_traced_memory())
    tracemalloc.stop()
    assert known.images[0].pixels.nbytes == megabytes * MEGABYTE
    assert held < megabytes + 1 and peak < megabytes + 8
    assert not image.has_data  # Blender has no copy of its own


def test_thirty_maps_take_the_memory_of_their_bytes(tmp_path):
    """Also where nodes look them up in different ways, and in the tables of kernels: 30 maps of 4K take 30 × 64 MB."""
    count, size = 30, 256
    for number in range(count):
        saved(tmp_path / f"{number}.png", RNG.random((size, size, 4)), png_compressionLevel=1)
    maps = [load(tmp_path / f"{number}.png") for number in range(count)]
    known = Scene(None, 1, 1)
    images = Images(known, Warnings(known.warnings))
    tracemalloc.start()
    textures = [
        images.texture(image, interpolation=interpolation) for interpolation in ("Linear", "Cubic") for image in maps
    ]
    images.load()
    tables = pack_textures(known, textures)
    held, _ = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    stored = count * size * size * 4
    assert len(known.images) == count and len(tables["textures"]) == 2 * count
    assert sum(image.pixels.nbytes for image in known.images) == stored
    assert held < stored + MEGABYTE // 4
    assert not any(image.has_data for image in maps)
