"""BenchTable: what a bench has measured, a row a map, beside what the thesis prints."""

from __future__ import annotations

import json
import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from statistics import fmean, median, stdev

from pianta import __version__
from pianta.errors import BuildingWarning, MapWarning, PiantaError
from pianta.io._files import atomic_file, one_line_reason

Figures = Mapping[str, float | None]


@dataclass(frozen=True)
class Column:
    """A figure that is measured on every map.

    key: its name in Row.figures. heading: its name in print, where a line break is one. unit: of the figure.
    digits: how many are printed behind the point.
    failed: the figure of a map on which the measurement failed, None where nothing can be said.
    printed: whether it is shown, or only written.
    """

    key: str
    heading: str
    unit: str
    digits: int = 1
    failed: float | None = None
    printed: bool = True


@dataclass(frozen=True)
class Row:
    """The figures of one map by the keys of the columns, None for what was not measured.

    failure: why the measurement failed, None when it did not. warned: what was found suspicious on the way.
    """

    item: str
    figures: Figures
    failure: str | None = None
    warned: tuple[str, ...] = ()


@dataclass(frozen=True)
class Summary:
    """Mean, sample standard deviation (n - 1) and median; None where there are too few figures."""

    mean: float | None
    sd: float | None
    median: float | None


@dataclass(frozen=True)
class Part:
    """The rows that share their means, such as those of the maps with furniture, by one method."""

    name: str
    rows: tuple[Row, ...]
    method: str

    def summarise(self, key: str) -> Summary:
        """Summary of a column over the maps that have a figure; a failed one counts with Column.failed."""
        figures = [figure for row in self.rows if (figure := row.figures[key]) is not None]
        several = len(figures) > 1
        return Summary(
            fmean(figures) if figures else None,
            stdev(figures) if several else None,
            median(figures) if figures else None,
        )

    def divide_sums(self, part: str, whole: str) -> float | None:
        """Sum of a column over that of another, of the maps that have both; None where the latter is 0."""
        pairs = [(row.figures[part], row.figures[whole]) for row in self.rows]
        known = [(one, other) for one, other in pairs if one is not None and other is not None]
        total = sum(other for _, other in known)
        return sum(one for one, _ in known) / total if total else None


@dataclass(frozen=True)
class Printed:
    """A row of the thesis' table: by the name of the part, mean and standard deviation of each compared score."""

    name: str
    figures: Mapping[str, tuple[tuple[float, float], ...]]
    maps: int = 20


@dataclass(frozen=True)
class BenchTable:
    """What a bench has measured.

    bench, title, methods: what was measured. columns: of every part.
    scores: headings of the scores that the thesis prints too.
    compared: the columns that stand beside them, by the way of counting; one column for each of the scores.
    printed: the thesis' rows. notes: what a reader must know about the figures.
    ratios: by name the two columns whose sums are divided.
    summarised: the columns whose means stand in a summary of all methods on a set; none where there is no summary.
    """

    bench: str
    title: str
    methods: tuple[str, ...]
    columns: tuple[Column, ...]
    parts: tuple[Part, ...]
    scores: tuple[str, ...]
    compared: Mapping[str, tuple[str, ...]]
    printed: tuple[Printed, ...]
    notes: tuple[str, ...]
    summarised: tuple[str, ...] = ()
    ratios: Mapping[str, tuple[str, str]] = field(default_factory=dict)

    @property
    def failed(self) -> bool:
        """Whether the measurement failed on any map."""
        return any(row.failure for part in self.parts for row in part.rows)


def measure_rows(
    items: Iterable[str], measure: Callable[[str], Iterator[Figures]], *, columns: Iterable[Column]
) -> tuple[Row, ...]:
    """Measure one map after the other; one that fails is a row with its reason, and does not stop the others.

    measure: yields the figures of a map as it gets them; those that it did not get to become Column.failed.
    """
    columns = tuple(columns)
    return tuple(measure_row(item, measure, columns=columns) for item in items)


def measure_row(item: str, measure: Callable[[str], Iterator[Figures]], *, columns: Iterable[Column]) -> Row:
    """Measure one map, as measure_rows does."""
    figures, failure = {column.key: column.failed for column in columns}, None
    with warnings.catch_warnings(record=True) as caught:
        for category in (MapWarning, BuildingWarning):
            warnings.simplefilter("always", category)
        try:
            for measured in measure(item):
                figures.update(measured)
        # A bench must find out what breaks a method, whatever it is, and go on.
        except Exception as exception:
            kind = "" if isinstance(exception, PiantaError) else f"{type(exception).__name__}: "
            failure = kind + one_line_reason(exception)
    return Row(item, figures, failure, tuple(str(warning.message) for warning in caught))


def save_bench_table(table: BenchTable, path: str | Path) -> None:
    """Write every figure with the map it belongs to, and the means, as JSON, in the units of the columns.

    Raises PiantaError when the file cannot be written.
    """
    with atomic_file(path) as temporary:
        temporary.write_text(json.dumps(_as_json(table), indent=1, allow_nan=False) + "\n", encoding="utf-8")


def _as_json(table: BenchTable) -> dict[str, object]:
    return {
        "pianta": __version__,
        "bench": table.bench,
        "title": table.title,
        "methods": table.methods,
        "units": {column.key: column.unit for column in table.columns},
        "parts": [_part_as_json(part, table) for part in table.parts],
        "printed": [
            {"name": row.name, "maps": row.maps, "part": part}
            | {score: {"mean": mean, "sd": sd} for score, (mean, sd) in zip(table.scores, figures, strict=True)}
            for row in table.printed
            for part, figures in row.figures.items()
        ],
        "notes": table.notes,
    }


def _part_as_json(part: Part, table: BenchTable) -> dict[str, object]:
    return {
        "name": part.name,
        "method": part.method,
        "rows": [
            {"item": row.item, "failure": row.failure, "warnings": row.warned} | dict(row.figures) for row in part.rows
        ],
        "summary": {column.key: asdict(part.summarise(column.key)) for column in table.columns},
        "ratios": {name: part.divide_sums(*pair) for name, pair in table.ratios.items()},
    }
