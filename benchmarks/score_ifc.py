"""Score what pianta reads from IFC files against what IfcOpenShell alone says of them.

Run: OMP_NUM_THREADS=1 python benchmarks/score_ifc.py [FILE.ifc ...] [--data DIR]

Without files those of `planfiles/ifc` are read. Spaces, doors and storeys are matched by their GlobalIds. The true area
of a space is the sum of the faces of its body that look down, from above; a space is exact within 0.1 %. A virtual
boundary counts where its two spaces, which share an element or are paired, are on one storey. Doors that lead from a
room to the same room, or from no room, are in no floor, so fewer doors than the file has may be right.
Rooms from walls: the spaces of a file are hidden, and rooms that walls enclose are compared with them, a room being
right with an IoU of 0.7. The rooms of files without spaces were counted by eye on pictures of their walls.
"""

from __future__ import annotations

import argparse
import warnings
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from pianta.errors import PiantaError
from pianta.floor import Room
from pianta.io.drawings.ifc import IfcStorey, read_ifc_plan
from pianta_bench.data.folders import find_data

MAX_AREA_ERROR = 1e-3  # share; the bar of issue 26
MIN_IOU = 0.7  # of a room that is right; as in the review of plans
# Rooms that a person counts on each storey, from below.
COUNTED = {"bbri_house_ifc4.ifc": (3, 7, 5, 2)}


@dataclass(frozen=True)
class Share:
    """How many of all are right."""

    right: int
    total: int

    def __str__(self) -> str:
        """As in 7/8."""
        return f"{self.right}/{self.total}"


