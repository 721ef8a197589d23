"""Kernels of floors, and of rooms with the floor around them, as in kLog: NSPDK on graphs of facts.

Facts become a bipartite graph, numbers are binned, and NSPDK counts pairs of neighbourhoods in the graph (thesis,
section 6.1.2). A support vector machine learns from the Gram matrix.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, ClassVar, Self

import networkx as nx
import numpy as np

from pianta._types import Floats
from pianta.errors import ModelError, OptionError
from pianta.graphs.feature_counts import FeatureCounts
from pianta.graphs.nspdk import NeighborhoodPairs
from pianta.relational.facts import FLOOR_SIGNATURES, Interpretation, Signature, Value, by_name, check_interpretation
from pianta.relational.graphicalization import Graphicalizer
from pianta.relational.interpretation import FLOOR_RELATIONS

if TYPE_CHECKING:
    from sklearn.svm import SVC


# Chosen by hand; the thesis does not print these. Radius and distance are in edges of the graph of facts.
BINS = 8
RADIUS = 2
DISTANCE = 4
COST = 10.0
# A relation that follows from the labels and is hidden with them.
LABEL_RELATION = "iscorr"
# V_n of section 5.2 by the names of the real files, and the doors between rooms.
ROOM_RELATIONS = tuple(
    relation
    for relation in FLOOR_RELATIONS
    if relation.signature.name not in ("buildingtype", "entrance", "partial", "sharedwall")
)


class RelationalKernel(ABC):
    """A kernel on interpretations: fit it to training interpretations, then compare others with them.

    target: the relation that is to be learnt, which is hidden from the kernel; None for default_target.
    signatures: those of the interpretations. bins: number of quantile bins of numbers in the training set.
    radius, distance: of NSPDK, in edges of the graph of facts; two rooms with a door between them are 2 apart.
    Raises OptionError for a target without a signature.
    """

    default_target: ClassVar[str]
    hidden: ClassVar[tuple[str, ...]] = ()

    def __init__(
        self,
        *,
        target: str | None = None,
        signatures: Iterable[Signature] = FLOOR_SIGNATURES,
        bins: int = BINS,
        radius: int = RADIUS,
        distance: int = DISTANCE,
    ) -> None:
        self.target = target or self.default_target
        self.signatures = by_name(signatures)
        self.bins = bins
        self.pairs = NeighborhoodPairs(radius=radius, distance=distance)
        self._check_target()

    def fit(self, training: Sequence[Interpretation], *, binned: Sequence[Interpretation] | None = None) -> Self:
        """Learn the bins, and store the training interpretations.

        binned: the interpretations whose numbers define the bins; None for the training interpretations.
        Raises RelationError for facts that contradict the signatures.
        """
        hidden = {self.target, *(name for name in self.hidden if name in self.signatures)}
        graphicalizer = Graphicalizer(bins=self.bins, hidden=hidden, signatures=self.signatures.values())
        self.graphicalizer_ = graphicalizer.fit(training if binned is None else binned)
        self.pairs.fit_counts(self._count(training))
        return self

    def compare(self, others: Sequence[Interpretation] | None = None) -> Floats:
        """Normalised Gram matrix, shape (others, training); None: the training interpretations with each other.

        Raises ModelError before `fit`, RelationError for facts that contradict the signatures.
        """
        if not hasattr(self, "graphicalizer_"):
            raise ModelError("the kernel is not fitted, call fit first")
        return self.pairs.compare_counts(None if others is None else self._count(others))

    def check(self, interpretations: Iterable[Interpretation]) -> None:
        """Raise RelationError for facts that contradict the signatures."""
        for each in interpretations:
            check_interpretation(each, self.signatures.values())

    def _check_target(self) -> None:
        if self.target not in self.signatures:
            raise OptionError(f"target is {self.target!r}, give one of {', '.join(self.signatures)}")

    @abstractmethod
    def _count(self, interpretations: Sequence[Interpretation]) -> list[FeatureCounts]:
        """The features of what is compared: a row for each floor or room."""

    def _draw(self, interpretations: Sequence[Interpretation]) -> list[nx.Graph]:
        return self.graphicalizer_.transform(interpretations)


class FloorKernel(RelationalKernel):
    """A kernel of whole floors: all pairs of neighbourhoods in their graphs, a row for each floor."""

    default_target = "buildingtype"

    def _count(self, interpretations: Sequence[Interpretation]) -> list[FeatureCounts]:
        return self.pairs.count_features(self._draw(interpretations))


class RoomKernel(RelationalKernel):
    """A kernel of rooms: the pairs of neighbourhoods that contain a room's node.

    Rooms are the entities of the target, under any name; a row for each, floor by floor.
    Raises OptionError for a target without an entity.
    """

    default_target = "label"
    hidden = (LABEL_RELATION,)

    def _check_target(self) -> None:
        super()._check_target()
        if not self._list_entity_kinds():
            raise OptionError(f"target is {self.target!r}, which has no entity, give a relation of rooms")

    def _list_entity_kinds(self) -> list[str]:
        """The kinds of the entities of the target."""
        return [argument.kind for argument in self.signatures[self.target].arguments if argument.is_entity]

    @property
    def room(self) -> Signature:
        """The signature of rooms."""
        return self.signatures[self._list_entity_kinds()[0]]

    def list_rooms(self, interpretation: Interpretation) -> tuple[Value, ...]:
        """The identifiers of the rooms of a floor, in the order of the rows."""
        return interpretation.entities(self.room)

    def _count(self, interpretations: Sequence[Interpretation]) -> list[FeatureCounts]:
        graphs = self._draw(interpretations)
        return self.pairs.count_rooted_features(graphs, [self.list_rooms(each) for each in interpretations])


def fit_svm(gram: Floats, truth: Sequence[str], *, cost: float = COST) -> SVC:
    """A support vector machine fitted to a Gram matrix, shape (n, n), and n labels.

    Raises ModelError for fewer than two labels.
    """
    from sklearn.svm import SVC

    labels = sorted(set(truth))
    if len(labels) < 2:
        raise ModelError(f"there is only one class: all labels are {labels}, give two at least")
    return SVC(kernel="precomputed", C=cost, break_ties=True).fit(gram, list(truth))


def decide(machine: SVC, gram: Floats, labels: Sequence[str]) -> Floats:
    """Decision values of labels, shape (n, labels); the highest is the decision. gram: shape (n, training).

    A label that the machine was not trained on has the lowest value of the row, less one.
    """
    # scikit-learn raises for an empty matrix.
    if len(gram) == 0:
        return np.zeros((0, len(labels)))
    values = np.asarray(machine.decision_function(gram)).reshape(len(gram), -1)
    if values.shape[1] == 1:
        values = np.column_stack([-values, values])
    lowest = values.min(axis=1, keepdims=True, initial=0.0) - 1
    decided = np.repeat(lowest, len(labels), axis=1)
    for column, label in enumerate(machine.classes_):
        decided[:, list(labels).index(label)] = values[:, column]
    return decided
