"""floor.geojson: the canonical file of a Floor, GeoJSON in metres of the map frame.

The collection has the members `format`, `version`, `frame`, `units`, `source`, `building_type` and `last_id`, the
highest id that a room ever had. A feature's property `class` is room (a polygon, counter-clockwise with clockwise
holes), door or wall (lines), or, since 2.3, furniture (a polygon), or, since 2.4, possible_door (a line), or, since
2.5, predicted_room (a polygon): the complete shape of the partial room `room`, with its `confidence`, or null. From 2.1
to 2.4 the room had them as the properties `predicted`, a geometry, and `confidence`. Since 2.2 a room has a `name`, or
null; since 2.3 rooms, doors and furniture have a `probability`, or null; since 2.5 a room has its `area`, which is not
read. The `rooms` of a door are two ids, those of an entrance an id and null; a possible door has the properties of a
door. Since 2.6 a room has a `number`, or null; rooms, doors and the collection have the `global_id` of the file that
they were read from, if it has one; a room may have a `flag`; a door to no room that is no entrance has `leads_out`
false; and the collection has the `title` and `elevation` of the storey, if they are known. Since 2.5 `crs` names a
local coordinate system, without which GDAL takes metres for degrees. Since 2.7 furniture may have a `kind`.
"""

from __future__ import annotations

import json
from abc import abstractmethod
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any, Literal, Self

import numpy as np
from numpy.typing import NDArray
from PIL import Image
from pydantic import (
    BaseModel,
    ConfigDict,
    Discriminator,
    Field,
    FiniteFloat,
    Tag,
    ValidationInfo,
    field_validator,
    model_validator,
)
from shapely import LineString, Polygon, get_coordinates
from shapely.geometry.base import BaseGeometry

from pianta.errors import FloorError
from pianta.floor import Door, Floor, Furniture, Room
from pianta.io._checked import FileFormat, read_checked, save_checked
from pianta.io._faults import validation_as
from pianta.io._files import atomic_file
from pianta.io._folders import finish_changes

FORMAT = FileFormat("pianta floor", 2, 7)
# GDAL takes a GeoJSON for degrees unless its `crs` names another system, and then reads WKT too.
LOCAL_CRS = 'LOCAL_CS["map frame",UNIT["metre",1],AXIS["x",EAST],AXIS["y",NORTH]]'
AREA_DIGITS = 4  # of square metres
MAX_FILE_BYTES = 64 * 2**20
MAX_COORDINATE = 1e8  # metres; beyond any map frame
# Files of version 1 have label -> probability, in the label set of the building's type.
LABEL_SET_OF_VERSION_1 = "type"
CLASSES = ("room", "door", "wall", "furniture", "possible_door", "predicted_room")
_Metres = Annotated[FiniteFloat, Field(ge=-MAX_COORDINATE, le=MAX_COORDINATE)]
_Position = tuple[_Metres, _Metres]
_Probabilities = dict[str, Annotated[FiniteFloat, Field(ge=0)]]
_LabelProbabilities = dict[str, Annotated[FiniteFloat, Field(ge=0, le=1)]]


def save_floor(floor: Floor, path: str | Path, *, scale: Mapping[str, Any] | None = None) -> None:
    """Write a floor as floor.geojson, a feature a line; read_floor returns an equal floor.

    scale: of a plan, as the member `scale`, which read_floor skips.
    Equal floors give equal bytes.
    Raises FloorError for a floor that read_floor would refuse, and PiantaError if the file cannot be written.
    """
    save_checked(path, "floor", FloorError, lambda: _dump_floor(floor, scale))


def read_floor(path: str | Path) -> Floor:
    """Read a floor from floor.geojson.

    Unknown members, properties and classes of features are skipped.

    Parameters
    ----------
    path
        The file that `pianta.read`, `Floor.save` or the command has written, of this version or an older one.

    Returns
    -------
    Floor
        The floor, metres of the map frame; equal to the one that was saved.

    Raises
    ------
    FloorError
        The file is no floor, or of a newer format; every fault is in one message.

    Examples
    --------
    >>> import pianta
    >>> pianta.make_world("corridor")[0].save("floor.geojson")
    >>> floor = pianta.read_floor("floor.geojson")
    >>> len(floor)
    19
    """
    finish_changes(Path(path).parent)
    return read_checked(path, "floor", FloorError, parse_floor, max_bytes=MAX_FILE_BYTES)


