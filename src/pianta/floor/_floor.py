"""A floor of a building: its rooms, doors, walls and furniture, and what can be made of them."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Literal, Unpack

import networkx as nx
import numpy as np
from numpy.typing import NDArray
from shapely import LineString

from pianta.errors import FloorError, LabelError
from pianta.floor._cells import cells_of_polygon
from pianta.floor._corrected import Correctable
from pianta.floor._parts import (
    MAX_GLOBAL_ID_LENGTH,
    MAX_ROOM_NAME_LENGTH,
    Door,
    Furniture,
    Room,
    check_text,
    copy_probabilities,
)
from pianta.gridmap import GridMap
from pianta.labels import standard_building_type

if TYPE_CHECKING:
    from geopandas import GeoDataFrame
    from matplotlib.axes import Axes

    from pianta.io.writers.convert import ConvertOptions

MAX_LABEL_IMAGE_ID = np.iinfo(np.uint16).max


@dataclass(frozen=True)
class Floor(Correctable):
    """One floor of a building, in metres of the map frame.

    `floor[3]` is the room with the id 3, `len(floor)` the number of rooms, `for room in floor` iterates over the rooms,
    and `3 in floor` is whether a room has the id 3. A notebook shows a floor as a page to look at.

    Parameters
    ----------
    rooms
        In any order; ids are unique.
    doors
        Each joins two rooms of this floor, or one of them to the outside.
    walls
        The representative lines of the building, cut to its extent.
    building_type
        Type -> probability, empty if unknown; types in any case become lower case.
    source
        The name of the map or file of the floor.
    last_id
        The highest id that a room of this building ever had, so that ids are never reused; 0 for the highest on this
        floor.
    furniture
        What stands in the rooms; the rooms' polygons keep the floor under it.
    possible_doors
        Doors that may be there but are shut; they join no rooms in the graph.
    title
        What its file calls the storey, such as "Ground floor"; empty if unknown.
    elevation
        Height of its floor above the zero of the file, metres; None if unknown.
    global_id
        The identifier of the storey in its file, such as the GlobalId of an IFC; None without one.

    Raises
    ------
    FloorError
        Ids occur twice, doors lead to rooms that do not exist, or `last_id` is below the id of a room; every fault is
        in one message.

    References
    ----------
    M. Luperto, PhD thesis, section 3.1.

    Examples
    --------
    >>> import pianta
    >>> from shapely import LineString, box
    >>> rooms = (pianta.Room(1, box(0, 0, 4, 3)), pianta.Room(2, box(4, 0, 8, 3)))
    >>> floor = pianta.Floor(rooms, (pianta.Door((1, 2), LineString([(4, 1), (4, 2)]), 1.0),))
    >>> len(floor), 2 in floor, floor[2].polygon.area
    (2, True, 12.0)
    >>> list(floor.graph().edges)
    [(1, 2)]
    """

    rooms: tuple[Room, ...]
    doors: tuple[Door, ...] = ()
    walls: tuple[LineString, ...] = ()
    building_type: Mapping[str, float] = field(default_factory=dict)
    source: str = ""
    last_id: int = 0
    furniture: tuple[Furniture, ...] = ()
    possible_doors: tuple[Door, ...] = ()
    title: str = ""
    elevation: float | None = None
    global_id: str | None = None

    def __post_init__(self) -> None:
        for name in ("rooms", "doors", "walls", "furniture", "possible_doors"):
            object.__setattr__(self, name, tuple(getattr(self, name)))
        object.__setattr__(self, "building_type", _standardise_types(self.building_type))
        check_text(self.title or None, "the floor has the title", MAX_ROOM_NAME_LENGTH)
        check_text(self.global_id, "the floor has the identifier", MAX_GLOBAL_ID_LENGTH)
        if self.elevation is not None and not isfinite(self.elevation):
            raise FloorError(f"the floor has the elevation {self.elevation}, give metres or None")
        ids = Counter(room.id for room in self.rooms)
        repeated = sorted(room_id for room_id, count in ids.items() if count > 1)
        doors = (*self.doors, *self.possible_doors)
        stray = sorted({room_id for door in doors for room_id in door.room_ids} - ids.keys())
        highest = max(ids, default=0)
        faults = [f"room ids {repeated} occur more than once"] if repeated else []
        faults += [f"doors lead to rooms {stray} that do not exist"] if stray else []
        if self.last_id == 0:
            object.__setattr__(self, "last_id", highest)
        elif self.last_id < highest:
            faults.append(f"the last id is {self.last_id} and a room has id {highest}, give {highest} or more")
        if faults:
            raise FloorError("not a floor: " + "; ".join(faults))

    def __repr__(self) -> str:
        """The source and the numbers; all rooms would fill screens."""
        area = sum(room.polygon.area for room in self.rooms)
        return f"<Floor {self.source!r}: {len(self.rooms)} rooms, {len(self.doors)} doors, {area:.1f} m²>"

    def __getitem__(self, room_id: int) -> Room:
        """The room with an id; KeyError if it does not exist."""
        for room in self.rooms:
            if room.id == room_id:
                return room
        raise KeyError(room_id)

    def __len__(self) -> int:
        """Number of rooms."""
        return len(self.rooms)

    def __bool__(self) -> bool:
        """True: a floor without rooms is a floor."""
        return True

    def __iter__(self) -> Iterator[Room]:
        """The rooms, in their order."""
        return iter(self.rooms)

    def __contains__(self, room: object) -> bool:
        """Whether this is the id of a room, or one of the rooms."""
        return room in self.rooms if isinstance(room, Room) else any(each.id == room for each in self.rooms)

    def room_at(self, x: float, y: float) -> Room | None:
        """Find the room at a position.

        Parameters
        ----------
        x, y
            Metres of the map frame.

        Returns
        -------
        Room or None
            The room whose polygon has the position inside or on its outline, the first of several; None outside of all
            rooms.

        Examples
        --------
        >>> import pianta
        >>> floor, _ = pianta.make_world("corridor")
        >>> floor.room_at(10.0, 5.0).id, floor.room_at(-10.0, 0.0)
        (14, None)
        """
        import shapely

        return next((room for room in self.rooms if shapely.intersects_xy(room.polygon, x, y)), None)

    def plot(
        self,
        grid: GridMap | None = None,
        *,
        ax: Axes | None = None,
        walls: bool = False,
        graph: bool = False,
        furniture: bool = True,
    ) -> Axes:
        """Draw the rooms with their ids, in the colours of their labels if they have any, and the doors.

        Parameters
        ----------
        grid
            The map to draw below; None for no map.
        ax
            Where to draw, in metres of the map frame; a new figure if None.
        walls, graph
            Whether to draw the wall lines and the topological graph too.
        furniture
            Whether to draw the furniture.

        Returns
        -------
        Axes
            The ax with the drawing; nothing is shown.

        Examples
        --------
        >>> import pianta
        >>> floor, grid = pianta.make_world("corridor")
        >>> ax = floor.plot(grid, graph=True)
        >>> ax.figure.savefig("floor.png")
        """
        from pianta.plot.floor import plot_floor

        return plot_floor(self, grid, ax=ax, walls=walls, graph=graph, furniture=furniture)

    def _repr_png_(self) -> bytes | None:
        """The floor as a notebook shows it that has no HTML; None for one without rooms."""
        from pianta.plot.floor import render_floor

        return render_floor(self) if self.rooms else None

    def _repr_html_(self) -> str | None:
        """The floor as a notebook shows it, with its list of rooms; None for one without rooms."""
        from pianta.view.notebook import show_in_frame

        return show_in_frame(self) if self.rooms else None

    def save(self, path: str | Path) -> None:
        """Write the floor as floor.geojson, metres of the map frame; `read_floor` returns an equal one.

        Parameters
        ----------
        path
            The file; an older one is replaced. Equal floors give equal bytes.

        Raises
        ------
        FloorError
            `read_floor` would refuse the floor.
        PiantaError
            The file cannot be written.

        Examples
        --------
        >>> import pianta
        >>> floor, _ = pianta.make_world("corridor")
        >>> floor.save("floor.geojson")
        >>> pianta.read_floor("floor.geojson") == floor
        True
        """
        from pianta.io.floors import save_floor

        save_floor(self, path)

    def to_file(
        self, path: str | Path, *, to: str | None = None, grid: GridMap | None = None, **options: Unpack[ConvertOptions]
    ) -> list[str]:
        """Write the floor in a format of other programs; see `pianta.convert`.

        Parameters
        ----------
        path
            The file or the folder to write; older ones are replaced, all files or none.
        to
            The format; if None, the one format whose files have the suffix of the path.
        grid
            The map, which formats for robots need.
        **options
            Those of `pianta.convert`: robot_radius, rooms, speed, straight, georeference, robot_map.

        Returns
        -------
        list of str
            What the format cannot hold and what was changed for it, a line each.

        Raises
        ------
        PiantaError
            As `pianta.convert`.

        Examples
        --------
        >>> import pianta
        >>> floor, _ = pianta.make_world("corridor")
        >>> floor.to_file("rooms.csv")
        []
        """
        from pianta.io.writers.convert import convert

        return convert(self, path, to=to, grid=grid, **options)

    def to_geodataframe(
        self, layer: Literal["rooms", "doors", "walls", "furniture", "possible_doors"] = "rooms"
    ) -> GeoDataFrame:
        """One layer of the floor as a GeoDataFrame, in metres of the map frame, without a coordinate system.

        Parameters
        ----------
        layer
            "rooms": polygons; the index is the id, the columns number, name, label, label_probability, partial, area
            (m²) and probability.
            "doors": lines from jamb to jamb; columns room, other_room (missing for an entrance), width (m), kind and
            probability.
            "walls": the wall lines.
            "furniture": polygons; columns area (m²) and probability.
            "possible_doors": lines with the columns of doors.

        Returns
        -------
        geopandas.GeoDataFrame
            One row for each.

        Raises
        ------
        OptionError
            The layer does not exist, or geopandas is not installed (`pip install 'pianta[geo]'`).

        Examples
        --------
        >>> import pianta
        >>> floor, _ = pianta.make_world("corridor")
        >>> rooms = floor.to_geodataframe()
        >>> rooms.loc[1, "label"], round(float(rooms.loc[1, "area"]), 1)
        ('CORRIDOR', 66.8)
        """
        from pianta.io.geodataframes import floor_to_geodataframe

        return floor_to_geodataframe(self, layer)

    @property
    def given_type(self) -> str | None:
        """The building type from a user, which is the only one and has probability 1; None for a predicted one."""
        return self.building_types[0] if [*self.building_type.values()] == [1] else None

    @property
    def building_types(self) -> tuple[str, ...]:
        """The possible types of the building, the most probable first."""
        return tuple(sorted(self.building_type, key=lambda name: -self.building_type[name]))

    def graph(self) -> nx.Graph:
        """Topological graph: a node for each room, an edge where one or more doors join two rooms.

        Possible doors are left out.

        Returns
        -------
        networkx.Graph
            Nodes are the ids of the rooms, with the attributes `number`, `name`, `flag`, `label`, `labels`,
            `label_probabilities`, `area` (m²), `x`, `y` (m; a point inside the room), `partial`, `predicted_area` (m²)
            and `confidence`, both None unless the room is predicted, `entrances` (their number) and `probability` (that
            it is one true room; None if unknown). Edges have `doors` (their number), `width` and `probability` (m, and
            None if unknown, of the widest), and `x`, `y` (m, the middle of the widest). The graph has `source`.

        References
        ----------
        M. Luperto, PhD thesis, section 3.1.

        Examples
        --------
        >>> import pianta
        >>> graph = pianta.make_world("corridor")[0].graph()
        >>> len(graph), graph.nodes[1]["label"], sorted(graph[2])
        (19, 'CORRIDOR', [1])
        """
        graph = nx.Graph(source=self.source)
        entrances = Counter(door.rooms[0] for door in self.doors if door.is_entrance)
        for room in self.rooms:
            inside = room.polygon.representative_point()
            graph.add_node(
                room.id,
                number=room.number,
                name=room.name,
                flag=room.flag,
                label=room.label,
                labels=dict(room.labels),
                label_probabilities=copy_probabilities(room.label_probabilities),
                area=room.polygon.area,
                x=inside.x,
                y=inside.y,
                partial=room.partial,
                predicted_area=room.predicted.area if room.predicted else None,
                confidence=room.confidence,
                entrances=entrances[room.id],
                probability=room.probability,
            )
        inner_doors = (door for door in self.doors if door.joins_rooms)
        for door in sorted(inner_doors, key=lambda door: door.width):
            count = graph.edges[door.rooms]["doors"] if graph.has_edge(*door.rooms) else 0
            middle = door.line.interpolate(0.5, normalized=True)
            graph.add_edge(
                *door.rooms,
                doors=count + 1,
                width=door.width,
                x=middle.x,
                y=middle.y,
                probability=door.probability,
            )
        return graph

    def label_image(self, grid: GridMap) -> NDArray[np.uint16]:
        """Room ids on the cells of a grid map.

        Parameters
        ----------
        grid
            The map whose cells get ids; its values are not used.

        Returns
        -------
        numpy.ndarray
            Shape (H, W) of the grid; the id of the room that contains the centre of a cell, 0 outside of rooms.

        Raises
        ------
        FloorError
            An id does not fit 16 bits.

        Examples
        --------
        >>> import pianta
        >>> floor, grid = pianta.make_world("corridor")
        >>> ids = floor.label_image(grid)
        >>> ids.shape == grid.shape, int(ids.max())
        (True, 19)
        """
        labels = np.zeros(grid.shape, np.uint16)
        for room in self.rooms:
            if room.id > MAX_LABEL_IMAGE_ID:
                raise FloorError(f"room id {room.id} does not fit a 16-bit image, renumber the rooms")
            rows, cols, inside = cells_of_polygon(room.polygon, grid)
            labels[rows, cols][inside] = room.id
        return labels


def _standardise_types(probabilities: Mapping[str, float]) -> dict[str, float]:
    """The probabilities of building types in standard form; those of one type in several spellings are added."""
    standard: defaultdict[str, float] = defaultdict(float)
    for name, probability in probabilities.items():
        key = name
        with suppress(LabelError):  # an invalid name stays as it is; it is in no schema
            key = standard_building_type(name)
        standard[key] += probability
    return dict(standard)
