"""Graphs of the real schools, and the samples that the authors of the thesis drew of them."""

import json
from pathlib import Path

import networkx as nx

from pianta.graphs.centrality import drop_isolated
from pianta.io.buildings.thesis_xml import read_building_xml


def read_schools(data: Path) -> list[nx.Graph]:
    """The given schools without isolated rooms, by name of file."""
    files = sorted((data / "buildings" / "school").glob("*.xml"))
    return [drop_isolated(read_building_xml(file).graph()) for file in files]


def read_samples(data: Path) -> list[nx.Graph]:
    """The samples of Table 7.1, by `corr`."""
    graphs = []
    for sample in json.loads((data / "sampled" / "corr_table7_1.json").read_text())["graphs"]:
        graph = nx.Graph()
        graph.add_nodes_from((node["id"], {"label": node["label"]}) for node in sample["nodes"])
        graph.add_edges_from(sample["edges"])
        graphs.append(graph)
    return graphs
