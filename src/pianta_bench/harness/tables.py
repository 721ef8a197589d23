"""Table: which records a table shows and how, as data; and the filled table, with published figures."""

from __future__ import annotations

import csv
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from importlib.resources import files
from statistics import fmean, median, stdev
from typing import Any, TypeAlias

from pianta_bench.harness.records import Record, select_records

Key: TypeAlias = tuple[Any, ...]

# The statistic of each column in a row below the items of a table.
SUMMARIES: Mapping[str, Callable[[Sequence[float]], float | None]] = {
    "mean": fmean,
    "sd": lambda values: stdev(values) if len(values) > 1 else None,
    "median": median,
}


@dataclass(frozen=True)
class Cell:
    """Mean and sample standard deviation (n - 1) measured here, and the published ones; None if they do not exist.

    count: number of items of the mean. digits: number of printed digits behind the point.
    """

    mean: float | None = None
    sd: float | None = None
    published_mean: float | None = None
    published_sd: float | None = None
    count: int | None = None
    digits: int = 1

    @classmethod
    def over(cls, values: Iterable[float | None]) -> Cell:
        """The cell of figures, one for each item; None for items that have none."""
        present = [value for value in values if value is not None]
        mean = fmean(present) if present else None
        return cls(mean, stdev(present) if len(present) > 1 else None, count=len(present))

    @classmethod
    def median(cls, values: Iterable[float | None]) -> Cell:
        """The cell of the median of figures, one for each item; None for items that have none."""
        present = [value for value in values if value is not None]
        return cls(median(present) if present else None, count=len(present))

    @classmethod
    def only(cls, values: Sequence[float | None]) -> Cell:
        """The cell of a single figure, shown as it is."""
        (value,) = values
        return cls(value)


@dataclass(frozen=True)
class FilledTable:
    """A table with its figures.

    rows: the cells by name of row, and in it by name of column. unit: of all figures, or empty.
    is_printed: whether it is printed, or only saved. published: the file of published figures, empty without a file.
    """

    title: str
    columns: tuple[str, ...]
    rows: Mapping[str, Mapping[str, Cell]]
    notes: tuple[str, ...] = ()
    unit: str = ""
    is_printed: bool = True
    published: str = ""


@dataclass(frozen=True, kw_only=True)
class Table:
    """The layout of a table: which records it shows, and how.

    rows, columns: the fields of records that name a row and a column; the values of several fields are joined by ", ".
    where: by field the value, or values, of the records in the table; values also give the order of rows and columns.
    labels: the text in the table for a value of a field; may also give the order.
    summarise: makes a cell from the figures that share a row and a column.
    digits: printed digits behind the point, of all cells or by value of a field.
    factor: 100 to print shares in %; published figures already have it.
    published: the file of published figures, in `published/`. summaries: rows below, of SUMMARIES.
    is_printed: whether the table is printed, or only saved.
    """

    title: str
    rows: tuple[str, ...] = ("metric",)
    columns: tuple[str, ...] = ("part",)
    where: Mapping[str, Any] = field(default_factory=dict)
    labels: Mapping[Any, str] = field(default_factory=dict)
    summarise: Callable[[list[Any]], Cell] = Cell.over
    digits: int | Mapping[Any, int] = 1
    factor: float = 1.0
    published: str = ""
    summaries: tuple[str, ...] = ()
    unit: str = ""
    notes: tuple[str, ...] = ()
    is_printed: bool = True

    def narrow(self, **where: Any) -> Table:
        """The table of fewer records: those that also have these values."""
        return replace(self, where={**self.where, **where})

    def fill(self, records: Iterable[Record], *, notes: Iterable[str] = (), **names: object) -> FilledTable:
        """The table with the figures of records.

        notes: further notes, after those of the table. names: values of the {names} in title and notes.
        """
        groups: dict[tuple[Key, Key], list[Any]] = {}
        for record in select_records(records, self.where):
            key = self._key(record, self.rows), self._key(record, self.columns)
            groups.setdefault(key, []).append(self._scale(record["value"]))
        cells = {key: self.summarise(values) for key, values in groups.items()}
        for record in self._published():
            key = self._key(record, self.rows), self._key(record, self.columns)
            cells[key] = replace(
                cells.get(key, Cell()), published_mean=_number(record["mean"]), published_sd=_number(record.get("sd"))
            )
        rows, columns = (self._sort(dict.fromkeys(key[side] for key in cells), side) for side in (0, 1))
        filled = {
            self._name(row): {
                self._name(column): replace(cells.get((row, column), Cell()), digits=self._digits(row, column))
                for column in columns
            }
            for row in rows
        }
        if self.summaries:
            filled |= self._summarise_columns(groups, rows, columns)
        return FilledTable(
            self.title.format(**names),
            tuple(map(self._name, columns)),
            filled,
            (*(note.format(**names) for note in self.notes), *notes),
            self.unit,
            self.is_printed,
            self.published,
        )

    def _scale(self, value: float | None) -> float | None:
        return value if value is None or self.factor == 1 else self.factor * value

    def _key(self, record: Record, names: tuple[str, ...]) -> Key:
        return tuple(record[name] for name in names)

    def _name(self, key: Key) -> str:
        return ", ".join(str(self.labels.get(value, value)) for value in key)

    def _digits(self, row: Key, column: Key) -> int:
        if isinstance(self.digits, int):
            return self.digits
        return next((self.digits[value] for value in (*row, *column) if value in self.digits), 1)

    def _published(self) -> list[Record]:
        """The published figures of the rows and columns of the table."""
        if not self.published:
            return []
        records: list[Record] = [*read_published(self.published)]
        where = {name: value for name, value in self.where.items() if records and name in records[0]}
        named = {str(value): value for values in where.values() for value in _as_sequence(values)}
        records = [{name: named.get(text, text) for name, text in record.items()} for record in records]
        return select_records(records, where)

    def _sort(self, keys: Iterable[Key], side: int) -> list[Key]:
        """Keys in the order of `where`, else of `labels`, else of the records."""
        keys = list(keys)
        orders = []
        for index, name in enumerate((self.rows, self.columns)[side]):
            wanted = self.where.get(name)
            values = [key[index] for key in keys]
            if isinstance(wanted, (list, tuple)):
                order = list(wanted)
            elif values and all(value in self.labels for value in values):
                order = list(self.labels)
            else:
                order = list(dict.fromkeys(values))
            orders.append({value: position for position, value in enumerate(order)})
        return sorted(keys, key=lambda key: [order[value] for order, value in zip(orders, key, strict=True)])

    def _summarise_columns(
        self, groups: Mapping[tuple[Key, Key], list[Any]], rows: Sequence[Key], columns: Sequence[Key]
    ) -> dict[str, dict[str, Cell]]:
        """A row for each of `summaries`, over all figures of a column."""
        figures = {
            column: [value for row in rows for value in groups.get((row, column), []) if value is not None]
            for column in columns
        }
        return {
            name: {
                self._name(column): Cell(SUMMARIES[name](values) if values else None, digits=self._digits((), column))
                for column, values in figures.items()
            }
            for name in self.summaries
        }


def read_published(name: str) -> list[dict[str, str]]:
    """The published figures of a file in `published/`: the fields that name a figure, its mean, and its sd if known."""
    text = files("pianta_bench").joinpath("published", name).read_text(encoding="utf-8")
    return list(csv.DictReader(text.splitlines()))


def _number(text: str | None) -> float | None:
    return float(text) if text else None


def _as_sequence(value: Any) -> Sequence[Any]:
    return value if isinstance(value, (list, tuple)) else (value,)