def read_scale_member(path: str | Path) -> Any:  # noqa: ANN401 - whatever the file holds there
    """The member `scale` of a floor.geojson that read_floor has read; None if it has none that can be read."""
    try:
        return json.loads(Path(path).read_bytes()).get("scale")
    except (OSError, ValueError):
        # Another program may have changed the file since it was read
        return None


def describe_floor(floor: Floor) -> dict[str, Any]:
    """A floor as the GeoJSON object of floor.geojson."""
    return {
        "type": "FeatureCollection",
        **FORMAT.header,
        "crs": {"type": "name", "properties": {"name": LOCAL_CRS}},
        "frame": "map",
        "units": "metres",
        "source": floor.source,
        "building_type": _sort_probabilities(floor.building_type),
        "last_id": int(floor.last_id),
        **_without_none(
            title=floor.title or None, elevation=_float_or_none(floor.elevation), global_id=floor.global_id
        ),
        "features": [*_features_of_floor(floor)],
    }


def _dump_floor(floor: Floor, scale: Mapping[str, Any] | None) -> bytes:
    """The content of floor.geojson; FloorError if it would not be read as the same floor."""
    header = describe_floor(floor) | ({} if scale is None else {"scale": scale})
    features = ",\n".join(map(_dump_strictly, header.pop("features")))
    content = f'{_dump_strictly(header)[:-1]}, "features": [\n{features}\n]}}\n'.encode()
    if parse_floor(content) != floor:
        raise FloorError("it has shapes in three dimensions, give it in two (shapely.force_2d)")
    return content


def _dump_strictly(value: object) -> str:
    return json.dumps(value, allow_nan=False)


def _features_of_floor(floor: Floor) -> Iterator[dict[str, Any]]:
    """The GeoJSON features of the rooms, the doors, the walls, the furniture, the possible doors, and predictions."""
    for room in floor.rooms:
        properties: dict[str, Any] = {
            "room": int(room.id),
            "number": room.number,
            "name": room.name,
            "label": room.label,
            "labels": dict(room.labels),
            "label_probabilities": {
                name: _sort_probabilities(probabilities) for name, probabilities in room.label_probabilities.items()
            },
            "partial": bool(room.partial),
            "probability": _float_or_none(room.probability),
            "area": round(room.polygon.area, AREA_DIGITS),
            **_without_none(flag=room.flag, global_id=room.global_id),
        }
        yield _feature("room", room.id, properties, room.polygon)
    for number, door in enumerate(floor.doors, start=1):
        yield _feature("door", number, _describe_door(door), door.line)
    for number, wall in enumerate(floor.walls, start=1):
        yield _feature("wall", number, {}, wall)
    for number, piece in enumerate(floor.furniture, start=1):
        properties = {"probability": _float_or_none(piece.probability), **_without_none(kind=piece.kind)}
        yield _feature("furniture", number, properties, piece.polygon)
    for number, door in enumerate(floor.possible_doors, start=1):
        yield _feature("possible_door", number, _describe_door(door), door.line)
    for room in floor.rooms:
        if room.predicted:
            properties = {"room": int(room.id), "confidence": _float_or_none(room.confidence)}
            yield _feature("predicted_room", room.id, properties, room.predicted)


def _describe_door(door: Door) -> dict[str, Any]:
    """The properties of the feature of a door or a possible door."""
    return {
        "rooms": [None if room is None else int(room) for room in door.rooms],
        "width": float(door.width),
        "kind": door.kind,
        "probability": _float_or_none(door.probability),
        **_without_none(leads_out=None if door.leads_out else False, global_id=door.global_id),
    }


def _without_none(**values: str | float | None) -> dict[str, str | float]:
    """The properties that are not None; most files have none of them."""
    return {name: value for name, value in values.items() if value is not None}


