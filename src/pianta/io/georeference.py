"""Georeference: from metres of the map frame to a coordinate system of the earth."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from math import cos, radians, sin
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal, TypeAlias, TypeVar

import numpy as np
import yaml
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field, FiniteFloat, model_validator
from shapely import get_coordinates, transform
from shapely.geometry.base import BaseGeometry

from pianta.errors import OptionError
from pianta.io._checked import read_checked
from pianta.io._faults import validation_as
from pianta.io._files import one_line_reason, short_repr
from pianta.io._yaml import PlainLoader

if TYPE_CHECKING:
    from pyproj import CRS, Transformer

Shape = TypeVar("Shape", bound=BaseGeometry)
Matrix: TypeAlias = tuple[float, float, float, float, float, float]

WGS84 = "EPSG:4326"
MAX_FILE_BYTES = 2**17  # thousand points; PyYAML takes 15 s for a wide file of 1 MB
MAX_POINTS = 1000
MAX_LISTED = 10  # points in a message
MAX_COORDINATE = 1e8  # metres; beyond any coordinate system of the earth
# Control points that are missed by this share of their distances from their middle, or more, do not belong together,
# as where one frame is mirrored; chosen by hand.
MAX_MISSED = 0.25
# Points lie on a line if the second singular value of their positions is this share of the first; chosen by hand.
LINE_SHARE = 1e-6
# A plane in which lengths around a point are true to a millimetre over kilometres.
_LOCAL_PLANE = "+proj=aeqd +lat_0={latitude:.10f} +lon_0={longitude:.10f} +datum=WGS84 +units=m +type=crs"

NO_NAME = "unknown"  # that PROJ gives to a system which is written as its parameters


@dataclass(frozen=True)
class Georeference:
    """An affine motion from the map frame to a coordinate system.

    Attributes
    ----------
    crs
        The name of the system, such as "EPSG:32632".
    matrix
        (a, b, c, d, e, f); a point x, y of the map is at a x + b y + c and d x + e y + f.
    residuals
        By how much each control point is missed, in units of the system; empty for an anchor.
    """

    crs: str
    matrix: Matrix
    residuals: tuple[float, ...] = ()

    def to_world(self, shape: Shape) -> Shape:
        """The shape of the map frame in the coordinate system; easting or longitude first."""
        a, b, c, d, e, f = self.matrix

        def move(points: NDArray[np.float64]) -> NDArray[np.float64]:
            x, y = points.T
            return np.column_stack([a * x + b * y + c, d * x + e * y + f])

        moved: Shape = transform(shape, move)
        return moved

    def to_wgs84(self, shape: Shape) -> Shape:
        """The shape of the map frame in longitude and latitude of WGS 84."""
        transformer = _make_transformer(self.crs)
        world = self.to_world(shape)
        moved: Shape = transform(world, lambda points: np.column_stack(transformer.transform(*points.T)))
        if not np.isfinite(get_coordinates(moved)).all():
            raise OptionError(f"the georeference puts the map outside of {self.crs}, check its points and its crs")
        return moved

    def name_crs(self) -> CRS:
        """The coordinate system, a plane around an anchor with a name that says so."""
        from pyproj import CRS

        members = CRS(self.crs).to_json_dict()
        if members["name"] == NO_NAME:
            members["name"] = "metres around the map, WGS 84"
        return CRS.from_json_dict(members)

    def describe(self) -> str:
        """The coordinate system, and how well the control points fit, on one line."""
        if not self.residuals:
            return f"georeference: anchor, {self.crs}"
        listed = ", ".join(f"{each:.3f}" for each in self.residuals)
        mean = float(np.sqrt(np.mean(np.square(self.residuals))))
        return f"georeference: {self.crs}, control points are missed by {listed} (root mean square {mean:.3f})"


def read_georeference(path: str | Path) -> Georeference:
    """Read a georeference from a YAML or JSON file.

    Parameters
    ----------
    path
        Either `crs`, `points` (each with `map` and `world`, two numbers) and, if wanted, `transform: affine`; or
        `latitude`, `longitude` and `bearing` of an anchor, and, if it is not the origin of the map, `map`.
        World coordinates have the easting or longitude first; the bearing is that of the map's y axis, degrees
        clockwise from north.

    Returns
    -------
    Georeference
        Least squares over the control points: a rotation, a scale and a shift, or any affine motion.

    Raises
    ------
    OptionError
        The file is no georeference, too few points are given, or pyproj is not installed.

    Examples
    --------
    >>> from pathlib import Path
    >>> text = "{latitude: 45.4785, longitude: 9.2327, bearing: 30}"
    >>> _ = Path("anchor.yaml").write_text(text)
    >>> from pianta.io.georeference import read_georeference
    >>> [round(value, 3) for value in read_georeference("anchor.yaml").matrix]
    [0.866, 0.5, 0.0, -0.5, 0.866, 0.0]
    """
    return read_checked(path, "georeference", OptionError, _parse_georeference, max_bytes=MAX_FILE_BYTES)


def fit_motion(map_points: NDArray[np.float64], world_points: NDArray[np.float64], *, affine: bool) -> Matrix:
    """The motion that takes points, shape (N, 2), closest to others, by least squares.

    affine: any affine motion, by three points or more; else a rotation, a scale and a shift, by two or more.
    """
    x, y = map_points.T
    none, one = np.zeros_like(x), np.ones_like(x)
    if affine:
        rows = np.vstack(
            [np.column_stack([x, y, one, none, none, none]), np.column_stack([none, none, none, x, y, one])]
        )
    else:
        rows = np.vstack([np.column_stack([x, -y, one, none]), np.column_stack([y, x, none, one])])
    # Coordinates of the earth have seven digits before the point, which would cost accuracy
    centre = world_points.mean(axis=0)
    solution, *_ = np.linalg.lstsq(rows, (world_points - centre).T.ravel(), rcond=None)
    if affine:
        a, b, c, d, e, f = map(float, solution)
    else:
        a, d, c, f = map(float, solution)
        b, e = -d, a
    return a, b, c + float(centre[0]), d, e, f + float(centre[1])


_Number = Annotated[FiniteFloat, Field(ge=-MAX_COORDINATE, le=MAX_COORDINATE)]
_Numbers = tuple[_Number, _Number]


class _Part(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")


class _Pair(_Part):
    map: _Numbers
    world: _Numbers


class _Points(_Part):
    crs: str
    points: Annotated[list[_Pair], Field(min_length=3, max_length=MAX_POINTS)]
    transform: Literal["similarity", "affine"] = "similarity"

    @model_validator(mode="after")
    def _check_spread(self) -> _Points:
        for name in ("map", "world"):
            points = np.array([getattr(pair, name) for pair in self.points])
            spread = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
            if spread[0] == 0 or (self.transform == "affine" and spread[1] < LINE_SHARE * spread[0]):
                raise ValueError(f"the {name} points are one point, or on one line; give others")
        return self

    def make(self) -> Georeference:
        crs = _parse_crs(self.crs)
        world = np.array([pair.world for pair in self.points])
        if crs.is_geographic:
            if (np.abs(world) > (180, 90)).any():
                raise OptionError(f"world points are no longitude, latitude of {self.crs}, give degrees in this order")
            longitude, latitude = map(float, world.mean(axis=0))
            plane = _LOCAL_PLANE.format(latitude=latitude, longitude=longitude)
            world = np.column_stack(_make_transformer(self.crs, plane).transform(*world.T))
        map_points = np.array([pair.map for pair in self.points])
        matrix = fit_motion(map_points, world, affine=self.transform == "affine")
        a, b, c, d, e, f = matrix
        fitted = map_points @ np.array([[a, d], [b, e]]) + (c, f)
        missed = tuple(float(each) for each in np.hypot(*(fitted - world).T))
        if np.linalg.norm(missed) > MAX_MISSED * np.linalg.norm(world - world.mean(axis=0)):
            listed = ", ".join(f"{each:.1f}" for each in missed[:MAX_LISTED])
            raise OptionError(f"control points are missed by {listed}; check them: axes swapped, mirrored, mixed up?")
        return Georeference(plane if crs.is_geographic else self.crs, matrix, missed)


class _Anchor(_Part):
    latitude: Annotated[FiniteFloat, Field(ge=-90, le=90)]
    longitude: Annotated[FiniteFloat, Field(ge=-180, le=180)]
    bearing: Annotated[FiniteFloat, Field(ge=-360, le=360)] = 0.0
    map: _Numbers = (0.0, 0.0)

    def make(self) -> Georeference:
        x, y = self.map
        right, up = cos(radians(self.bearing)), sin(radians(self.bearing))
        shift = -(right * x + up * y), up * x - right * y
        crs = _LOCAL_PLANE.format(latitude=self.latitude, longitude=self.longitude)
        return Georeference(crs, (right, up, shift[0], -up, right, shift[1]))


@validation_as(OptionError)
def _parse_georeference(content: bytes) -> Georeference:
    try:
        # YAML contains JSON
        members = yaml.load(content, PlainLoader)  # noqa: S506 - a BaseLoader makes texts alone
    except (yaml.YAMLError, UnicodeDecodeError, ValueError, RecursionError) as error:
        raise OptionError(f"it is neither YAML nor JSON: {one_line_reason(error)}") from None
    if not isinstance(members, dict):
        raise OptionError("it has no members, give crs and points, or latitude, longitude and bearing")
    parsed: _Anchor | _Points = (_Anchor if "latitude" in members else _Points).model_validate(members)
    return parsed.make()


def _parse_crs(name: str) -> CRS:
    try:
        from pyproj import CRS
        from pyproj.exceptions import CRSError
    except ImportError:
        raise OptionError("pyproj is not installed, install it with: pip install 'pianta[geo]'") from None
    try:
        crs = CRS(name)
    except CRSError:
        raise OptionError(f"crs {short_repr(name)} is unknown, give one such as EPSG:32632") from None
    if not (crs.is_geographic or crs.is_projected):
        raise OptionError(f"crs {short_repr(name)} is not one of the earth's surface, give one such as EPSG:32632")
    return crs


@lru_cache(maxsize=16)
def _make_transformer(source: str, target: str = WGS84) -> Transformer:
    """The way from one coordinate system to another, easting or longitude first; to make one takes a while."""
    from pyproj import Transformer

    return Transformer.from_crs(_parse_crs(source), target, always_xy=True)
