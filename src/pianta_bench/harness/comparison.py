"""ComparisonTable: means of what a bench has measured, each beside the figure that the thesis prints."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from statistics import fmean, stdev
from types import MappingProxyType
from typing import TypeAlias

from rich import box
from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from pianta import __version__
from pianta.io._files import atomic_file
from pianta_bench.harness.report import ABSENT, show_figure
from pianta_bench.harness.table import Row

# What was measured on each item, by the name of the part that the items belong to.
Items: TypeAlias = Mapping[str, Sequence[Row]]

WIDTH = 100


@dataclass(frozen=True)
class Cell:
    """Mean and sample standard deviation (n - 1) measured here, and those that the thesis prints; None for none.

    count: over how many items the mean is.
    """

    mean: float | None
    sd: float | None = None
    printed_mean: float | None = None
    printed_sd: float | None = None
    count: int | None = None

    @classmethod
    def over(cls, figures: Iterable[float | None], printed: tuple[float | None, float | None] = (None, None)) -> Cell:
        """The cell of figures, one an item, of which those that are None do not count."""
        known = [figure for figure in figures if figure is not None]
        mean = fmean(known) if known else None
        return cls(mean, stdev(known) if len(known) > 1 else None, *printed, count=len(known))


@dataclass(frozen=True)
class ComparisonRow:
    """A named row: a cell for each column of the table. digits: how many are shown behind the point."""

    name: str
    cells: tuple[Cell, ...]
    digits: int = 1


@dataclass(frozen=True)
class ComparisonTable:
    """A table of the thesis, measured again. unit: of all figures, empty where they have several or none.

    Raises ValueError when a row has not one cell for each column.
    """

    title: str
    columns: tuple[str, ...]
    rows: tuple[ComparisonRow, ...]
    notes: tuple[str, ...] = ()
    unit: str = ""

    def __post_init__(self) -> None:
        uneven = [row.name for row in self.rows if len(row.cells) != len(self.columns)]
        if uneven:
            raise ValueError(f"rows {uneven} have not {len(self.columns)} cells each, one for each column")


def show_comparisons(tables: Sequence[ComparisonTable], items: Items | None = None) -> Group:
    """The tables in at most 100 columns of a terminal, mean ± sd, then what failed on which item and why.

    Columns that do not fit beside the others go below them. A column has no "thesis" where it prints nothing.
    """
    lines: list[RenderableType] = []
    for table in tables:
        unit = f", {table.unit}" if table.unit else ""
        lines += [Text(table.title, style="bold"), Text(f"mean ± sd{unit}"), Text()]
        for block in _fit_columns(table):
            lines += [block, Text()]
        lines += [*map(Text, table.notes), *[Text()] * bool(table.notes)]
    for part, rows in (items or {}).items():
        lines += tell_faults(part, rows)
    return Group(*lines)


def save_comparisons(
    bench: str,
    tables: Sequence[ComparisonTable],
    items: Items,
    path: str | Path,
    *,
    more: Mapping[str, object] = MappingProxyType({}),
) -> None:
    """Write every cell, and every figure with the item it belongs to, as JSON.

    more: what else the file shall hold, by its key.
    Raises PiantaError when the file cannot be written.
    """
    content = {
        "pianta": __version__,
        "bench": bench,
        "tables": [_table_as_json(table) for table in tables],
        "items": [
            {"part": part, "item": row.item, "failure": row.failure, "warnings": row.warned, "figures": {**row.figures}}
            for part, rows in items.items()
            for row in rows
        ],
        **more,
    }
    with atomic_file(path) as temporary:
        temporary.write_text(json.dumps(content, indent=1, allow_nan=False) + "\n", encoding="utf-8")


def _table_as_json(table: ComparisonTable) -> dict[str, object]:
    rows = [
        {"name": row.name, "column": column, **asdict(cell)}
        for row in table.rows
        for column, cell in zip(table.columns, row.cells, strict=True)
    ]
    return {"title": table.title, "unit": table.unit, "cells": rows, "notes": table.notes}


def _fit_columns(table: ComparisonTable) -> Iterator[RenderableType]:
    """Tables of as many columns each as WIDTH holds, all with the names of the rows."""
    names = [row.name for row in table.rows]
    name_width = max(map(len, names), default=0)
    block: list[tuple[str, list[str]]] = []
    for place in range(len(table.columns)):
        more = _column_pair(table, place)
        width = sum(max(map(len, (*heading.split("\n"), *cells))) + 1 for heading, cells in [*block, *more])
        if block and name_width + width > WIDTH:
            yield _draw_block(names, block)
            block = []
        block += more
    yield _draw_block(names, block)


def _column_pair(table: ComparisonTable, place: int) -> list[tuple[str, list[str]]]:
    """Headings and texts of the column measured here, and of the printed one where there is any."""
    name = table.columns[place]
    cells = [(row.cells[place], row.digits) for row in table.rows]
    pair = [(f"{name}\nhere", [_show_cell(cell.mean, cell.sd, digits) for cell, digits in cells])]
    if any(cell.printed_mean is not None for cell, _ in cells):
        printed = [_show_cell(cell.printed_mean, cell.printed_sd, digits) for cell, digits in cells]
        pair.append((f"{name}\nthesis", printed))
    return pair


def _draw_block(names: list[str], columns: list[tuple[str, list[str]]]) -> RenderableType:
    rows = start_table("", *(heading for heading, _ in columns))
    for name, *cells in zip(names, *(cells for _, cells in columns), strict=True):
        rows.add_row(name, *cells)
    return rows


def _show_cell(mean: float | None, sd: float | None, digits: int) -> str:
    if mean is None:
        return ABSENT
    return show_figure(float(mean), digits) + (f" ± {show_figure(float(sd), digits)}" if sd is not None else "")


def tell_faults(part: str, rows: Sequence[Row]) -> Iterator[RenderableType]:
    """A line for each item of a part that failed, and one for how many items there were warnings."""
    for row in rows:
        if row.failure:
            yield Text.assemble((f"{row.item} failed", "red"), f" ({part}), not counted: {row.failure}")
    warned = sum(bool(row.warned) for row in rows)
    if warned:
        yield Text(f"Warnings on {warned} of {len(rows)} {part}; --json lists them.")


def start_table(first: str, *headings: str) -> Table:
    """A table without rows, of a column of names and columns of figures that are never cut."""
    rows = Table(box=box.SIMPLE_HEAD, show_edge=False, padding=0)
    rows.add_column(first, overflow="fold")
    for heading in headings:
        rows.add_column(heading, justify="right", no_wrap=True)
    return rows