def _float_or_none(number: float | None) -> float | None:
    return None if number is None else float(number)


def _feature(class_: str, number: int, properties: dict[str, Any], shape: Polygon | LineString) -> dict[str, Any]:
    """A GeoJSON feature, whose id is its class and number; shape: metres of the map frame."""
    return {
        "type": "Feature",
        "id": f"{class_}-{number}",
        "properties": {"class": class_, **properties},
        "geometry": _geometry(shape),
    }


def _geometry(shape: Polygon | LineString) -> dict[str, Any]:
    rings = (shape.exterior, *shape.interiors) if isinstance(shape, Polygon) else ()
    return {"type": shape.geom_type, "coordinates": [_positions(ring) for ring in rings] or _positions(shape)}


def _positions(line: BaseGeometry) -> list[list[float]]:
    positions: list[list[float]] = get_coordinates(line).tolist()
    return positions


def _sort_probabilities(probabilities: Mapping[str, float]) -> dict[str, float]:
    return {name: float(probabilities[name]) for name in sorted(probabilities)}


class _Part(BaseModel):
    """An object in the file; members without a field are skipped."""

    model_config = ConfigDict(strict=True, frozen=True)


class _PolygonGeometry(_Part):
    type: Literal["Polygon"]
    coordinates: Annotated[list[Annotated[list[_Position], Field(min_length=4)]], Field(min_length=1)]

    @property
    def polygon(self) -> Polygon:
        shell, *holes = self.coordinates
        return Polygon(shell, holes)


class _LineGeometry(_Part):
    type: Literal["LineString"]
    coordinates: Annotated[list[_Position], Field(min_length=2)]


class _RoomProperties(_Part):
    room: int
    label: str | None = None
    labels: dict[str, str] = {}
    label_probabilities: dict[str, _LabelProbabilities] = {}
    partial: bool = False
    predicted: _PolygonGeometry | None = None
    confidence: FiniteFloat | None = None
    name: str | None = None
    probability: FiniteFloat | None = None
    number: str | None = None
    global_id: str | None = None
    flag: str | None = None

    @field_validator("label_probabilities", mode="before")
    @classmethod
    def _nest_version_1(cls, probabilities: object, info: ValidationInfo) -> object:
        is_old = info.context is not None and info.context["major"] == 1
        return {LABEL_SET_OF_VERSION_1: probabilities} if is_old and probabilities else probabilities


class _Item(_Part):
    """A feature that becomes a room, a door or furniture, whose own checks are faults of the file."""

    @property
    @abstractmethod
    def item(self) -> Room | Door | Furniture:
        """The room, door or furniture."""

    @model_validator(mode="after")
    def _check(self) -> Self:
        _ = self.item
        return self


class _RoomFeature(_Item):
    properties: _RoomProperties
    geometry: _PolygonGeometry

    @cached_property
    def item(self) -> Room:
        """The room; raises FloorError for values that a Room does not accept."""
        properties = dict(self.properties)
        predicted = properties.pop("predicted")
        return Room(
            properties.pop("room"),
            self.geometry.polygon,
            predicted=predicted and predicted.polygon,
            **properties,
        )


class _Prediction(_Part):
    room: int
    confidence: FiniteFloat | None = None


class _PredictionFeature(_Part):
    properties: _Prediction
    geometry: _PolygonGeometry


class _DoorProperties(_Part):
    rooms: tuple[int, int | None]
    width: FiniteFloat
    kind: Literal["door", "opening"] = "door"
    probability: FiniteFloat | None = None
    leads_out: bool = True
    global_id: str | None = None


class _LineOfDoor(_Item):
    properties: _DoorProperties
    geometry: _LineGeometry

    @cached_property
    def item(self) -> Door:
        return Door(line=LineString(self.geometry.coordinates), **dict(self.properties))


class _DoorFeature(_LineOfDoor):
    """A door, an opening or an entrance."""


class _PossibleDoorFeature(_LineOfDoor):
    """A door that may be there but is shut."""


class _WallFeature(_Part):
    geometry: _LineGeometry

    @property
    def wall(self) -> LineString:
        return LineString(self.geometry.coordinates)


