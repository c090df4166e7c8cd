# SPDX-FileCopyrightText: 2026 SDF Lights authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's images: the pixels that a texture shows, and their source.

OpenImageIO reads files in their own type, so Blender need not load them. Packed files are read from a temporary copy.
Blender returns its own pixels as floats. They are used only without a file: for generated and painted images, movies,
and formats that OpenImageIO does not know.
"""

from __future__ import annotations

import contextlib
import os
import re
import tempfile
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor

import bpy
import numpy as np

from ...render import memory
from ...render.images import Image, Texture, reduced
from ...render.scene import Scene
from .colorspaces import OTHER, SRGB, UNKNOWN, conversion, kind_of
from .common import Warnings
from .kept import Kept
from .pixels import File, Form, exists

# From 5.1 on, Cycles uses only the image's setting; before, the alpha information of the file.
_SETTING_DECIDES = bpy.app.version >= (5, 1, 0)

_TILE_TOKENS = {
    "<UDIM>": lambda tile: f"{tile:04d}",
    "<UVTILE>": lambda tile: f"u{(tile - 1001) % 10 + 1}_v{(tile - 1001) // 10 + 1}",
}

FILE, PACKED, BLENDER = "file", "packed", "Blender"  # source of the pixels

MOST_OF_MEMORY = 0.5  # fraction of the free memory for pixels of images
GENERATED_BYTES = 4 + 16  # bytes of a pixel made by Blender: at least its own copy, and the returned floats
CHUNK = 1 << 20  # number of Blender's floats that are converted to bytes at a time


class Images:
    """Adds each image to the scene once; each frame of a sequence and each tile counts separately. ``frame`` is the
    scene's.

    Files are read together at the end: see ``load``.
    """

    def __init__(
        self,
        scene: Scene,
        warn: Warnings,
        frame: int = 1,
        limit: int = 0,
        share: float | None = None,
        kept: Kept | None = None,
    ):
        """``limit`` and ``share``: see ``render.images.reduced``. ``kept``: pixels that need not be read again."""
        self._kept = kept
        self._scene, self._warn, self._frame = scene, warn, frame
        self._limit, self._share, self._reduced = limit, share, len(scene.images)
        self._known: dict[tuple, int | None] = {}
        self._bytes = 0  # of the pixels of all images
        self._pending: list[Callable[[], str | None]] = []

    def index(self, image: bpy.types.Image, user: bpy.types.ImageUser | None = None) -> int | None:
        """Index of the image in the scene, at the frame of ``user``. For tiles, the index of the first. None if it is
        missing."""
        texture = self.texture(image, user)
        return texture.tiles[0][1] if texture.tiles else texture.image

    def texture(
        self,
        image: bpy.types.Image | None,
        user: bpy.types.ImageUser | None = None,
        *,
        interpolation: str = "Linear",
        extension: str = "REPEAT",
        alpha: bool = False,
        tiled: bool = True,
    ) -> Texture:
        """How a node looks up ``image``. ``alpha``: whether its Alpha output is used, which makes colours straight.
        ``tiled``: off for box projections, which use only the first tile."""
        if image is None:
            return Texture()
        # The original has the last painted or generated pixels; evaluated copies share them or have none.
        image = image.original or image
        straight = alpha and image.alpha_mode in {"STRAIGHT", "PREMUL"} and not image.colorspace_settings.is_data
        tiles, index = (), None
        if image.source == "TILED":
            numbers = [tile.number for tile in image.tiles] if tiled else [1001]
            found = [(number, self._index(image, user, number)) for number in numbers]
            tiles = tuple((number, index) for number, index in found if index is not None)
            if not tiled:
                index, tiles = dict(tiles).get(1001), ()
        else:
            index = self._index(image, user, 0)
        return Texture(index, interpolation, extension, straight, tiles)

    def load(self) -> None:
        """Read the files of all images, several at a time."""
        jobs, self._pending = self._pending, []
        if jobs:
            with ThreadPoolExecutor(min(len(jobs), os.cpu_count() or 1)) as pool:
                for sentence in pool.map(lambda job: job(), jobs):
                    if sentence:
                        self._warn(sentence)
        for image in self._scene.images[self._reduced :]:
            image.pixels = reduced(image.pixels, self._limit, self._share)
        self._reduced = len(self._scene.images)

    def _index(self, image: bpy.types.Image, user, tile: int) -> int | None:
        frame = frame_of(image, user, self._frame)
        key = image.as_pointer(), frame, tile
        if key not in self._known:
            made = self._image(image, frame, tile)
            if made is not None:
                self._scene.images.append(made)
            self._known[key] = None if made is None else len(self._scene.images) - 1
        return self._known[key]

    def _image(self, image: bpy.types.Image, frame: int, tile: int) -> Image | None:
        """The image. Its pixels may be read later."""
        if image.source == "VIEWER":
            self._warn(
                f"Image '{image.name}' is an internal picture of Blender, which cannot be a texture: it is shown in "
                "magenta; save it, and use the file."
            )
            return None
        if kind_of(image.colorspace_settings) == UNKNOWN:
            self._warn(
                f"Image '{image.name}' is in the color space {image.colorspace_settings.name}, which cannot be "
                "converted here: it is read as sRGB; choose another color space."
            )
        if not _in_memory_only(image):
            packed = _packed_file(image, tile)
            path = "" if packed else path_of(image, frame, tile)
            if packed is None and not exists(path):
                self._warn(
                    f"Image '{image.name}' has no pixels ({path or 'no file'}): it is shown in magenta; "
                    "find the file with File > External Data > Find Missing Files."
                )
                return None
            made = self._from_file(image, path, packed)
            if made is not None:
                return made
        return self._from_blender(image, frame, tile)

    def _from_file(self, image: bpy.types.Image, path: str, packed) -> Image | None:
        """An image whose pixels ``load`` will read; None if OpenImageIO cannot read the file, or would give different
        pixels."""
        data = None
        if packed is not None:
            path, data = image.filepath, bytes(packed.data)
        try:
            with _file_with(path, data) as copy:
                file = File(copy)
        except (ImportError, OSError):
            return None
        if packed is not None and file.dtype == np.uint8 and image.alpha_mode == "PREMUL" and file.channels == 4:
            return None  # Blender may or may not have divided them by alpha, and Cycles shows what Blender has
        form, encoded = _form(image, FILE if packed is None else PACKED, file)
        needed = form.channels(file.channels) * form.dtype(file.dtype).itemsize
        if not self._fits(image, file.width, file.height, needed):
            return Image(image.name, np.zeros((0, 0, 4), np.uint8))
        made = Image(image.name, np.zeros((0, 0, 4), np.uint8), encoded)

        def read() -> str | None:
            def pixels() -> np.ndarray:
                with _file_with(path, data) as copy:
                    return File(copy).read(form)

            try:
                made.pixels = pixels() if self._kept is None else self._kept.pixels(path, data, form, pixels)
            except (OSError, MemoryError) as error:
                return (
                    f"Image '{made.name}' could not be read ({error or 'no memory'}): it is shown in magenta; "
                    "save its file again."
                )
            return None

        self._pending.append(read)
        return made

    def _fits(self, image: bpy.types.Image, width: int, height: int, each: int) -> bool:
        """Whether there is memory for so many pixels of ``each`` bytes, in addition to the images so far; else adds a
        warning."""
        free = memory.available()
        if free is None or self._bytes + width * height * each <= MOST_OF_MEMORY * free:
            self._bytes += width * height * each
            return True
        self._warn(
            f"Image '{image.name}' has {width:,} × {height:,} pixels, which take "
            f"{memory.in_words(width * height * each)}, but only {memory.in_words(free)} of memory are free: it is "
            "shown in magenta; make it smaller."
        )
        return False

    def _from_blender(self, image: bpy.types.Image, frame: int, tile: int) -> Image | None:
        """An image of Blender's own pixels."""
        if image.source == "GENERATED" and not image.is_dirty:
            if not self._fits(image, image.generated_width, image.generated_height, GENERATED_BYTES):
                return Image(image.name, np.zeros((0, 0, 4), np.uint8))
        if tile:
            return self._from_saved_tile(image, tile)
        with _at_frame(image, frame):
            count, (width, height) = len(image.pixels), image.size  # reading pixels loads them, which sets the size
            if not count or not width or not height:
                self._warn(
                    f"Image '{image.name}' has no pixels ({image.filepath or 'no file'}): it is shown in magenta; "
                    "find the file with File > External Data > Find Missing Files."
                )
                return None
            numbers = np.empty(count, np.float32)
            image.pixels.foreach_get(numbers)
        stored = count // (width * height)
        numbers = numbers.reshape(height, width, stored)
        if image.is_float:
            # Blender has already converted floats to scene-linear.
            multiplies = _SETTING_DECIDES and image.alpha_mode == "STRAIGHT" and not image.colorspace_settings.is_data
            form, encoded = Form(drops_alpha=image.alpha_mode == "NONE", multiplies=int(multiplies)), False
        else:
            form, encoded = _form(image, BLENDER, None)
            numbers = _as_bytes(numbers)
        bad = numbers.dtype.kind == "f" and not np.isfinite(numbers).all()
        if bad:
            self._warn(
                f"Image '{image.name}' has pixels that are not finite numbers: they are read as 0; correct the image."
            )
        rows = max(CHUNK // (width * stored), 1)
        pixels = np.empty((height, width, form.channels(stored)), form.dtype(numbers.dtype))
        for first in range(0, height, rows):
            pixels[first : first + rows] = form.apply(numbers[first : first + rows])
        return Image(image.name, pixels, encoded)

    def _from_saved_tile(self, image: bpy.types.Image, tile: int) -> Image | None:
        """A generated or painted tile. Only the first tile's pixels can be read directly, but all tiles can be
        saved."""
        with tempfile.TemporaryDirectory() as folder:
            with contextlib.suppress(RuntimeError):  # one tile without pixels makes this fail
                image.save(filepath=os.path.join(folder, "<UDIM>"), save_copy=True)
            found = [entry.path for entry in os.scandir(folder) if entry.name.startswith(f"{tile:04d}")]
            try:
                file = File(found[0])
                form, encoded = _form(image, BLENDER, file)
                return Image(image.name, file.read(form), encoded)
            except (ImportError, IndexError, OSError):
                self._warn(
                    f"Image '{image.name}' has no pixels for tile {tile}, which is shown in magenta: save the "
                    "image, or fill the tile."
                )
                return None


def _form(image: bpy.types.Image, source: str, file: File | None) -> tuple[Form, bool]:
    """How an image's pixels are stored, and whether they stay encoded. ``file`` is None for Blender's own bytes.

    Cycles reads files itself. It gets packed images from Blender. Blender returns all that is finer than bytes as
    floats, scene-linear and multiplied by alpha; bytes are not multiplied. From 5.1 on, Cycles multiplies those floats
    once more.
    """
    settings, mode = image.colorspace_settings, image.alpha_mode
    kind = kind_of(settings)
    if kind == UNKNOWN:
        kind = SRGB
    uses_alpha = not settings.is_data and mode in {"STRAIGHT", "PREMUL"}
    is_fine = source != FILE and file is not None and file.dtype != np.uint8
    if source == FILE and file.stored_channels != 4:  # Cycles does not multiply grey with alpha
        by_cycles = False
    elif _SETTING_DECIDES:
        by_cycles = mode == "STRAIGHT"
    else:
        by_cycles = file.alpha_is_straight if source == FILE else not is_fine
    by_blender = is_fine and mode == "STRAIGHT"
    multiplies = by_cycles + by_blender if uses_alpha else 0
    converted = kind == OTHER or kind == SRGB and is_fine
    form = Form(
        drops_alpha=mode == "NONE",
        multiplies=multiplies,
        associated=uses_alpha and not multiplies,
        conversion=conversion(settings) if converted else None,
    )
    return form, kind == SRGB and not converted


def _in_memory_only(image: bpy.types.Image) -> bool:
    """Whether the valid pixels are Blender's own, and in no file."""
    if image.source == "FILE":
        return image.is_dirty
    if image.source == "TILED":
        return image.is_dirty or any(tile.is_generated_tile for tile in image.tiles)
    return image.source in {"GENERATED", "MOVIE"}


def _packed_file(image: bpy.types.Image, tile: int) -> bpy.types.PackedFile | None:
    for packed in image.packed_files:
        if packed.packed_file is not None and (not tile or packed.tile_number == tile):
            return packed.packed_file
    return None


@contextlib.contextmanager
def _file_with(path: str, data: bytes | None) -> Iterator[str]:
    """Path of a file: the given one, or a temporary one of the same type with ``data``."""
    if data is None:
        yield path
        return
    with tempfile.TemporaryDirectory() as folder:
        copy = os.path.join(folder, "packed" + os.path.splitext(path)[1])
        with open(copy, "wb") as file:
            file.write(data)
        yield copy


def _as_bytes(numbers: np.ndarray) -> np.ndarray:
    """Blender's floats of a byte image, as bytes."""
    flat = numbers.reshape(-1)
    result = np.empty(flat.size, np.uint8)
    for first in range(0, flat.size, CHUNK):
        result[first : first + CHUNK] = flat[first : first + CHUNK] * np.float32(255.0) + np.float32(0.5)
    return result.reshape(numbers.shape)


def frame_of(image: bpy.types.Image, user: bpy.types.ImageUser | None, frame: int) -> int:
    """Frame number of a movie or sequence that a node shows at the scene's ``frame``; 0 for other images."""
    if image.source not in {"MOVIE", "SEQUENCE"} or user is None or not user.frame_duration:
        return 0
    count, place = user.frame_duration, frame - user.frame_start + 1
    if user.use_cyclic:
        place = place % count or count
    return min(max(place, 0), count) + user.frame_offset


def path_of(image: bpy.types.Image, frame: int, tile: int) -> str:
    """Absolute path of the file of a frame or a tile of an image."""
    path = bpy.path.abspath(image.filepath, library=image.library)
    if tile:
        for token, text in _TILE_TOKENS.items():
            path = path.replace(token, text(tile))
    if image.source == "SEQUENCE":
        folder, name = os.path.split(path)
        stem, extension = os.path.splitext(name)
        digits = re.fullmatch(r"(.*?)(\d+)(\D*)", stem, re.DOTALL)
        if digits:
            before, number, after = digits.groups()
            name = f"{before}{frame:0{len(number)}d}{after}{extension}"
            path = os.path.join(folder, name)
    return os.path.normpath(path) if path else ""


@contextlib.contextmanager
def _at_frame(image: bpy.types.Image, frame: int) -> Iterator[None]:
    """As long as this context lasts, a movie's pixels are those of one frame: the frame that any texture read last."""
    if image.source != "MOVIE":
        yield
        return
    texture = bpy.data.textures.new("SDF Lights movie", "IMAGE")
    try:
        texture.image = image
        texture.image_user.frame_duration = max(frame, 1)
        texture.image_user.frame_current = frame
        texture.evaluate((0.0, 0.0, 0.0))
        yield
    finally:
        bpy.data.textures.remove(texture)
