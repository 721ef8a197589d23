"""Row: the figures of one item, of benches that do not use records yet."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass

from pianta.errors import BuildingWarning, MapWarning, PiantaError
from pianta.io._files import one_line_reason

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
