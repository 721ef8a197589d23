"""Floor, Room, Door and Furniture: the building, which is the input and output of every stage."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Literal, TypeVar

import networkx as nx
import numpy as np
from numpy.typing import NDArray
from shapely import LineString, Polygon, get_coordinates
from shapely.affinity import scale
from shapely.geometry.polygon import orient

from pianta._types import Floats, Mask
from pianta.errors import FloorError, LabelError
from pianta.gridmap import GridMap
from pianta.labels import standard_building_type

if TYPE_CHECKING:
    from geopandas import GeoDataFrame
    from matplotlib.axes import Axes

Shape = TypeVar("Shape", LineString, Polygon)

DOOR_WIDTH = 0.9  # metres, of a usual door; by definition the distance that scales the layout XMLs of the thesis
MAX_LABEL_IMAGE_ID = np.iinfo(np.uint16).max
MAX_ROOM_NAME_LENGTH = 200  # characters


@dataclass(frozen=True)
class Room:
    """A room: one connected polygon, possibly with holes.

    Parameters
    ----------
    id
        Positive, unique on its floor.
    polygon
        Metres in the map frame; the shell is stored counter-clockwise, holes clockwise.
    label
        The purpose of the room, its most specific label; None if unknown.
    labels
        Label set -> label, from the coarsest set to the finest; empty if unknown.
    label_probabilities
        Label set -> label -> probability, empty if unknown.
    partial
        Whether the room borders on unexplored space; the polygon is its explored part.
    predicted
        The predicted complete polygon of a partial room, metres in the map frame, stored like the polygon; None if
        unknown.
    confidence
        The expected IoU of the predicted polygon with the true one, 0 … 1; None if unknown.
    name
        The name of this room in the building, such as "204 French"; None if unknown.
    probability
        The probability that this is one true room, i.e. that a true room has an IoU of at least 0.6 with it; None if
        unknown.

    Raises
    ------
    FloorError
        The id is not positive, a polygon is empty or invalid, a probability or the confidence is not in [0, 1], a room
        that is not partial is predicted, a confidence is given without a prediction, or the name is not of 1 to 200
        characters that can be printed.

    Examples
    --------
    >>> import pianta
    >>> from shapely import box
    >>> room = pianta.Room(1, box(0, 0, 4, 3), "OFFICE", name="204")
    >>> room.label, room.polygon.area
    ('OFFICE', 12.0)
    """

    id: int
    polygon: Polygon
    label: str | None = None
    labels: Mapping[str, str] = field(default_factory=dict)
    label_probabilities: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    partial: bool = False
    predicted: Polygon | None = None
    confidence: float | None = None
    name: str | None = None
    probability: float | None = None

    def __post_init__(self) -> None:
        if self.id < 1:
            raise FloorError(f"room id is {self.id}, give a positive integer")
        _check_probability(self.probability, f"room {self.id}")
        if not isinstance(self.polygon, Polygon) or self.polygon.is_empty or not self.polygon.is_valid:
            raise FloorError(f"room {self.id} has no valid polygon, repair it with shapely.make_valid")
        object.__setattr__(self, "polygon", orient(self.polygon))
        self._check_prediction()
        self._check_name()
        for label_set, probabilities in self.label_probabilities.items():
            if not isinstance(probabilities, Mapping):
                raise FloorError(f"room {self.id} has {probabilities!r} for {label_set!r}, give label -> probability")
            for label, probability in probabilities.items():
                if not 0 <= probability <= 1:
                    raise FloorError(f"room {self.id} is {label!r} with probability {probability}, give 0 to 1")
        object.__setattr__(self, "labels", dict(self.labels))
        object.__setattr__(self, "label_probabilities", _copy_probabilities(self.label_probabilities))

    def _check_prediction(self) -> None:
        """Orient the predicted polygon; FloorError if it or the confidence is invalid, or the room is not partial."""
        if self.predicted is None and self.confidence is None:
            return
        if not self.partial:
            raise FloorError(f"room {self.id} is predicted and not partial, set partial or leave the prediction out")
        if not isinstance(self.predicted, Polygon) or self.predicted.is_empty or not self.predicted.is_valid:
            raise FloorError(f"room {self.id} has no valid predicted polygon, repair it with shapely.make_valid")
        if self.confidence is not None and not 0 <= self.confidence <= 1:
            raise FloorError(f"room {self.id} is predicted with confidence {self.confidence}, give 0 to 1")
        object.__setattr__(self, "predicted", orient(self.predicted))

    def _check_name(self) -> None:
        """Raise FloorError unless the name is None, or printable, not blank and at most MAX_ROOM_NAME_LENGTH long."""
        if self.name is None:
            return
        name = f"{str(self.name)[:20]!r}"
        if not isinstance(self.name, str) or not self.name.strip() or len(self.name) > MAX_ROOM_NAME_LENGTH:
            raise FloorError(f"room {self.id} has the name {name}, give 1 to {MAX_ROOM_NAME_LENGTH} characters or None")
        if not self.name.isprintable():
            raise FloorError(f"room {self.id} has the name {name} with characters that cannot be printed, drop them")

    @property
    def label_probability(self) -> float | None:
        """The probability of its label, in the finest label set with one; None if unknown."""
        for label_set in [*reversed([*self.labels]), *reversed([*self.label_probabilities])]:
            probabilities = self.label_probabilities.get(label_set, {})
            if self.label is not None and self.label in probabilities:
                return probabilities[self.label]
        return None


@dataclass(frozen=True)
class Door:
    """A passage between two rooms, or an entrance: a passage between a room and the outside.

    Parameters
    ----------
    rooms
        The ids of the two rooms, stored with the smaller one first; (3, None) is an entrance to room 3.
    line
        The passage from jamb to jamb, metres in the map frame.
    width
        Clear width, metres.
    kind
        "door", or "opening" if there is much less wall between the rooms than beside a door.
    probability
        The probability that there is a true door or opening; None if unknown.

    Raises
    ------
    FloorError
        The rooms are not two different ones or one and None, the width is negative, or the probability is not in
        [0, 1].

    Examples
    --------
    >>> import pianta
    >>> from shapely import LineString
    >>> door = pianta.Door((3, None), LineString([(0, 1), (0, 2)]), 1.0)
    >>> door.is_entrance, door.room_ids
    (True, (3,))
    """

    rooms: tuple[int, int | None]
    line: LineString
    width: float
    kind: Literal["door", "opening"] = "door"
    probability: float | None = None

    def __post_init__(self) -> None:
        ids = sorted(room_id for room_id in self.rooms if room_id is not None)
        if not ids:
            raise FloorError("a door leads from no room to no room, give one room or two")
        if len(ids) == 2 and ids[0] == ids[1]:
            raise FloorError(f"a door joins room {ids[0]} to itself, give two rooms")
        what = f"door between rooms {ids[0]} and {ids[1]}" if len(ids) == 2 else f"entrance to room {ids[0]}"
        if not self.width >= 0:
            raise FloorError(f"{what} has width {self.width}, give metres")
        _check_probability(self.probability, what)
        object.__setattr__(self, "rooms", (ids[0], ids[1] if len(ids) == 2 else None))

    @property
    def room_ids(self) -> tuple[int, ...]:
        """The ids of the rooms that it leads to: two, or the one of an entrance."""
        first, second = self.rooms
        return (first,) if second is None else (first, second)

    @property
    def is_entrance(self) -> bool:
        """Whether it leads outside."""
        return self.rooms[1] is None

    def renumber_rooms(self, new_ids: Mapping[int, int]) -> Door:
        """The same door between rooms that have new ids.

        Parameters
        ----------
        new_ids
            Old id -> new id, for each room of the door.

        Returns
        -------
        Door
            The door; its line, width and kind are the same.

        Raises
        ------
        KeyError
            A room of the door has no new id.
        """
        first, second = self.rooms
        return replace(self, rooms=(new_ids[first], None if second is None else new_ids[second]))


@dataclass(frozen=True)
class Furniture:
    """Something that stands in a room and is no wall: a piece of furniture, several that touch, a plant, a person.

    Parameters
    ----------
    polygon
        What the map shows of it, metres in the map frame; the shell is stored counter-clockwise, holes clockwise.
    probability
        The probability that it is furniture and no wall; None if unknown.

    Raises
    ------
    FloorError
        The polygon is empty or invalid, or the probability is not in [0, 1].

    Examples
    --------
    >>> import pianta
    >>> from shapely import box
    >>> table = pianta.Furniture(box(1, 1, 2, 1.5), 0.9)
    >>> table.polygon.area
    0.5
    """

    polygon: Polygon
    probability: float | None = None

    def __post_init__(self) -> None:
        if not isinstance(self.polygon, Polygon) or self.polygon.is_empty or not self.polygon.is_valid:
            raise FloorError("a piece of furniture has no valid polygon, repair it with shapely.make_valid")
        _check_probability(self.probability, "a piece of furniture")
        object.__setattr__(self, "polygon", orient(self.polygon))


@dataclass(frozen=True)
class Floor:
    """One floor of a building, in metres of the map frame.

    `floor[3]` is the room with the id 3, `len(floor)` the number of rooms, `for room in floor` iterates over the rooms,
    and `3 in floor` is whether a room has the id 3. A notebook shows a floor as its picture.

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

    def __post_init__(self) -> None:
        for name in ("rooms", "doors", "walls", "furniture", "possible_doors"):
            object.__setattr__(self, name, tuple(getattr(self, name)))
        object.__setattr__(self, "building_type", _standardise_types(self.building_type))
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
        """The floor as a notebook shows it; None for one without rooms."""
        from pianta.plot.floor import render_floor

        return render_floor(self) if self.rooms else None

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

    def to_geodataframe(
        self, layer: Literal["rooms", "doors", "walls", "furniture", "possible_doors"] = "rooms"
    ) -> GeoDataFrame:
        """One layer of the floor as a GeoDataFrame, in metres of the map frame, without a coordinate system.

        Parameters
        ----------
        layer
            "rooms": polygons; the index is the id, the columns name, label, label_probability, partial, area (m²) and
            probability.
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
            Nodes are the ids of the rooms, with the attributes `name`, `label`, `labels`, `label_probabilities`, `area`
            (m²), `x`, `y` (m; a point inside the room), `partial`, `predicted_area` (m²) and `confidence`, both None
            unless the room is predicted, `entrances` (their number) and `probability` (that it is one true room; None
            if unknown). Edges have `doors` (their number), `width` and `probability` (m, and None if unknown, of the
            widest), and `x`, `y` (m, the middle of the widest). The graph has `source`.

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
                name=room.name,
                label=room.label,
                labels=dict(room.labels),
                label_probabilities=_copy_probabilities(room.label_probabilities),
                area=room.polygon.area,
                x=inside.x,
                y=inside.y,
                partial=room.partial,
                predicted_area=room.predicted.area if room.predicted else None,
                confidence=room.confidence,
                entrances=entrances[room.id],
                probability=room.probability,
            )
        inner_doors = (door for door in self.doors if not door.is_entrance)
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


def scale_floor(floor: Floor, x_factor: float, y_factor: float) -> Floor:
    """The floor with all lengths multiplied by a factor along each axis; the width of a door scales with its line.

    The width of a door whose line is a point scales by the geometric mean of the factors.
    """
    mean_factor = (x_factor * y_factor) ** 0.5

    def scale_shape(shape: Shape) -> Shape:
        larger: Shape = scale(shape, x_factor, y_factor, origin=(0, 0))
        return larger

    def scale_door(door: Door) -> Door:
        line, length = scale_shape(door.line), door.line.length
        return replace(door, line=line, width=door.width * (line.length / length if length else mean_factor))

    def scale_room(room: Room) -> Room:
        predicted = scale_shape(room.predicted) if room.predicted else None
        return replace(room, polygon=scale_shape(room.polygon), predicted=predicted)

    return replace(
        floor,
        rooms=tuple(map(scale_room, floor.rooms)),
        doors=tuple(map(scale_door, floor.doors)),
        walls=tuple(map(scale_shape, floor.walls)),
        furniture=tuple(replace(piece, polygon=scale_shape(piece.polygon)) for piece in floor.furniture),
        possible_doors=tuple(map(scale_door, floor.possible_doors)),
    )


def _check_probability(probability: float | None, what: str) -> None:
    """Raise FloorError for a probability that is not in [0, 1]; what: the noun of the message."""
    if probability is not None and not 0 <= probability <= 1:
        raise FloorError(f"{what} has probability {probability}, give 0 to 1")


def _standardise_types(probabilities: Mapping[str, float]) -> dict[str, float]:
    """The probabilities of building types in standard form; those of one type in several spellings are added."""
    standard: defaultdict[str, float] = defaultdict(float)
    for name, probability in probabilities.items():
        key = name
        with suppress(LabelError):  # an invalid name stays as it is; it is in no schema
            key = standard_building_type(name)
        standard[key] += probability
    return dict(standard)


def _copy_probabilities(probabilities: Mapping[str, Mapping[str, float]]) -> dict[str, dict[str, float]]:
    """A copy in types of Python, which JSON can hold."""
    return {
        label_set: {label: float(probability) for label, probability in by_label.items()}
        for label_set, by_label in probabilities.items()
    }


def cells_of_polygon(polygon: Polygon, grid: GridMap) -> tuple[slice, slice, Mask]:
    """The cells whose centres are in a polygon: a window of rows and columns, and the mask in it.

    Even-odd scan conversion: each ring edge toggles the cells to the right of its crossing with a row of cell centres,
    so polygons that share an edge never share a cell.
    """
    starts, ends = _ring_edges(polygon, grid)
    height, width = grid.shape
    corners = np.vstack([starts, ends])
    top, left = np.maximum(np.floor(corners.min(axis=0)).astype(int), 0)
    bottom, right = np.minimum(np.ceil(corners.max(axis=0)).astype(int) + 1, (height, width))
    if bottom <= top or right <= left:
        return slice(0, 0), slice(0, 0), np.zeros((0, 0), bool)
    toggles = np.zeros((bottom - top, right - left + 1), np.int32)
    for edge in zip(starts.tolist(), ends.tolist(), strict=True):
        # From top to bottom, so that a common edge of two polygons crosses the same cells in both.
        (row0, col0), (row1, col1) = sorted(edge)
        first, last = np.ceil(np.clip((row0, row1), top, bottom)).astype(int)
        if first == last:
            continue
        rows = np.arange(first, last)
        crossings = col0 + (rows - row0) * (col1 - col0) / (row1 - row0)
        cols = np.clip(np.ceil(crossings), left, right).astype(int)
        toggles[rows - top, cols - left] += 1
    inside = np.cumsum(toggles, axis=1)[:, :-1] % 2 == 1
    return slice(top, bottom), slice(left, right), inside


def _ring_edges(polygon: Polygon, grid: GridMap) -> tuple[Floats, Floats]:
    """Starts and ends, shape (N, 2), of all ring edges as row, col where cell centres are integers."""
    starts, ends = [], []
    for ring in (polygon.exterior, *polygon.interiors):
        xy = get_coordinates(ring)
        pixels = np.column_stack(grid.map_to_pixel(xy[:, 0], xy[:, 1])) - 0.5
        starts.append(pixels[:-1])
        ends.append(pixels[1:])
    return np.concatenate(starts), np.concatenate(ends)
