"""Time the graph kernels against GraKeL's, in ratios of processor time on one core (docs/methods/graph-kernels.md).

Run: OMP_NUM_THREADS=1 python benchmarks/time_graph_kernels.py [--sample N]. Needs GraKeL (pianta[dev], Python < 3.13);
about half a minute. The exit code is 1 if the ratio of a kernel is below its least one.

300 graphs of 7 to 100 nodes, trees with some cycles, as buildings have. Kernels of pianta are timed from networkx
graphs to the Gram matrix, those of GraKeL from its own graphs, which exist already. GraKeL's Graph Hopper takes
minutes, so both kernels get a sample of the graphs.
"""

from __future__ import annotations

import argparse
import sys
import time
import warnings
from collections.abc import Callable, Iterable
from random import Random

import grakel
import networkx as nx

from pianta.graphs.gaussian_hopper import GaussianGraphHopper
from pianta.graphs.graph_hopper import GraphHopper
from pianta.graphs.nspdk import NeighborhoodPairs
from pianta.graphs.weisfeiler_lehman import WeisfeilerLehman

GRAPHS = 300
SMALLEST = 7  # rooms of a graph
LARGEST = 100  # rooms of a graph
LABELS = "ABCDEFGH"
# Runs of each kernel of pianta; the fastest counts.
RUNS = 3


def main() -> None:
    """Print a row for each kernel."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sample", type=int, default=20, help="graphs for Graph Hopper [20]")
    sample = slice(parser.parse_args().sample)
    warnings.simplefilter("ignore")
    random = Random(0)  # noqa: S311
    graphs = [make_graph(random.randint(SMALLEST, LARGEST), random) for _ in range(GRAPHS)]
    named, numbered, one_hot = (to_grakel(graphs, get_label) for get_label in (get_name, get_numbers, get_one_hot))
    subtree = grakel.WeisfeilerLehman(n_iter=5, base_graph_kernel=grakel.VertexHistogram, normalize=True)
    pairs = grakel.NeighborhoodSubgraphPairwiseDistance(r=2, d=3, normalize=True)
    hopper = grakel.GraphHopper(normalize=True, kernel_type="linear")
    gaussian = grakel.GraphHopper(normalize=True, kernel_type=("gaussian", 0.1))
    rows = [
        ("WL, 5 iterations", WeisfeilerLehman(), graphs, subtree, named, 1),
        ("NSPDK, r 2, d 3", NeighborhoodPairs(), graphs, pairs, named, 5),
        ("Graph Hopper, labels", GraphHopper(), graphs[sample], hopper, one_hot[sample], 50),
        ("Graph Hopper, Gaussian", GaussianGraphHopper(gamma=0.1), graphs[sample], gaussian, numbered[sample], 50),
    ]
    print(f"{'kernel':24}{'graphs':>8}{'pianta, s':>10}{'GraKeL, s':>11}{'ratio':>8}")
    missed = False
    for name, kernel, own_graphs, other, grakel_graphs, least in rows:
        own_time = min(
            measure(lambda kernel=kernel, own_graphs=own_graphs: kernel.fit(own_graphs).compare()) for _ in range(RUNS)
        )
        grakel_time = measure(lambda other=other, grakel_graphs=grakel_graphs: other.fit_transform(grakel_graphs))
        missed |= grakel_time < least * own_time
        print(
            f"{name:24}{len(own_graphs):8}{own_time:10.3f}{grakel_time:11.2f}{grakel_time / own_time:8.1f}",
            flush=True,
        )
    for kernel in (GraphHopper(), GaussianGraphHopper(gamma=0.1)):
        own_time = measure(lambda kernel=kernel: kernel.fit(graphs).compare())
        print(f"{type(kernel).__name__:24}{len(graphs):8}{own_time:10.3f}")
    sys.exit(missed)


def measure(run: Callable[[], object]) -> float:
    """Processor time of one run, s."""
    started = time.process_time()
    run()
    return time.process_time() - started


def make_graph(size: int, random: Random) -> nx.Graph:
    """A tree with a cycle for every six nodes, with labels and three numbers."""
    graph = nx.Graph((node, random.randrange(node)) for node in range(1, size))
    graph.add_edges_from(random.sample(range(size), 2) for _ in range(size // 6))
    for node in graph:
        graph.nodes[node].update(label=random.choice(LABELS), features=[random.gauss(0, 1) for _ in range(3)])
    return graph


def to_grakel(graphs: Iterable[nx.Graph], get_label: Callable[[dict[str, object]], object]) -> list[grakel.Graph]:
    """The same graphs for GraKeL."""
    return [
        grakel.Graph(
            {node: list(graph[node]) for node in graph},
            node_labels={node: get_label(data) for node, data in graph.nodes(data=True)},
            edge_labels={edge: "door" for one, other in graph.edges for edge in ((one, other), (other, one))},
        )
        for graph in graphs
    ]


def get_name(data: dict[str, object]) -> object:
    """The label as it is."""
    return data["label"]


def get_one_hot(data: dict[str, object]) -> object:
    """The label as a vector whose product with another is 1 where they are the same, else 0."""
    return [float(label == data["label"]) for label in LABELS]


def get_numbers(data: dict[str, object]) -> object:
    """The vector."""
    return data["features"]


if __name__ == "__main__":
    main()
