"""The sampler of section 8.3 as it is printed: section 7.4.3 with known areas, edges and doors that stay.

It differs from `FloorSampler` in what it ignores: how many open ends are left, what was behind doors of rooms with the
same label, and which known rooms have all of their doors.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import networkx as nx
import numpy as np

from pianta.generation.cluster_configuration import EMPTY, AreaChains, DistanceCost, Slots, sample_areas
from pianta.generation.constraints import Constraints
from pianta.generation.cut_potentials import CutPotentials
from pianta.generation.functional_areas import Area
from pianta.generation.type_model import TypeModel, area_subgraph, count_labels
from pianta.prediction.area_plan import AreaPlan, plan_areas
from pianta.prediction.explored_part import ExploredPart
from pianta.prediction.unexplored_part import FloorSampler


class PrintedSampler(FloorSampler):
    """Samples floors around explored parts as section 8.3 prints it.

    Raises OptionError and ModelError as FloorSampler.
    """

    closed = False

    def __init__(self, model: TypeModel) -> None:
        super().__init__(model)
        self.edge_moves, self.door_moves = model.edge_moves, model.door_moves

    @property
    def door_counts(self) -> list[int]:
        """One door for each edge between areas."""
        return [1]

    @cached_property
    def potentials(self) -> CutPotentials:
        """Φ of step 4."""
        return CutPotentials(self.model, closing=False)

    def plan_floors(
        self,
        explored: ExploredPart,
        known_areas: Sequence[Area],
        clusters: Sequence[int],
        generators: Sequence[np.random.Generator],
    ) -> list[AreaPlan]:
        """Steps 1 and 3: Γ1 of section 7.4.3, with at least the known areas of each cluster.

        Every unopened door leads to a sampled area.
        """
        areas = [area_subgraph(explored.graph, area) for area in known_areas]
        branches = dict.fromkeys(explored.doors)
        return [
            plan_areas(
                explored,
                known_areas,
                [*map(str, clusters)],
                chosen=[self.new_areas[area] for area in chosen],
                branches=branches,
                generator=generator,
            )
            for chosen, generator in zip(
                sample_further_areas(self.model, areas, clusters, generators), generators, strict=True
            )
        ]

    def restore_edges(self, plan: AreaPlan, graph: nx.Graph, generator: np.random.Generator) -> None:
        """Preserve the connections of known areas to unknown rooms: each such area has an edge to a sampled area."""
        new = [*range(plan.n_known, len(plan.areas))]
        for area in plan.doors:
            if not any(graph.has_edge(area, index) for index in new):
                graph.add_edge(area, new[int(generator.integers(len(new)))])


def sample_further_areas(
    model: TypeModel,
    areas: Sequence[nx.Graph],
    clusters: Sequence[int],
    generators: Sequence[np.random.Generator],
) -> list[list[int]]:
    """Step 1 of section 7.4.3 for a floor with known areas: the indices of further areas of the model, at least one.

    areas: the known ones. clusters: of each. The number of areas of a cluster is between the number of known ones and
    the most areas of any floor.
    """
    known_counts = np.bincount(np.array(clusters, np.intp), minlength=model.configurations.shape[1])
    most = np.maximum(model.configurations.max(axis=0), known_counts)
    if (most == known_counts).all():
        most = known_counts + 1
    first = len(model.areas)
    fixed = tuple(
        tuple(first + number for number, own in enumerate(clusters) if own == cluster)
        for cluster in range(len(known_counts))
    )
    slots = Slots(model, most, fixed)
    starts = model.configurations[[int(generator.integers(len(model.floors))) for generator in generators]]
    uniforms = np.stack([generator.random(len(slots.clusters)) for generator in generators])
    chains = AreaChains(
        slots,
        DistanceCost(slots),
        slots.fill(starts, uniforms),
        constraints=Constraints(),
        label_counts=count_labels([*model.areas, *areas], model.schema),
    )
    return [
        [area for area in row if area != EMPTY and area < first] for row in sample_areas(chains, generators).tolist()
    ]
