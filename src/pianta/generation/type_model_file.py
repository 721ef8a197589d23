"""The file of a TypeModel: JSON with the labels of the type, and a line for each floor.

The content of a file is not trusted: it has only numbers and names, which are checked before use. Data that follows
from the floors, such as functional graphs and kernels, is computed again.
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterable
from pathlib import Path
from typing import Annotated, Self

import networkx as nx
from pydantic import AfterValidator, BaseModel, ConfigDict, Field, model_validator

from pianta.errors import LabelError, ModelError
from pianta.generation.functional_areas import Segmentation
from pianta.generation.room_shapes import DOOR_MEASURES, OPENING, ROOM_MEASURES
from pianta.generation.type_model import MAX_ROOMS, MIN_FLOORS, TypeFloor, TypeModel
from pianta.io._checked import FileFormat, read_checked, save_checked
from pianta.io._faults import join_faults, validation_as
from pianta.io._files import short_repr
from pianta.io.label_schemas import dump_label
from pianta.labels import Label, LabelSchema, standard_building_type

FORMAT = FileFormat("pianta type", 1, 3)
# Limits against files that use too much memory or time.
MAX_FILE_BYTES = 16 * 2**20
MAX_FLOORS = 1000
MAX_CLUSTERS = 1000
MAX_ITERATIONS = 100_000
# Floors times clusters times areas of a cluster: the size of a table of the sampler.
MAX_CELLS = 30_000_000
# The lists of a file that have the measures of rooms.
_ROOM_LISTS = {"area": "sizes", "aspect": "aspects", "outer_wall": "outer_walls"}
# The lists of a file that say how doors are.
_DOOR_LISTS = {"width": "widths", OPENING: "openings"}


def save_type_model(model: TypeModel, path: str | Path) -> None:
    """Write a model; equal models give equal bytes, and the model that is read again generates equal buildings.

    Raises ModelError for a model that read_type_model would reject, PiantaError if the file cannot be written.
    """
    save_checked(path, "model", ModelError, lambda: dump_type_model(model))


def read_type_model(path: str | Path) -> TypeModel:
    """Read the model of a building type.

    Raises ModelError, with all faults in one message, for an invalid file and for one of a newer format.
    """
    return read_checked(path, "model", ModelError, _parse_model, max_bytes=MAX_FILE_BYTES)


def _check_type(name: str) -> str:
    """The building type; raises ValueError unless it is in standard form."""
    if standard_building_type(name) != name:
        raise ValueError(f"the building type {short_repr(name)} is not in lower case")
    return name


_Room = Annotated[int, Field(ge=0, lt=MAX_ROOMS)]
_Iterations = Annotated[int, Field(ge=1, le=MAX_ITERATIONS)]
_Size = Annotated[float, Field(gt=0, le=ROOM_MEASURES["area"][1])] | None
_Aspect = Annotated[float, Field(ge=1, le=ROOM_MEASURES["aspect"][1])] | None
_OuterWall = Annotated[float, Field(ge=0, le=ROOM_MEASURES["outer_wall"][1])] | None
_Width = Annotated[float, Field(gt=0, le=DOOR_MEASURES["width"][1])] | None


class _Floor(BaseModel):
    """A floor: labels of rooms, doors and areas as indices of rooms.

    `sizes` of rooms, m², since version 1.1; their `aspects` and `outer_walls`, m, and `widths` of doors, m, since 1.2;
    which doors are `openings` since 1.3.
    """

    model_config = ConfigDict(strict=True)

    source: str
    labels: list[str] = Field(min_length=2, max_length=MAX_ROOMS)
    doors: list[tuple[_Room, _Room]]
    areas: list[Annotated[list[_Room], Field(min_length=1)]] = Field(min_length=1)
    clusters: list[Annotated[int, Field(ge=0, lt=MAX_CLUSTERS)]]
    sizes: list[_Size] = []
    aspects: list[_Aspect] = []
    outer_walls: list[_OuterWall] = []
    widths: list[_Width] = []
    openings: list[bool] = []

    @model_validator(mode="after")
    def _check(self) -> Self:
        if faults := self._find_faults():
            raise ValueError(f"floor {short_repr(self.source)}: {join_faults(faults)}")
        return self

    def _find_faults(self) -> list[str]:
        """Messages about doors, areas, clusters and sizes that contradict each other, and rooms without connection."""
        rooms = len(self.labels)
        faults = []
        if stray := [door for door in self.doors if door[0] == door[1] or max(door) >= rooms]:
            faults.append(f"door {list(stray[0])} is not between two of its {rooms} rooms")
        if len({frozenset(door) for door in self.doors}) != len(self.doors):
            faults.append("a door is given twice")
        if sorted(room for area in self.areas for room in area) != [*range(rooms)]:
            faults.append("not every room is in one area")
        if len(self.clusters) != len(self.areas):
            faults.append(f"{len(self.areas)} areas have {len(self.clusters)} clusters")
        faults += self._find_wrong_lengths()
        if faults:
            return faults
        graph = nx.Graph(self.doors)
        graph.add_nodes_from(range(rooms))
        if not nx.is_connected(graph):
            return ["its rooms are not connected by doors"]
        broken = [number for number, area in enumerate(self.areas) if not nx.is_connected(graph.subgraph(area))]
        return [f"the rooms of area {number} are not connected by doors" for number in broken]

    def _find_wrong_lengths(self) -> list[str]:
        """Messages about lists of measures that are not as long as that of the rooms, or of the doors."""
        lists = [
            *((len(self.labels), "rooms", name) for name in _ROOM_LISTS.values()),
            *((len(self.doors), "doors", name) for name in _DOOR_LISTS.values()),
        ]
        lengths = {name: len(getattr(self, name)) for *_, name in lists}
        return [
            f"{count} {what} have {lengths[name]} {name.replace('_', ' ')}"
            for count, what, name in lists
            if lengths[name] not in {0, count}
        ]

    def to_floor(self) -> TypeFloor:
        """The floor with its graph, areas and clusters, as a TypeModel has it."""
        graph = nx.Graph(source=self.source)
        graph.add_nodes_from((room, {"label": label}) for room, label in enumerate(self.labels))
        graph.add_edges_from(self.doors)
        for attribute, name in _ROOM_LISTS.items():
            for room, value in enumerate(getattr(self, name)):
                graph.nodes[room].update({} if value is None else {attribute: value})
        for attribute, name in _DOOR_LISTS.items():
            for door, value in zip(self.doors, getattr(self, name), strict=False):
                graph.edges[door].update({} if value is None else {attribute: value})
        return TypeFloor(self.source, graph, tuple(map(frozenset, self.areas)), tuple(self.clusters))


class _Model(BaseModel):
    model_config = ConfigDict(strict=True)

    building_type: Annotated[str, AfterValidator(_check_type)]
    segmentation: Annotated[Segmentation, Field(strict=False)]
    sweeps: _Iterations
    edge_moves: _Iterations
    door_moves: _Iterations
    labels: Annotated[tuple[Label, ...], Field(strict=False, min_length=1)]
    floors: list[_Floor] = Field(min_length=MIN_FLOORS, max_length=MAX_FLOORS)

    @model_validator(mode="after")
    def _check(self) -> Self:
        """Raise ValueError for labels that the type lacks, gaps in cluster numbers, and too large a model."""
        names = {label.name for label in self.labels}
        faults = [
            f"floor {short_repr(floor.source)} has labels {', '.join(unknown)} that the type does not have"
            for floor in self.floors
            if (unknown := sorted(set(floor.labels) - names))
        ]
        clusters = {cluster for floor in self.floors for cluster in floor.clusters}
        if clusters != {*range(len(clusters))}:
            faults.append(f"clusters are numbered {min(clusters)} to {max(clusters)} with gaps, number them from 0 on")
        most = max(Counter(floor.clusters).most_common(1)[0][1] for floor in self.floors)
        if len(self.floors) * len(clusters) * most > MAX_CELLS:
            faults.append(
                f"{len(self.floors)} floors with {len(clusters)} clusters, one of them {most} times on a floor, are "
                "too many to sample from"
            )
        if faults:
            raise ValueError(join_faults(faults))
        return self

    def to_model(self) -> TypeModel:
        """The TypeModel that the file describes."""
        return TypeModel(
            LabelSchema(self.building_type, self.labels),
            self.segmentation,
            tuple(floor.to_floor() for floor in self.floors),
            self.sweeps,
            self.edge_moves,
            self.door_moves,
        )


def dump_type_model(model: TypeModel) -> bytes:
    """The content of a model file; raises ModelError if it could not be read again."""
    head = {
        **FORMAT.header,
        "building_type": model.building_type,
        "segmentation": model.segmentation,
        "sweeps": model.sweeps,
        "edge_moves": model.edge_moves,
        "door_moves": model.door_moves,
    }
    labels = [dump_label(label) for label in model.schema.labels]
    floors = [
        {
            "source": floor.source,
            "labels": [label for _, label in floor.graph.nodes(data="label")],
            "doors": [list(door) for door in floor.graph.edges],
            "areas": [sorted(area) for area in floor.areas],
            "clusters": list(floor.clusters),
            **{
                name: _list_measures(value for _, value in floor.graph.nodes(data=attribute))
                for attribute, name in _ROOM_LISTS.items()
            },
            "widths": _list_measures(width for *_, width in floor.graph.edges(data="width")),
            "openings": _list_openings(floor.graph),
        }
        for floor in model.floors
    ]
    lines = [f" {json.dumps(name)}: {json.dumps(value)}" for name, value in head.items()]
    for name, rows in (("labels", labels), ("floors", floors)):
        listed = ",\n".join(f"  {json.dumps(row)}" for row in rows)
        lines.append(f' "{name}": [\n{listed}\n ]')
    content = ("{\n" + ",\n".join(lines) + "\n}\n").encode()
    _parse_model(content)
    return content


def _list_openings(graph: nx.Graph) -> list[bool]:
    """Which doors are openings; none if that is unknown of one."""
    openings = [opening for *_, opening in graph.edges(data=OPENING)]
    return openings if None not in openings else []


def _list_measures(values: Iterable[float | None]) -> list[float | None]:
    """Values in centimetres; none if all are unknown."""
    rounded = [None if value is None else round(value, 2) for value in values]
    return rounded if any(value is not None for value in rounded) else []


@validation_as(ModelError)
def _parse_model(content: bytes) -> TypeModel:
    """The model in the content of a file; raises ModelError with all faults."""
    FORMAT.check_version(content, ModelError)
    try:
        return _Model.model_validate_json(content).to_model()
    except LabelError as exception:
        raise ModelError(str(exception)) from None
