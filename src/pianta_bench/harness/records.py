"""Results: the figures of a bench, one record for each, with the item that the figure belongs to."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any, TypeAlias

from pianta.errors import BuildingWarning, MapWarning, PiantaError
from pianta.io._files import one_line_reason

# A figure and what it belongs to: the fields "part", "item", "metric" and "value", and those that a bench adds.
Record: TypeAlias = Mapping[str, Any]
# The figures of an item, None where a figure does not exist: by the name of the metric, or by a tuple of names.
Figures: TypeAlias = Mapping[Any, float | None]
Track: TypeAlias = Callable[[Sequence[str]], Iterable[str]]

NO_FIGURES: Figures = MappingProxyType({})


@dataclass(frozen=True)
class Item:
    """An item that was measured, such as a map by one method.

    failure: the reason if the measurement failed, else None. warnings: those of the library meanwhile.
    """

    part: str
    item: str
    failure: str | None = None
    warnings: tuple[str, ...] = ()


@dataclass
class Results:
    """The results of a bench.

    options: arguments of the bench, by name. records, items: in the order of measurement.
    details: further content of the JSON file, by key.
    objects: further input of tables and figures, by name; not saved.
    """

    options: dict[str, Any] = field(default_factory=dict)
    records: list[Record] = field(default_factory=list)
    items: list[Item] = field(default_factory=list)
    details: dict[str, Any] = field(default_factory=dict)
    objects: dict[str, Any] = field(default_factory=dict)

    @property
    def failed(self) -> bool:
        """Whether the measurement of any item failed."""
        return any(item.failure for item in self.items)

    def add(self, part: str, item: str, figures: Figures, *, names: Sequence[str] = ("metric",), **fields: Any) -> None:
        """Append a record for each figure.

        names: fields that the keys of the figures fill, one for each element of a key that is a tuple.
        fields: further fields of all these records.
        """
        for key, value in figures.items():
            keys = key if isinstance(key, tuple) else (key,)
            named = dict(zip(names, keys, strict=True))
            self.records.append({"part": part, "item": item, **fields, **named, "value": value})

    def extend(self, other: Results) -> None:
        """Append the records and items of results, such as those of a step."""
        self.records += other.records
        self.items += other.items

    def measure(
        self,
        part: str,
        item: str,
        measure: Callable[[], Iterable[Figures]],
        *,
        names: Sequence[str] = ("metric",),
        failed: Figures = NO_FIGURES,
        **fields: Any,
    ) -> None:
        """Measure an item and append its records; a failure is recorded with its reason and does not stop the bench.

        measure: yields figures as soon as it has them. failed: figures of an item that fails before it yields them.
        names, fields: as in `add`.
        """
        figures, failure = dict(failed), None
        with warnings.catch_warnings(record=True) as caught:
            for category in (MapWarning, BuildingWarning):
                warnings.simplefilter("always", category)
            try:
                for measured in measure():
                    figures.update(measured)
            # Any error of a method must be recorded, and the bench must go on.
            except Exception as exception:
                error_type = "" if isinstance(exception, PiantaError) else f"{type(exception).__name__}: "
                failure = error_type + one_line_reason(exception)
        self.items.append(Item(part, item, failure, tuple(str(warning.message) for warning in caught)))
        self.add(part, item, figures, names=names, **fields)

    def select(self, **where: Any) -> list[Record]:
        """The records whose fields have these values, or one of the values of a list or tuple."""
        return select_records(self.records, where)

    def values(self, **where: Any) -> list[float]:
        """The figures of the records that `select` gives, without those that do not exist."""
        return [record["value"] for record in self.select(**where) if record["value"] is not None]


def select_records(records: Iterable[Record], where: Mapping[str, Any]) -> list[Record]:
    """The records whose fields have these values, or one of the values of a list or tuple."""
    wanted = {name: value if isinstance(value, (list, tuple)) else (value,) for name, value in where.items()}
    return [record for record in records if all(record.get(name) in values for name, values in wanted.items())]


def name_parts(items: Iterable[Item]) -> Iterator[str]:
    """The parts of items, each once."""
    yield from dict.fromkeys(item.part for item in items)
