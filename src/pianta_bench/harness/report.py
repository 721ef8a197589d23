"""Output of a bench: tables in a terminal, and every figure as JSON."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass
from math import isfinite
from pathlib import Path

from rich import box
from rich.console import Console, ConsoleOptions, Group, RenderableType
from rich.table import Table as TextTable
from rich.text import Text

from pianta import __version__
from pianta.cli.terminal import escape_controls
from pianta.io._files import atomic_file
from pianta_bench.harness.records import Results, name_parts
from pianta_bench.harness.tables import Cell, FilledTable, read_published

ABSENT = "–"
MAX_WIDTH = 100  # characters; columns that do not fit are printed below
MAX_NAME_WIDTH = 40  # characters; longer names of rows are wrapped


def show_tables(tables: Sequence[FilledTable], results: Results) -> Group:
    """The tables as wide as the terminal, mean ± sd, then which items failed and why.

    A column has a column "thesis" beside it only where figures were published.
    """
    lines: list[RenderableType] = []
    for table in tables:
        if table.is_printed:
            has_sd = any(cell.sd is not None for cells in table.rows.values() for cell in cells.values())
            subtitle = ", ".join(["mean ± sd"] * has_sd + [table.unit] * bool(table.unit))
            lines += [
                Text(escape_controls(table.title), style="bold"),
                *[Text(subtitle)] * bool(subtitle),
                Text(),
                _Blocks(table),
            ]
            lines += [*map(Text, table.notes), *[Text()] * bool(table.notes)]
    return Group(*lines, *_show_faults(results))


def save_results(bench: str, tables: Sequence[FilledTable], results: Results, path: str | Path) -> None:
    """Write all cells, all records with their items, and all failures, as JSON.

    Raises PiantaError if the file cannot be written.
    """
    content = {
        "pianta": __version__,
        "bench": bench,
        "options": results.options,
        "tables": [_table_as_json(table) for table in tables],
        "items": [asdict(item) for item in results.items],
        "records": results.records,
        "published": _list_published(tables),
        **results.details,
    }
    with atomic_file(path) as temporary:
        temporary.write_text(json.dumps(content, indent=1, allow_nan=False) + "\n", encoding="utf-8")


def show_figure(figure: float | None, digits: int) -> str:
    """A figure with `digits` behind the point, none for a whole number; ABSENT for None, nan and infinity."""
    if figure is None or not isfinite(figure):
        return ABSENT
    return str(figure) if isinstance(figure, int) else f"{figure:.{digits}f}"


def _list_published(tables: Sequence[FilledTable]) -> dict[str, list[dict[str, object]]]:
    """The published figures of each file that a table shows."""
    names = dict.fromkeys(table.published for table in tables if table.published)
    return {
        name: [
            {key: float(text) if key in {"mean", "sd", "count"} and text else text for key, text in record.items()}
            for record in read_published(name)
        ]
        for name in names
    }


def _table_as_json(table: FilledTable) -> dict[str, object]:
    """A table as values that JSON can hold, its cells as one list."""
    cells = [
        {"row": row, "column": column, **asdict(cell)}
        for row, columns in table.rows.items()
        for column, cell in columns.items()
    ]
    return {"title": table.title, "unit": table.unit, "cells": cells, "notes": table.notes}


@dataclass(frozen=True)
class _Blocks:
    """A table as blocks of as many columns as fit, one below the other, all with the names of the rows."""

    table: FilledTable

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> Iterator[RenderableType]:
        width = min(options.max_width, MAX_WIDTH)
        name_width = min(max(map(len, self.table.rows), default=0), MAX_NAME_WIDTH)
        block: list[tuple[str, list[str]]] = []
        for column in self.table.columns:
            pair = _column_pair(self.table, column)
            needed = sum(max(map(len, (*heading.split("\n"), *cells))) + 1 for heading, cells in [*block, *pair])
            if block and name_width + needed > width:
                yield from (_draw_block(self.table, block), Text())
                block = []
            block += pair
        yield from (_draw_block(self.table, block), Text())


def _column_pair(table: FilledTable, column: str) -> list[tuple[str, list[str]]]:
    """Headings and texts of the measured column, and of the published one, if any."""
    cells = [columns[column] for columns in table.rows.values()]
    measured = [_show_cell(cell.mean, cell.sd, cell.digits) for cell in cells]
    if not _has_published(cell for columns in table.rows.values() for cell in columns.values()):
        return [(column, measured)]
    if not _has_published(cells):
        return [(f"{column}\nhere", measured)]
    published = [_show_cell(cell.published_mean, cell.published_sd, cell.digits) for cell in cells]
    own = [(f"{column}\nhere", measured)] * any(cell.mean is not None for cell in cells)
    return [*own, (f"{column}\nthesis", published)]


def _has_published(cells: Iterable[Cell]) -> bool:
    return any(cell.published_mean is not None for cell in cells)


def _draw_block(table: FilledTable, columns: list[tuple[str, list[str]]]) -> RenderableType:
    """Some columns of a table as text, with the names of the rows; columns: each heading with its cells."""
    block = TextTable(box=box.SIMPLE_HEAD, show_edge=False, padding=0)
    block.add_column("", overflow="fold")
    for heading, _ in columns:
        block.add_column(heading, justify="right", no_wrap=True)
    for name, *cells in zip(table.rows, *(cells for _, cells in columns), strict=True):
        block.add_row(Text(escape_controls(name)), *cells)
    return block


def _show_cell(mean: float | None, sd: float | None, digits: int) -> str:
    return show_figure(mean, digits) + (f" ± {show_figure(sd, digits)}" if mean is not None and sd is not None else "")


def _show_faults(results: Results) -> Iterator[RenderableType]:
    """A line for each item that failed, and one for each part with warnings."""
    for part in name_parts(results.items):
        items = [item for item in results.items if item.part == part]
        for item in items:
            if item.failure:
                name, reason = escape_controls(item.item), escape_controls(f" ({part}): {item.failure}")
                yield Text.assemble((f"{name} failed", "red"), reason)
        warned = sum(bool(item.warnings) for item in items)
        if warned:
            yield Text(f"Warnings on {warned} of {len(items)} {escape_controls(part)}; --json lists them.")
