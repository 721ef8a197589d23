"""RuleInduction: an ordered list of rules, each a conjunction of thresholds on features, with a default label.

After IREP (Fürnkranz and Widmer, Incremental reduced error pruning, ICML 1994), with the order of classes and the
numeric conditions of RIPPER (Cohen, Fast effective rule induction, ICML 1995), whose second optimisation is left out.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pianta._types import Floats, Mask

Labels = NDArray[np.str_]

# Two thirds of the rows grow a rule, the others prune it (Fürnkranz and Widmer, 1994).
GROW_SHARE = 2 / 3


@dataclass(frozen=True)
class Condition:
    """The feature of a column is above a threshold, or at most at it."""

    feature: int
    threshold: float
    above: bool

    def covers(self, features: Floats) -> Mask:
        """Which rows meet it, shape (rows,)."""
        return np.asarray((features[:, self.feature] > self.threshold) == self.above)


@dataclass(frozen=True)
class Rule:
    """Rows that meet all conditions have the label; without conditions all rows do."""

    label: str
    conditions: tuple[Condition, ...] = ()

    def covers(self, features: Floats) -> Mask:
        """Which rows it covers, shape (rows,)."""
        covered = np.ones(len(features), bool)
        for condition in self.conditions:
            covered &= condition.covers(features)
        return covered


class RuleInduction:
    """A classifier by sequential covering.

    seed: divides rows into those that grow and those that prune a rule.
    rules: after `fit`, in the order in which they are tried; the last has no conditions.
    """

    def __init__(self, *, seed: int = 0) -> None:
        self.seed = seed
        self.rules: tuple[Rule, ...] = ()

    def fit(self, features: Floats, labels: Labels) -> RuleInduction:
        """Learn rules from rows, shape (rows, features), and their labels, shape (rows,); at least one row."""
        random = np.random.default_rng(self.seed)
        names, counts = np.unique(labels, return_counts=True)
        rules: list[Rule] = []
        # The rarest class first: later rules need not separate their class from classes that are already covered.
        *others, commonest = names[np.argsort(counts, kind="stable")]
        for label in others:
            while (rule := _learn_rule(features, labels == label, str(label), random)) is not None:
                rules.append(rule)
                rest = ~rule.covers(features)
                features, labels = features[rest], labels[rest]
        self.rules = (*rules, Rule(str(commonest)))
        return self

    def predict(self, features: Floats) -> Labels:
        """The label of the first rule that covers each row, shape (rows,)."""
        covered = [rule.covers(features) for rule in self.rules]
        return np.asarray(np.array([rule.label for rule in self.rules])[np.argmax(covered, axis=0)])


def _learn_rule(features: Floats, positive: Mask, label: str, random: np.random.Generator) -> Rule | None:
    """The next rule for a class; None if no row of it is left, or if half of the pruning rows are wrong."""
    if not positive.any():
        return None
    grows = np.zeros(len(positive), bool)
    for rows in (np.flatnonzero(positive), np.flatnonzero(~positive)):
        grows[random.permutation(rows)[: int(np.ceil(len(rows) * GROW_SHARE))]] = True
    grown = _grow_rule(features[grows], positive[grows], label)
    rule = _prune_rule(grown, features[~grows], positive[~grows])
    right = positive[~grows][rule.covers(features[~grows])]
    return rule if rule.conditions and 2 * right.sum() > right.size else None


def _grow_rule(features: Floats, positive: Mask, label: str) -> Rule:
    """Add the condition with the highest gain until the rule covers positive rows only, or no condition gains."""
    conditions: list[Condition] = []
    while not positive.all():
        gain, condition = max(_best_condition(features, positive, column) for column in range(features.shape[1]))
        if gain <= 0:
            break
        conditions.append(Condition(*condition))
        covered = conditions[-1].covers(features)
        features, positive = features[covered], positive[covered]
    return Rule(label, tuple(conditions))


def _best_condition(features: Floats, positive: Mask, column: int) -> tuple[float, tuple[int, float, bool]]:
    """Highest gain p (log2 p/(p+n) - log2 P/(P+N)) of the thresholds of a feature (FOIL; Quinlan, 1990).

    P positive and N negative rows are covered without the condition, p and n with it.
    """
    order = np.argsort(features[:, column], kind="stable")
    values, right = features[order, column], positive[order]
    cuts = np.flatnonzero(np.diff(values)) + 1
    if not len(cuts):
        return 0.0, (column, 0.0, False)
    below = np.append(0, np.cumsum(right))[cuts]
    right_rows = np.stack([below, right.sum() - below])
    all_rows = np.stack([cuts, len(right) - cuts])
    precision = np.maximum(right_rows, 1) / all_rows
    gains = right_rows * (np.log2(precision) - np.log2(right.mean()))
    side, cut = np.unravel_index(np.argmax(gains), gains.shape)
    low, high = values[cuts[cut] - 1 : cuts[cut] + 1]
    # The middle of two neighbouring floats may round up to the higher one, which would then be on the wrong side.
    threshold = min((low + high) / 2, np.nextafter(high, low))
    return float(gains[side, cut]), (column, float(threshold), bool(side))


def _prune_rule(rule: Rule, features: Floats, positive: Mask) -> Rule:
    """Leave out the last conditions, as many as give the highest (p - n) / (p + n) on rows that did not grow it."""
    best, best_worth = rule, -np.inf
    for length in range(1, len(rule.conditions) + 1):
        shorter = Rule(rule.label, rule.conditions[:length])
        right = positive[shorter.covers(features)]
        worth = 2 * right.mean() - 1 if right.size else -1.0
        if worth > best_worth:
            best, best_worth = shorter, float(worth)
    return best