def main() -> None:
    """Print a line for each file."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("files", nargs="*", type=Path, metavar="FILE")
    parser.add_argument("--data", type=Path, help="folder of the data; $PIANTA_DATA, or ../shared/data, unless given")
    options = parser.parse_args()
    warnings.simplefilter("ignore")
    for file in options.files or sorted((find_data(options.data) / "planfiles" / "ifc").glob("*.ifc")):
        try:
            scores = score_file(file)
        except PiantaError as error:
            print(f"{file.name}: refused: {error}")
        else:
            print(f"{file.name}: " + ", ".join(f"{what} {share}" for what, share in scores.items()))


def score_file(file: Path) -> dict[str, Share]:
    """The shares of a file that are right."""
    import ifcopenshell

    storeys, model = read_ifc_plan(file), ifcopenshell.open(file)
    if not model.by_type("IfcSpace"):
        counts, true = [len(storey.floor) for storey in storeys], COUNTED.get(file.name, ())
        right = sum(map(min, counts, true)) if len(counts) == len(true) else 0
        return {"rooms": Share(right, sum(true)), "doors": _score_doors(storeys, model)}
    rooms = {room.global_id: room for storey in storeys for room in storey.floor}
    spaces = [space for space in model.by_type("IfcSpace") if _has_body(space)]
    pairs = [(space, rooms[space.GlobalId]) for space in spaces if space.GlobalId in rooms]
    return {
        "spaces": Share(len(pairs), len(spaces)),
        "numbers": Share(sum(room.number == _clean(space.Name) for space, room in pairs), len(spaces)),
        "names": Share(sum(_has_name(space, room) for space, room in pairs), len(spaces)),
        "areas": Share(sum(_is_exact(space, room) for space, room in pairs), len(spaces)),
        "doors": _score_doors(storeys, model),
        "storeys": _score_storeys(storeys, model),
        "virtual boundaries": _score_boundaries(storeys, model),
        "rooms from walls": score_walls(model, storeys),
    }


def score_walls(model: Any, storeys: list[IfcStorey]) -> Share:  # noqa: ANN401  # made by a library without types
    """The rooms of spaces that walls alone give, of all; spaces that are open to each other are one room."""
    for space in model.by_type("IfcSpace"):
        model.remove(space)
    with TemporaryDirectory() as folder:
        model.write(str(Path(folder) / "walls.ifc"))
        try:
            walled = read_ifc_plan(Path(folder) / "walls.ifc")
        except PiantaError:
            walled = []
    outlines = [room.polygon for storey in walled for room in storey.floor]
    true = [shape for storey in storeys for shape in _join_open(storey)]
    right = [
        any(shape.intersection(each).area >= MIN_IOU * shape.union(each).area for each in outlines) for shape in true
    ]
    return Share(sum(right), len(true))


def _join_open(storey: IfcStorey) -> Iterator[Any]:
    """The shapes of rooms, those with openings between them as one."""
    import networkx as nx
    import shapely

    graph = nx.Graph()
    graph.add_nodes_from(room.id for room in storey.floor if room.flag is None)
    openings = (door.rooms for door in storey.floor.doors if door.kind == "opening" and door.joins_rooms)
    graph.add_edges_from(rooms for rooms in openings if set(rooms) <= set(graph))
    for part in nx.connected_components(graph):
        yield shapely.union_all([storey.floor[room].polygon for room in part])


def _has_body(space: Any) -> bool:  # noqa: ANN401
    return space.Representation is not None and getattr(space, "PredefinedType", None) != "GFA"


def _clean(text: str | None) -> str | None:
    return " ".join((text or "").split()) or None


def _has_name(space: Any, room: Room) -> bool:  # noqa: ANN401
    return room.name == _clean(space.LongName) or (space.LongName is None and room.name in {None, _clean(space.Name)})


def _is_exact(space: Any, room: Room) -> bool:  # noqa: ANN401
    """Whether the area is that of the faces which look down."""
    from ifcopenshell import geom

    settings = geom.settings()
    settings.set("use-world-coords", True)  # noqa: FBT003
    shape: Any = geom.create_shape(settings, space)
    corners = np.array(shape.geometry.verts, float).reshape(-1, 3)
    triangles = corners[np.array(shape.geometry.faces, int).reshape(-1, 3)]
    normals = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    area = -normals[normals[:, 2] < 0, 2].sum() / 2
    return bool(abs(room.polygon.area - area) <= MAX_AREA_ERROR * area)


def _score_doors(storeys: list[IfcStorey], model: Any) -> Share:  # noqa: ANN401
    identifiers = {door.global_id for storey in storeys for door in storey.floor.doors}
    doors = {door.GlobalId for door in model.by_type("IfcDoor")}
    return Share(len(identifiers & doors), len(doors))


def _score_storeys(storeys: list[IfcStorey], model: Any) -> Share:  # noqa: ANN401
    """Storeys with spaces that have their name and elevation."""
    from ifcopenshell.util.unit import calculate_unit_scale

    scale = calculate_unit_scale(model)
    true = {
        storey.GlobalId: (_clean(storey.Name), (storey.Elevation or 0) * scale)
        for storey in model.by_type("IfcBuildingStorey")
        if any(part.is_a("IfcSpace") for relation in storey.IsDecomposedBy for part in relation.RelatedObjects)
    }
    read = {storey.floor.global_id: (storey.name, storey.elevation) for storey in storeys}
    return Share(sum(read.get(key) == value for key, value in true.items()), len(true))


def _score_boundaries(storeys: list[IfcStorey], model: Any) -> Share:  # noqa: ANN401
    """Pairs of spaces of one storey with a virtual boundary between them that an opening joins."""
    storey_of = {room.global_id: number for number, storey in enumerate(storeys) for room in storey.floor}
    pairs = set()
    for boundary in model.by_type("IfcRelSpaceBoundary"):
        if boundary.PhysicalOrVirtualBoundary == "VIRTUAL" and boundary.RelatingSpace is not None:
            element, paired = boundary.RelatedBuildingElement, getattr(boundary, "CorrespondingBoundary", None)
            sides = [paired] if paired else element.ProvidesBoundaries if element else []
            ends = {each.RelatingSpace.GlobalId for each in (*sides, boundary)}
            if len(ends) == 2 and len({storey_of.get(end) for end in ends}) == 1:
                pairs.add(frozenset(ends))
    joined = {
        frozenset(storey.floor[room].global_id for room in door.room_ids)
        for storey in storeys
        for door in storey.floor.doors
    }
    return Share(len(pairs & joined), len(pairs))


if __name__ == "__main__":
    main()
