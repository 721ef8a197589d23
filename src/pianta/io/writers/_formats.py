"""The formats that `pianta convert` writes: name, file, module, and which options each has."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, TypeAlias

from pianta.building import Building
from pianta.errors import OptionError
from pianta.navigation.robot import ROBOT_RADIUS

if TYPE_CHECKING:
    from pianta.io.georeference import Georeference


# Of a speed mask, percent of the robot's own.
SPEED = 50.0


@dataclass(frozen=True, kw_only=True)
class WriteOptions:
    """What formats ask for beside the building.

    robot_radius: metres. rooms: those that masks are about, by ids, names or labels; all if empty. speed: percent, of a
    speed mask. straight: whether outlines get right angles where the building has them. georeference: from metres of
    the map frame to a coordinate system; None if unknown. robot_map: Valetudo's map JSON, with the robot's segments.
    """

    robot_radius: float = ROBOT_RADIUS
    rooms: tuple[str, ...] = ()
    speed: float = SPEED
    straight: bool = False
    georeference: Georeference | None = None
    robot_map: Path | None = None

    def list_changed(self) -> list[str]:
        """The names of the options that are not as they are by default."""
        return [each.name for each in fields(self) if getattr(self, each.name) != each.default]


# Writes a building into a temporary file, or folder, and gives what it has left out or changed, a line each.
Writer: TypeAlias = Callable[[Building, Path, WriteOptions], list[str]]


@dataclass(frozen=True)
class Format:
    """A format. module: in this folder, or its full name. file: the usual name, that of a folder if it has no suffix.

    needs_map, needs_georeference: whether it cannot be written without.
    extra, packages: which extra of pianta installs the packages that the writer needs.
    """

    module: str
    function: str
    file: str
    title: str
    options: frozenset[str] = frozenset()
    needs_map: bool = False
    needs_georeference: bool = False
    extra: str = ""
    packages: tuple[str, ...] = ()

    @property
    def is_folder(self) -> bool:
        """Whether the format is a folder of files."""
        return not Path(self.file).suffix

    def find_writer(self) -> Writer:
        """The function that writes the format; raises OptionError if a package that it needs is not installed."""
        missing = [package for package in self.packages if find_spec(package) is None]
        if missing:
            raise OptionError(
                f"{' and '.join(missing)} is not installed, install it with: pip install 'pianta[{self.extra}]'"
            )
        module = self.module if "." in self.module else f"pianta.io.writers.{self.module}"
        writer: Writer = getattr(import_module(module), self.function)
        return writer


# Of the formats that have outlines.
_STRAIGHT = frozenset({"straight"})
_OUTLINES_ON_EARTH = _STRAIGHT | {"georeference"}

FORMATS: Mapping[str, Format] = MappingProxyType(
    {
        "csv": Format("tables", "write_csv", "rooms.csv", "table of rooms, CSV", _STRAIGHT),
        "excel": Format(
            "tables",
            "write_excel",
            "rooms.xlsx",
            "tables of rooms, doors and totals, Excel",
            _STRAIGHT,
            extra="tables",
            packages=("openpyxl",),
        ),
        "dxf": Format(
            "dxf",
            "write_dxf",
            "floor.dxf",
            "drawing of rooms, walls and doors, DXF",
            extra="cad",
            packages=("ezdxf",),
            options=_STRAIGHT,
        ),
        "svg": Format("svg", "write_svg", "floor.svg", "drawing of rooms, walls and doors, SVG", options=_STRAIGHT),
        "ifc": Format(
            "ifc",
            "write_ifc",
            "building.ifc",
            "building model, IFC4",
            extra="bim",
            packages=("ifcopenshell",),
            options=_STRAIGHT,
        ),
        "gazebo": Format("gazebo", "write_gazebo", "gazebo", "world of Gazebo, SDF", options=_STRAIGHT),
        "stage": Format("stage", "write_stage", "stage", "world of Stage, with its image", options=_STRAIGHT),
        "sweethome3d": Format(
            "sweethome3d", "write_sweethome3d", "building.sh3d", "home of Sweet Home 3D", options=_STRAIGHT
        ),
        "scene-graph": Format(
            "scene_graph", "write_scene_graph", "scene_graph.json", "scene graph of Hydra, JSON", _STRAIGHT
        ),
        "geojson-layers": Format(
            "layers", "write_geojson_layers", "layers", "a GeoJSON for rooms, doors and others each", _OUTLINES_ON_EARTH
        ),
        "gpkg": Format(
            "layers",
            "write_geopackage",
            "floor.gpkg",
            "GeoPackage",
            _OUTLINES_ON_EARTH,
            extra="geo",
            packages=("geopandas", "pyogrio"),
        ),
        "geoparquet": Format(
            "layers",
            "write_geoparquet",
            "geoparquet",
            "a GeoParquet for rooms, doors and others each",
            _OUTLINES_ON_EARTH,
            extra="geo",
            packages=("geopandas", "pyarrow"),
        ),
        "indoorgml": Format("indoorgml", "write_indoorgml", "building.gml", "IndoorGML 1.1", _STRAIGHT),
        "imdf": Format(
            "imdf",
            "write_imdf",
            "imdf.zip",
            "Indoor Mapping Data Format",
            _OUTLINES_ON_EARTH,
            needs_georeference=True,
            extra="geo",
            packages=("pyproj",),
        ),
        "osm": Format(
            "osm",
            "write_osm",
            "building.osm",
            "OpenStreetMap with indoor tags",
            _OUTLINES_ON_EARTH,
            needs_georeference=True,
            extra="geo",
            packages=("pyproj",),
        ),
        "osmag": Format(
            "osmag",
            "write_osmag",
            "area-graph.osm",
            "osmAG area graph",
            _OUTLINES_ON_EARTH,
            needs_georeference=True,
            extra="geo",
            packages=("pyproj",),
        ),
        "label-image": Format(
            "label_images",
            "write_label_images",
            "label-image",
            "coloured label images and their colours",
            needs_map=True,
        ),
        "picture": Format("pianta.plot.building_pictures", "write_pictures", "picture", "the picture as SVG, large"),
        "nav2-route": Format(
            "nav2_route",
            "write_route_graph",
            "route.geojson",
            "route graph for Nav2's route server",
            options=frozenset({"robot_radius"}),
            needs_map=True,
        ),
        "nav2-keepout": Format(
            "nav2_masks",
            "write_keepout_mask",
            "keepout",
            "mask for Nav2's keep-out filter",
            options=frozenset({"rooms"}),
            needs_map=True,
        ),
        "nav2-speed": Format(
            "nav2_masks",
            "write_speed_mask",
            "speed",
            "mask for Nav2's speed filter",
            options=frozenset({"rooms", "speed"}),
            needs_map=True,
        ),
        "waypoints": Format(
            "nav2_waypoints",
            "write_waypoints",
            "waypoints.yaml",
            "poses in rooms and at doors, YAML or JSON",
            options=frozenset({"robot_radius"}),
            needs_map=True,
        ),
        "cleaning": Format(
            "cleaning",
            "write_cleaning",
            "cleaning.json",
            "rooms in a tour, and paths that clean them",
            options=frozenset({"robot_radius"}),
            needs_map=True,
        ),
        "valetudo": Format(
            "vacuum", "write_valetudo", "valetudo.json", "map of a vacuum, Valetudo", options=frozenset({"robot_map"})
        ),
        "map-card": Format(
            "vacuum",
            "write_map_card",
            "map-card.yaml",
            "rooms of the vacuum map card, Home Assistant",
            options=_STRAIGHT | {"robot_map"},
        ),
    }
)
