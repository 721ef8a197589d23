"""Small literal schools as graphs, and models of them: what the tests of generation learn from."""

from functools import cache

import networkx as nx

from pianta.generation.functional_areas import Segmentation
from pianta.generation.type_model import TypeFloor, TypeModel, learn_type
from pianta.labels import SCHEMAS

SCHOOL = SCHEMAS["school"]

# A wing is a corridor and the rooms at it; C classroom, S storage, T bathroom, G gym, A administration.
LABELS = {"C": "CLASSROOM", "S": "CLOSET", "T": "BATHROOM", "G": "GYM", "A": "SMALL ADMINISTRATIVE"}
# The wings of each school, and which of them a door joins.
WINGS: dict[str, tuple[tuple[str, ...], tuple[tuple[int, int], ...]]] = {
    "a": (("CCCCT", "AAS"), ((0, 1),)),
    "b": (("CCCT", "CCCS", "AAS"), ((0, 1), (1, 2))),
    "c": (("CCCCCT", "GSS", "AA"), ((0, 1), (0, 2))),
    "d": (("CCCCS", "CCCCT", "AAS", "GS"), ((0, 1), (1, 2), (2, 3), (0, 3))),
    "e": (("CCCT", "AAT"), ((0, 1),)),
    "f": (("CCCCT", "CCCS", "GSS"), ((0, 1), (1, 2), (0, 2))),
    "g": (("CCT", "AAS", "AA"), ((0, 1), (1, 2))),
    "h": (("CCCCCS", "CCCT"), ((0, 1),)),
}

# Areas of rooms, m².
AREAS = {"CLASSROOM": 60.0, "CORRIDOR": 70.0, "CLOSET": 6.0, "BATHROOM": 12.0, "GYM": 400.0}
OTHER_AREA = 25.0


def make_wing(rooms: str, *, first: int = 0, hub: str = "CORRIDOR") -> nx.Graph:
    """A corridor, node `first`, with a door to each room, the nodes after it."""
    graph = nx.star_graph(range(first, first + len(rooms) + 1))
    labels = [hub, *(LABELS[room] for room in rooms)]
    nx.set_node_attributes(graph, dict(enumerate(labels, first)), "label")
    return graph


def join_wings(wings: tuple[str, ...], doors: tuple[tuple[int, int], ...], *, source: str) -> nx.Graph:
    """Wings with their corridors joined, rooms 0, 1, 2, …"""
    graph = nx.Graph(source=source)
    hubs = []
    for rooms in wings:
        hubs.append(len(graph))
        graph.update(make_wing(rooms, first=len(graph)))
    graph.add_edges_from((hubs[one], hubs[other]) for one, other in doors)
    return graph


def make_schools() -> list[nx.Graph]:
    """Eight schools of 9 to 19 rooms."""
    return [join_wings(*WINGS[name], source=f"school {name}.xml") for name in WINGS]


@cache
def small_model(segmentation: Segmentation = Segmentation.CORR) -> TypeModel:
    """The model of the eight schools."""
    return learn_type(make_schools(), SCHOOL, segmentation=segmentation)


@cache
def sized_model() -> TypeModel:
    """The model of the eight schools, each room with the area of its label."""
    schools = make_schools()
    for school in schools:
        for _, room in school.nodes(data=True):
            room["area"] = AREAS.get(room["label"], OTHER_AREA)
    return learn_type(schools, SCHOOL)


def build_floor(wings: tuple[str, ...], doors: tuple[tuple[int, int], ...], clusters: tuple[int, ...]) -> TypeFloor:
    """A floor whose areas are the wings, of given clusters."""
    graph = join_wings(wings, doors, source="".join(wings))
    hubs = [node for node, label in graph.nodes(data="label") if label == "CORRIDOR"]
    ends = [*hubs[1:], len(graph)]
    areas = tuple(frozenset(range(hub, end)) for hub, end in zip(hubs, ends, strict=True))
    return TypeFloor(graph.graph["source"], graph, areas, clusters)
