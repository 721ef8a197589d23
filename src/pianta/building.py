"""A building: its storeys, each a floor with its map, and the stairs and lifts that join them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Literal, TypeAlias, Unpack

import networkx as nx

from pianta.errors import FloorError
from pianta.floor import Floor, Room
from pianta.floor.area_trust import AreaTrust
from pianta.gridmap import GridMap

if TYPE_CHECKING:
    from pianta.io.writers.convert import ConvertOptions

LinkKind: TypeAlias = Literal["stairs", "lift"]


@dataclass(frozen=True, eq=False)
class Storey:
    """A storey of a building.

    Attributes
    ----------
    floor
        Its rooms and doors, in metres of the map frame.
    name
        Its name, unlike those of the other storeys, and that of its folder; "" for the only storey of a building.
    elevation
        Height of its floor above that of the lowest storey, metres; that of the floor if None, None if unknown.
    grid
        Its map; None without one.
    title
        What people call it, such as "Ground floor"; the title of the floor if empty, else its name.
    area_trust
        Whether the scale of its plan is certain enough for areas: "exact", as for every map, "rough" or "unknown".
    """

    floor: Floor
    name: str = ""
    elevation: float | None = None
    grid: GridMap | None = None
    title: str = ""
    area_trust: AreaTrust = AreaTrust.EXACT

    def __post_init__(self) -> None:
        object.__setattr__(self, "title", self.title or self.floor.title)
        if self.elevation is None:
            object.__setattr__(self, "elevation", self.floor.elevation)
        object.__setattr__(self, "area_trust", AreaTrust(self.area_trust))


@dataclass(frozen=True)
class Link:
    """Stairs or a lift between rooms of two storeys.

    Attributes
    ----------
    kind
        "stairs" or "lift".
    ends
        The name of a storey and the id of a room on it, twice.
    """

    kind: LinkKind
    ends: tuple[tuple[str, int], tuple[str, int]]


@dataclass(frozen=True, eq=False)
class Building:
    """A building of one or several storeys.

    `len(building)` is the number of storeys, and `for storey in building` iterates over them.

    Parameters
    ----------
    storeys
        From the lowest to the highest, as far as their elevations are known; names are unique.
    name
        The name of the building.
    links
        The stairs and lifts between rooms of two storeys.

    Raises
    ------
    FloorError
        There is no storey, names occur twice, or links lead to rooms that do not exist; every fault is in one message.

    Examples
    --------
    >>> import pianta
    >>> floor, grid = pianta.make_world("corridor")
    >>> building = pianta.Building((pianta.Storey(floor, "ground", 0.0, grid), pianta.Storey(floor, "first", 3.2)))
    >>> len(building), len(building.graph())
    (2, 38)
    """

    storeys: tuple[Storey, ...]
    name: str = ""
    links: tuple[Link, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "storeys", tuple(self.storeys))
        object.__setattr__(self, "links", tuple(self.links))
        names = Counter(storey.name for storey in self.storeys)
        faults = [] if self.storeys else ["it has no storey"]
        faults += [f"storey {name!r} occurs more than once" for name, count in names.items() if count > 1]
        rooms = {(storey.name, room.id) for storey in self.storeys for room in storey.floor}
        stray = sorted({end for link in self.links for end in link.ends} - rooms)
        faults += [f"links lead to rooms {stray} that do not exist"] if stray else []
        if faults:
            raise FloorError("not a building: " + "; ".join(faults))

    def __len__(self) -> int:
        """Number of storeys."""
        return len(self.storeys)

    def __iter__(self) -> Iterator[Storey]:
        """The storeys, in their order."""
        return iter(self.storeys)

    @property
    def area_trust(self) -> AreaTrust:
        """That of the storey with the least certain scale."""
        trusts = {storey.area_trust for storey in self.storeys}
        return next(trust for trust in reversed(AreaTrust) if trust in trusts)

    def list_rooms(self) -> Iterator[tuple[Storey, Room]]:
        """List all rooms, storey by storey.

        Yields
        ------
        tuple of Storey and Room
            A room with its storey.
        """
        for storey in self.storeys:
            for room in storey.floor:
                yield storey, room

    def to_file(self, path: str | Path, *, to: str | None = None, **options: Unpack[ConvertOptions]) -> list[str]:
        """Write the building in a format of other programs; see `pianta.convert`.

        Parameters
        ----------
        path
            The file or the folder to write; older ones are replaced, all files or none.
        to
            The format; if None, the one format whose files have the suffix of the path.
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
        >>> floor, grid = pianta.make_world("corridor")
        >>> pianta.Building((pianta.Storey(floor, grid=grid),)).to_file("route.geojson", to="nav2-route")
        []
        """
        from pianta.io.writers.convert import convert

        return convert(self, path, to=to, **options)

    def graph(self) -> nx.Graph:
        """Join the topological graphs of all storeys by the stairs and lifts.

        Returns
        -------
        networkx.Graph
            A node for each room, the name of its storey and its id; nodes and edges have the attributes of
            `Floor.graph`, nodes a `storey` and edges of links a `kind`.
        """
        graph = nx.Graph()
        for storey in self.storeys:
            own = storey.floor.graph()
            graph.add_nodes_from(
                ((storey.name, room), {**data, "storey": storey.name}) for room, data in own.nodes.items()
            )
            graph.add_edges_from(((storey.name, a), (storey.name, b), data) for (a, b), data in own.edges.items())
        graph.add_edges_from((*link.ends, {"kind": link.kind}) for link in self.links)
        return graph