class _FurnitureProperties(_Part):
    probability: FiniteFloat | None = None
    kind: str | None = None


class _FurnitureFeature(_Item):
    properties: _FurnitureProperties
    geometry: _PolygonGeometry

    @cached_property
    def item(self) -> Furniture:
        return Furniture(self.geometry.polygon, **dict(self.properties))


class _UnknownFeature(_Part):
    """A feature of a class of a later minor version."""


def _class_of_feature(feature: object) -> str:
    """The tag of the pydantic model of a feature."""
    properties = feature.get("properties") if isinstance(feature, dict) else None
    class_ = properties.get("class") if isinstance(properties, dict) else None
    return class_ if class_ in CLASSES else "unknown"


_Feature = Annotated[
    Annotated[_RoomFeature, Tag("room")]
    | Annotated[_DoorFeature, Tag("door")]
    | Annotated[_WallFeature, Tag("wall")]
    | Annotated[_FurnitureFeature, Tag("furniture")]
    | Annotated[_PossibleDoorFeature, Tag("possible_door")]
    | Annotated[_PredictionFeature, Tag("predicted_room")]
    | Annotated[_UnknownFeature, Tag("unknown")],
    Discriminator(_class_of_feature),
]


class _Collection(_Part):
    type: Literal["FeatureCollection"]
    frame: Literal["map"]
    units: Literal["metres"]
    source: str = ""
    building_type: _Probabilities = {}
    last_id: int = 0
    title: str = ""
    elevation: FiniteFloat | None = None
    global_id: str | None = None
    features: list[_Feature]


@validation_as(FloorError)
def parse_floor(content: bytes) -> Floor:
    """The floor in a GeoJSON; FloorError for a version that cannot be read, ValidationError for invalid content."""
    major, _ = FORMAT.check_version(content, FloorError)
    collection = _Collection.model_validate_json(content, context={"major": major})
    features = collection.features
    return Floor(
        rooms=tuple(_list_rooms(features)),
        doors=tuple(feature.item for feature in features if isinstance(feature, _DoorFeature)),
        walls=tuple(feature.wall for feature in features if isinstance(feature, _WallFeature)),
        building_type=collection.building_type,
        source=collection.source,
        last_id=collection.last_id,
        furniture=tuple(feature.item for feature in features if isinstance(feature, _FurnitureFeature)),
        possible_doors=tuple(feature.item for feature in features if isinstance(feature, _PossibleDoorFeature)),
        title=collection.title,
        elevation=collection.elevation,
        global_id=collection.global_id,
    )


def _list_rooms(features: Iterable[_Part]) -> Iterator[Room]:
    """The rooms with their predictions; FloorError for a prediction that is not of one of them, or not the only one."""
    predictions: dict[int, _PredictionFeature] = {}
    rooms = []
    for feature in features:
        if isinstance(feature, _RoomFeature):
            rooms.append(feature.item)
        elif isinstance(feature, _PredictionFeature):
            room_id = feature.properties.room
            if room_id in predictions:
                raise FloorError(f"room {room_id} is predicted more than once, keep one predicted_room")
            predictions[room_id] = feature
    if stray := sorted(predictions.keys() - {room.id for room in rooms}):
        raise FloorError(f"predictions are of rooms {stray} that do not exist")
    for room in rooms:
        prediction = predictions.get(room.id)
        if prediction is None:
            yield room
        else:
            confidence = prediction.properties.confidence
            yield replace(room, predicted=prediction.geometry.polygon, confidence=confidence)


def save_label_image(labels: NDArray[np.uint16], path: str | Path) -> None:
    """Write labels, shape (H, W), as a PNG of 16-bit grey.

    Raises FloorError unless they are a non-empty uint16 image, PiantaError if the file cannot be written.
    """
    if labels.dtype != np.uint16 or labels.ndim != 2 or labels.size == 0:
        raise FloorError(f"labels are {labels.dtype} of shape {labels.shape}, give a non-empty 2-D uint16 array")
    with atomic_file(path) as temporary:
        Image.fromarray(np.ascontiguousarray(labels)).save(temporary, format="PNG")
