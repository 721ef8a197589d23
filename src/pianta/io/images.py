"""Images: grey levels, colours and transparency, and their meaning as a map without a YAML."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from math import isfinite
from pathlib import Path
from threading import Lock
from typing import TypeAlias, TypeVar

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageOps, UnidentifiedImageError

from pianta.errors import MapError
from pianta.gridmap import FREE, OCCUPIED, UNKNOWN, GridMap
from pianta.io._files import MAX_CELLS, check_cell_count, check_input_file, one_line_reason, short_repr

IMAGE_SUFFIXES = (".png", ".pgm", ".bmp", ".jpg", ".jpeg", ".tif", ".tiff", ".pbm", ".ppm", ".pnm")
PICTURE_SUFFIXES = (*IMAGE_SUFFIXES, ".gif", ".webp")
_FORMATS = ("PNG", "PPM", "BMP", "JPEG", "TIFF")
_PICTURE_FORMATS = (*_FORMATS, "GIF", "WEBP")

_PILLOW = Lock()

Pixels = TypeVar("Pixels")


@dataclass(frozen=True, eq=False)
class DecodedImage:
    """An image file with decoded pixels, so that several readers need not decode it again."""

    path: str | Path
    pixels: Image.Image


Source: TypeAlias = str | Path | DecodedImage


def path_of(source: Source) -> str | Path:
    """The path of an image."""
    return source.path if isinstance(source, DecodedImage) else source


def open_image(path: str | Path, *, max_cells: int = MAX_CELLS) -> DecodedImage:
    """Decode the first frame of an image; formats as of read_picture, errors as of read_grey."""

    def load(image: Image.Image) -> DecodedImage:
        image.load()
        return DecodedImage(path, image)

    return _decode_file(path, load, max_cells, formats=_PICTURE_FORMATS)


def read_image_map(
    path: Source,
    *,
    resolution: float,
    origin: tuple[float, float, float] = (0.0, 0.0, 0.0),
    free_above: int = 250,
    occupied_below: int = 150,
    max_cells: int = MAX_CELLS,
) -> GridMap:
    """Map from an image without a YAML: white is free, dark is occupied, grey or transparent is unknown.

    resolution: metres per cell. origin: x, y (m) and yaw (rad) of the lower-left corner.
    free_above: a grey above it is free; 250 is the value for the maps of the survey.
    occupied_below: a grey below it is occupied; 150 is the value at which the thesis' authors binarise.

    Raises MapError for a file that is no image, an image above max_cells, and, in one message, options out of range.
    """
    _check_options(resolution, origin, free_above, occupied_below)
    grey, transparent = read_grey(path, max_cells=max_cells)
    table = np.full(256, UNKNOWN, np.int8)
    table[:occupied_below] = OCCUPIED
    table[free_above + 1 :] = FREE
    cells = table[grey]
    if transparent is not None:
        cells[transparent] = UNKNOWN
    return GridMap(cells, resolution, origin, Path(path_of(path)).name)


def _check_options(resolution: float, origin: tuple[float, float, float], free_above: int, occupied_below: int) -> None:
    """Raise MapError that lists every option out of range."""
    faults = []
    if not (isfinite(resolution) and resolution > 0):
        faults.append(f"resolution is {resolution}, give positive metres per cell")
    if len(origin) != 3 or not all(isfinite(value) for value in origin):
        faults.append(f"origin is {origin}, give three finite numbers x, y, yaw")
    if not 0 <= occupied_below <= free_above <= 255:
        faults.append(
            f"occupied_below is {occupied_below} and free_above {free_above}, "
            f"give greys with 0 ≤ occupied_below ≤ free_above ≤ 255"
        )
    if faults:
        raise MapError("the image cannot become a map: " + "; ".join(faults))


def read_grey(path: Source, *, max_cells: int = MAX_CELLS) -> tuple[NDArray[np.uint8], NDArray[np.bool_] | None]:
    """Grey levels of an image file, shape (H, W), and a mask of pixels that are not fully opaque, None if all are.

    Reads the first frame of PNG, PGM, PPM, PBM, BMP, JPEG and TIFF. Colours become Rec. 601 luma and 16 bits become 8,
    both as in Nav2's GraphicsMagick.

    Raises MapError for other formats, for a damaged image, and for one of more than max_cells pixels, which is not
    decoded.
    """
    return _decode_file(path, _decode_grey, max_cells)


def read_colors(path: Source, *, max_cells: int = MAX_CELLS) -> NDArray[np.uint8]:
    """Red, green and blue of an image file of 8 bits, shape (H, W, 3); formats and errors as of read_grey."""
    return _decode_file(path, lambda image: np.asarray(image.convert("RGB")), max_cells)


def read_picture(path: Source, *, max_cells: int = MAX_CELLS) -> NDArray[np.uint8]:
    """Red, green and blue of a picture on white paper, shape (H, W, 3).

    Reads GIF and WebP besides the formats of read_grey. Transparent pixels are white; a photo is turned upright by its
    EXIF orientation. Errors as of read_grey.
    """
    return _decode_file(path, _compose_on_white, max_cells, formats=_PICTURE_FORMATS)


def read_dots_per_inch(path: Source) -> float | None:
    """Pixels per inch of paper that a picture states, None without; errors as of read_grey."""
    return _decode_file(path, _find_dots_per_inch, MAX_CELLS, formats=_PICTURE_FORMATS)


def _find_dots_per_inch(image: Image.Image) -> float | None:
    dots = image.info.get("dpi")
    stated = dots[0] if isinstance(dots, tuple) and dots else None
    return float(stated) if isinstance(stated, int | float) and isfinite(stated) and stated > 0 else None


def _compose_on_white(image: Image.Image) -> NDArray[np.uint8]:
    """Red, green and blue, shape (H, W, 3), of an image on white, turned upright by its EXIF orientation."""
    upright = ImageOps.exif_transpose(image)
    if upright.mode.startswith(("I", "F")):
        grey, transparent = _decode_grey(upright)
        grey = grey if transparent is None else np.where(transparent, np.uint8(255), grey)
        return np.repeat(grey[:, :, None], 3, axis=2)
    if upright.has_transparency_data:
        upright = upright.convert("RGBA")
        upright = Image.alpha_composite(Image.new("RGBA", upright.size, "white"), upright)
    return np.asarray(upright.convert("RGB"))


def _decode_file(
    path: Source, decode: Callable[[Image.Image], Pixels], max_cells: int, *, formats: tuple[str, ...] = _FORMATS
) -> Pixels:
    """What `decode` makes of an image file; MapError if it is damaged, too large, or not of the formats."""
    file = check_input_file(path_of(path), "image", MapError)
    name = f"image {short_repr(file)}"
    try:
        with _pillow_without_limits(), _opened(path, file, formats) as image:
            check_cell_count(image.size, name, max_cells=max_cells)
            Image.MAX_IMAGE_PIXELS = MAX_CELLS  # the tiles of a TIFF can be larger than the image
            return decode(image)
    except MapError:
        raise
    except UnidentifiedImageError:
        choices = ", ".join(formats[:-1]).replace("PPM", "PGM")
        raise MapError(f"{name} is no image, give a {choices} or {formats[-1]}") from None
    # Pillow's plug-ins raise various exceptions for hostile files.
    except Exception as exception:
        raise MapError(f"{name} is damaged, save it again: {one_line_reason(exception)}") from exception


@contextmanager
def _opened(source: Source, file: Path, formats: tuple[str, ...]) -> Iterator[Image.Image]:
    """The image of a file; a decoded one is not opened again."""
    if isinstance(source, DecodedImage):
        if source.pixels.format not in formats:
            raise UnidentifiedImageError
        yield source.pixels
        return
    # Opened as a stream: given a path, Pillow maps a TIFF into memory and mixes up the rows of a rotated one.
    with file.open("rb") as content, Image.open(content, formats=formats) as image:
        yield image


@contextmanager
def _pillow_without_limits() -> Iterator[None]:
    """Disable Pillow's warnings and size limit, which are global; max_cells replaces the limit."""
    with _PILLOW, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        limit, Image.MAX_IMAGE_PIXELS = Image.MAX_IMAGE_PIXELS, None
        try:
            yield
        finally:
            Image.MAX_IMAGE_PIXELS = limit


