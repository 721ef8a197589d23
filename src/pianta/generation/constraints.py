"""Constraints on generated buildings: numbers of rooms."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from pianta.errors import LabelError, OptionError
from pianta.generation.type_model import Counts
from pianta.io._faults import join_faults
from pianta.labels import LabelSchema, standard_name

# Rooms of a constraint.
MAX_ROOMS = 1_000_000


@dataclass(frozen=True)
class Constraints:
    """Limits of the number of rooms, in all and by label.

    rooms: minimum and maximum of all rooms, corridors included; None for any number.
    at_least, at_most: label -> number of rooms, labels in any case.

    Raises OptionError that lists contradictions, and numbers below 0.
    """

    rooms: tuple[int, int] | None = None
    at_least: Mapping[str, int] = field(default_factory=dict)
    at_most: Mapping[str, int] = field(default_factory=dict)

    def __post_init__(self) -> None:
        object.__setattr__(self, "at_least", _standardise(self.at_least))
        object.__setattr__(self, "at_most", _standardise(self.at_most))
        if faults := self._find_faults():
            raise OptionError(join_faults(faults))

    def __bool__(self) -> bool:
        return self.rooms is not None or bool(self.at_least) or bool(self.at_most)

    def check(self, fewest: Counts, most: Counts, schema: LabelSchema) -> None:
        """Raise OptionError that lists the constraints that no building can meet.

        fewest, most: minimum and maximum rooms of each label of the schema, then of all, shape (labels + 1,).
        """
        columns = {label: column for column, label in enumerate(schema.by_name)}
        labels = [label for label, column in columns.items() if most[column]]
        # At most 0 rooms of a label is possible for any label of the schema.
        required = dict.fromkeys(self.at_most, 0) | dict(self.at_least)
        faults = [
            f"there are no rooms of label {label}, give some of {', '.join(labels)}"
            for label, number in required.items()
            if label not in columns or (number and not most[columns[label]])
        ]
        faults += [
            f"at least {number} rooms of label {label} are required, give at most {most[columns[label]]}"
            for label, number in self.at_least.items()
            if label in labels and number > most[columns[label]]
        ]
        faults += [
            f"at most {number} rooms of label {label} are allowed, but each building has {fewest[columns[label]]} or "
            "more, give as many"
            for label, number in self.at_most.items()
            if label in columns and number < fewest[columns[label]]
        ]
        if self.rooms is not None and self.rooms[1] < fewest[-1]:
            faults.append(f"at most {self.rooms[1]} rooms in all are allowed, give at least {fewest[-1]}")
        if self.rooms is not None and self.rooms[0] > most[-1]:
            faults.append(f"at least {self.rooms[0]} rooms in all are required, give at most {most[-1]}")
        if faults:
            raise OptionError(f"no {schema.building_type} of the model can meet the constraints: {join_faults(faults)}")

    def count_violations(self, counts: Counts, labels: Sequence[str]) -> Counts:
        """Number of rooms too many or too few, shape (n,), from the rooms of each label, shape (n, labels)."""
        columns = {label: counts[:, column] for column, label in enumerate(labels)}
        violations = np.zeros(len(counts), np.int64)
        if self.rooms is not None:
            total = counts.sum(axis=1)
            violations += np.maximum(self.rooms[0] - total, 0) + np.maximum(total - self.rooms[1], 0)
        for label, number in self.at_least.items():
            violations += np.maximum(number - columns[label], 0)
        for label, number in self.at_most.items():
            violations += np.maximum(columns[label] - number, 0)
        return violations

    def _find_faults(self) -> list[str]:
        """Messages about limits that are out of range or contradict each other."""
        faults = [
            f"{number} rooms of label {label} are not possible, give 0 to {MAX_ROOMS}"
            for limits in (self.at_least, self.at_most)
            for label, number in limits.items()
            if not 0 <= number <= MAX_ROOMS
        ]
        faults += [
            f"at least {number} and at most {self.at_most[label]} rooms of label {label} contradict each other, "
            "change one"
            for label, number in self.at_least.items()
            if number > self.at_most.get(label, number)
        ]
        if self.rooms is not None:
            fewest, most = self.rooms
            required = sum(self.at_least.values())
            if not 1 <= fewest <= most <= MAX_ROOMS:
                faults.append(f"{fewest} to {most} rooms is no range, give the minimum first, 1 to {MAX_ROOMS}")
            elif required > most:
                faults.append(f"at least {required} rooms of some labels are more than {most} rooms in all")
        return faults


def _standardise(numbers: Mapping[str, int]) -> dict[str, int]:
    """The numbers by labels in standard form; LabelError for an invalid label or one that is given twice."""
    standard: dict[str, int] = {}
    for label, number in numbers.items():
        name = standard_name(label)
        if name in standard:
            raise LabelError(f"label {name} is given twice, leave one out")
        standard[name] = number
    return standard
