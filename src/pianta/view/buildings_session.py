"""Generated buildings on the page: graphs with their figures."""

from __future__ import annotations

from typing import Any, ClassVar

import networkx as nx

from pianta.gridmap import GridMap
from pianta.io._files import count_noun
from pianta.view.drawn_graphs import count_labels, describe_graph, open_graph
from pianta.view.prediction_session import SAMPLE_COLUMNS, graph_name
from pianta.view.result_sessions import ResultSession

PATTERN = "building-*.json"
# Buildings that the page shows; a limit of time, chosen by hand.
MAX_BUILDINGS = 200


class BuildingsSession(ResultSession[tuple[nx.Graph, ...]]):
    """A folder of `pianta generate`; its parts are the buildings."""

    kind: ClassVar[str] = "generated"
    patterns: ClassVar[tuple[str, ...]] = (PATTERN,)

    def _read(self) -> tuple[nx.Graph, ...]:
        files = sorted(self.folder.glob(PATTERN))[:MAX_BUILDINGS]
        return tuple(open_graph(file) for file in files)

    def _list_facts(self, content: tuple[nx.Graph, ...]) -> list[str]:
        sizes = [len(graph) for graph in content]
        types = {str(graph.graph.get("building_type")) for graph in content if graph.graph.get("building_type")}
        return [count_noun(len(content), "building"), f"{min(sizes)} to {max(sizes)} rooms", *sorted(types)[:1]]

    def _describe(self, content: tuple[nx.Graph, ...], version: str) -> dict[str, Any]:
        del version
        items = [
            {"name": graph_name(graph, index), "figures": count_labels(graph)} for index, graph in enumerate(content)
        ]
        total = sum(1 for _ in self.folder.glob(PATTERN))
        return {"columns": SAMPLE_COLUMNS, "items": items, "total": total}

    def _count_parts(self, content: tuple[nx.Graph, ...]) -> int:
        return len(content)

    def _describe_part(self, content: tuple[nx.Graph, ...], part: int, version: str) -> dict[str, Any]:
        del version
        return describe_graph(content[part])

    def _open_picture(self, content: tuple[nx.Graph, ...], part: int) -> GridMap | None:
        del content, part
        return None
