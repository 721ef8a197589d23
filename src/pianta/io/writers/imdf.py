"""IMDF: a zip of GeoJSON files, one for each type of feature, in longitude and latitude of WGS 84.

Venue and address are placeholders, which the format requires and a map does not have. Ids are UUIDs made of the names
of storeys and the ids of rooms, so that they stay when the building is written again.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping
from datetime import UTC, datetime
from pathlib import Path
from typing import Any
from uuid import NAMESPACE_URL, UUID, uuid5
from zipfile import ZIP_DEFLATED, ZipFile

import numpy as np
from shapely import LineString, MultiPolygon, Point, Polygon, transform
from shapely.geometry import mapping
from shapely.geometry.base import BaseGeometry

from pianta.building import Building, Storey
from pianta.errors import OptionError
from pianta.floor import Door, Room
from pianta.io._files import count_noun
from pianta.io.georeference import Georeference
from pianta.io.writers._formats import WriteOptions
from pianta.io.writers.doorways import reach_doors
from pianta.io.writers.layers import note_links
from pianta.io.writers.osm import outline_storeys
from pianta.io.writers.room_uses import find_imdf_category
from pianta.io.writers.storey_levels import number_storeys

VERSION = "1.0.0"
LANGUAGE = "en"
DEGREE_DIGITS = 9  # a tenth of a millimetre
# Of the venue, by the most probable type of the building.
VENUES = {"school": "university", "university": "university", "hospital": "healthcarefacility"}
OTHER_VENUE = "businesscampus"
NO_COUNTRY = "ZZ"  # unknown, of ISO 3166

Feature = dict[str, Any]


def write_imdf(building: Building, target: Path, options: WriteOptions) -> list[str]:
    """The archive with its manifest."""
    if not any(building.list_rooms()):
        raise OptionError("format imdf needs a room, and the building has none; read its map again")
    if options.georeference is None:
        raise OptionError("format imdf needs longitudes and latitudes, give georeference=")
    archive = _Archive(building, options.georeference)
    manifest = {"version": VERSION, "created": datetime.now(UTC).isoformat(timespec="seconds"), "language": LANGUAGE}
    with ZipFile(target, "w", ZIP_DEFLATED) as file:
        file.writestr("manifest.json", json.dumps(manifest, indent=1))
        for feature_type, features in archive.list_features():
            content = {"type": "FeatureCollection", "name": feature_type, "features": [*features]}
            file.writestr(f"{feature_type}.geojson", json.dumps(content, ensure_ascii=False, allow_nan=False))
    notes = ["the venue and its address are placeholders, replace them in venue.geojson and address.geojson"]
    walls = sum(len(storey.floor.walls) for storey in building)
    return notes + ([f"{count_noun(walls, 'wall')} left out"] if walls else []) + note_links(building)


class _Archive:
    """The features of a building."""

    def __init__(self, building: Building, georeference: Georeference) -> None:
        self.building = building
        self.georeference = georeference
        self.levels = number_storeys(building)
        self.name = building.name or "Building"
        self.outlines = outline_storeys(building.storeys)

    def list_features(self) -> Iterator[tuple[str, list[Feature]]]:
        """The features of each type; types without features are left out."""
        listers: dict[str, Callable[[], Iterator[tuple[str, BaseGeometry | None, Feature]]]] = {
            "address": self._make_address,
            "venue": self._make_venue,
            "building": self._make_building,
            "footprint": self._make_footprint,
            "level": self._list_levels,
            "unit": self._list_units,
            "opening": self._list_openings,
            "fixture": self._list_fixtures,
        }
        for feature_type, make in listers.items():
            features = [
                {
                    "id": str(self._identify(feature_type, key)),
                    "type": "Feature",
                    "feature_type": feature_type,
                    "geometry": None if shape is None else self._draw(shape),
                    "properties": properties,
                }
                for key, shape, properties in make()
            ]
            if features:
                yield feature_type, features

    def _identify(self, feature_type: str, key: str) -> UUID:
        return uuid5(NAMESPACE_URL, f"pianta:{self.name}:{feature_type}:{key}")

    def _draw(self, shape: BaseGeometry) -> Mapping[str, Any]:
        world = self.georeference.to_wgs84(shape)
        rounded = transform(world, lambda points: np.round(points, DEGREE_DIGITS))
        geometry: Mapping[str, Any] = mapping(rounded if rounded.is_valid else world)
        return geometry

    def _locate(self, shape: BaseGeometry) -> Mapping[str, Any]:
        return self._draw(shape.representative_point())

    def _make_address(self) -> Iterator[tuple[str, None, Feature]]:
        parts = {"address": "unknown", "unit": None, "locality": "unknown", "province": None, "country": NO_COUNTRY}
        yield "", None, parts | {"postal_code": None, "postal_code_ext": None, "postal_code_vanity": None}

    def _make_venue(self) -> Iterator[tuple[str, BaseGeometry, Feature]]:
        types = self.building.storeys[0].floor.building_types
        category = next((VENUES[name] for name in types[:1] if name in VENUES), OTHER_VENUE)
        unknown: Feature = dict.fromkeys(("restriction", "alt_name", "hours", "phone", "website"))
        address = str(self._identify("address", ""))
        display_point = self._locate(self.outlines[0])
        own = {
            "category": category,
            "name": _translate(self.name),
            "display_point": display_point,
            "address_id": address,
        }
        yield "", _join(self.outlines), unknown | own

    def _make_building(self) -> Iterator[tuple[str, None, Feature]]:
        unknown: Feature = dict.fromkeys(("restriction", "alt_name"))
        own = {
            "category": "unspecified",
            "name": _translate(self.name),
            "display_point": self._locate(self.outlines[0]),
        }
        yield "", None, unknown | own | {"address_id": str(self._identify("address", ""))}

    def _make_footprint(self) -> Iterator[tuple[str, BaseGeometry, Feature]]:
        buildings = [str(self._identify("building", ""))]
        yield "", _join(self.outlines), {"category": "ground", "name": None, "building_ids": buildings}

    def _list_levels(self) -> Iterator[tuple[str, BaseGeometry, Feature]]:
        for storey in self.building:
            outlines = outline_storeys((storey,))
            if outlines:
                number = self.levels[storey.name]
                yield (
                    storey.name,
                    _join(outlines),
                    {
                        "category": "unspecified",
                        "restriction": None,
                        "outdoor": False,
                        "ordinal": number,
                        "name": _translate(storey.title or storey.name or f"Level {number}"),
                        "short_name": _translate(str(number)),
                        "display_point": self._locate(outlines[0]),
                        "address_id": None,
                        "building_ids": [str(self._identify("building", ""))],
                    },
                )

    def _list_units(self) -> Iterator[tuple[str, BaseGeometry, Feature]]:
        for storey in self.building:
            polygons = reach_doors(storey.floor)
            for room in storey.floor:
                yield f"{storey.name}:{room.id}", polygons[room.id], self._describe_unit(storey, room)

    def _describe_unit(self, storey: Storey, room: Room) -> Feature:
        unknown: Feature = dict.fromkeys(("restriction", "accessibility", "alt_name"))
        return unknown | {
            "category": find_imdf_category(room),
            "name": _translate(room.title) if room.title else None,
            "level_id": str(self._identify("level", storey.name)),
            "display_point": self._locate(room.polygon),
        }

    def _list_openings(self) -> Iterator[tuple[str, BaseGeometry, Feature]]:
        for storey in self.building:
            for number, door in enumerate(storey.floor.doors, start=1):
                yield f"{storey.name}:{number}", _straighten(door), self._describe_opening(storey, door)

    def _describe_opening(self, storey: Storey, door: Door) -> Feature:
        unknown: Feature = dict.fromkeys(("accessibility", "access_control", "name", "alt_name"))
        door_type = "open" if door.kind == "opening" else "unspecified"
        return unknown | {
            "category": "pedestrian.principal" if door.is_entrance else "pedestrian",
            "door": {"type": door_type, "automatic": False, "material": None},
            "display_point": self._draw(_straighten(door).interpolate(0.5, normalized=True)),
            "level_id": str(self._identify("level", storey.name)),
        }

    def _list_fixtures(self) -> Iterator[tuple[str, BaseGeometry, Feature]]:
        unknown: Feature = dict.fromkeys(("name", "alt_name", "anchor_id"))
        for storey in self.building:
            level = str(self._identify("level", storey.name))
            for number, piece in enumerate(storey.floor.furniture, start=1):
                display_point = self._locate(piece.polygon)
                properties = {"category": "furniture", "display_point": display_point, "level_id": level}
                yield f"{storey.name}:{number}", piece.polygon, unknown | properties


def _straighten(door: Door) -> LineString:
    """The line of a door with its two ends alone."""
    return LineString([Point(door.line.coords[0]), Point(door.line.coords[-1])])


def _join(outlines: list[Polygon]) -> Polygon | MultiPolygon:
    return outlines[0] if len(outlines) == 1 else MultiPolygon(outlines)


def _translate(text: str) -> dict[str, str]:
    return {LANGUAGE: text}