def _decode_grey(image: Image.Image) -> tuple[NDArray[np.uint8], NDArray[np.bool_] | None]:
    """Grey levels, shape (H, W), and a mask of pixels not opaque, None if all are; ValueError for fractions."""
    if image.mode == "F":
        raise ValueError("its pixels are fractions, not 8 or 16 bits")
    if image.mode.startswith("I"):
        return _decode_deep_grey(image)
    transparent = None
    if image.has_transparency_data:
        image = image.convert("RGBA")
        transparent = np.asarray(image.getchannel("A")) < 255
    return np.asarray(image.convert("L")), transparent if transparent is not None and transparent.any() else None


def _decode_deep_grey(image: Image.Image) -> tuple[NDArray[np.uint8], NDArray[np.bool_] | None]:
    """As `_decode_grey` for deeper pixels, 16 bits scaled to 8; ValueError for values outside 0 … 65535."""
    deep = np.asarray(image)
    if deep.min() < 0 or deep.max() > 65535:
        raise ValueError(f"its pixels lie in {deep.min()} … {deep.max()}, not in 8 or 16 bits")
    grey = ((deep.astype(np.uint32) + 128) // 257).astype(np.uint8)
    transparent = deep == image.info.get("transparency", -1)
    return grey, transparent if transparent.any() else None
