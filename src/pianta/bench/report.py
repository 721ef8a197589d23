"""A BenchTable as people read it, in a terminal of 80 columns or more."""

from __future__ import annotations

from collections.abc import Iterator

from rich import box
from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from pianta.bench.table import BenchTable, Column, Part, Summary


def show_bench_table(table: BenchTable) -> Group:
    """The parts, a row a map; what failed and why; then the means beside the thesis' printed ones, and the notes."""
    heading = Text(f"{table.title}, method {table.method}", style="bold")
    parts = (line for part in table.parts for line in (*_show_part(part, table.columns), Text()))
    notes = map(Text, (_compare_map_counts(table), *table.notes))
    return Group(heading, Text(), *parts, _show_comparison(table), Text(), *notes)


def _show_part(part: Part, columns: tuple[Column, ...]) -> Iterator[RenderableType]:
    rows = _start_table(part.name, *(column.heading for column in columns))
    for row in part.rows:
        cells = (_show_figure(row.figures[column.key], column.digits) for column in columns)
        rows.add_row(Text(row.item, style="red" if row.failure else ""), *cells)
    rows.add_section()
    summaries = [(part.summarise(column.key), column.digits) for column in columns]
    for name in ("mean", "sd", "median"):
        rows.add_row(name, *(_show_figure(getattr(summary, name), digits) for summary, digits in summaries))
    yield rows
    for row in part.rows:
        if row.failure:
            yield Text.assemble((f"{row.item} failed", "red"), f", scores not measured count as 0: {row.failure}")
    warned = sum(bool(row.warned) for row in part.rows)
    if warned:
        yield Text(f"Warnings on {warned} of {len(part.rows)} maps; --json lists them.")


def _show_comparison(table: BenchTable) -> Table:
    """Mean ± sd of the compared scores, ours first."""
    headings = [f"{part.name}\n{score}" for part in table.parts for score in table.scores]
    rows = _start_table("mean ± sd, %", "maps", *headings)
    for count, keys in table.compared.items():
        summaries = [part.summarise(key) for part in table.parts for key in keys]
        rows.add_row(f"pianta, {count}", str(len(table.parts[0].rows)), *map(_show_mean, summaries))
    for row in table.printed:
        cells = [f"{mean:.1f} ± {sd:.1f}" for part in table.parts for mean, sd in row.figures[part.name]]
        rows.add_row(row.name, str(row.maps), *cells)
    return rows


def _compare_map_counts(table: BenchTable) -> str:
    printed = max(row.maps for row in table.printed)
    return f"The thesis' figures are over {printed} maps; here are {len(table.parts[0].rows)}."


def _start_table(first: str, *headings: str) -> Table:
    """A table without rows, of a column of names and columns of figures that are never cut."""
    rows = Table(box=box.SIMPLE_HEAD, show_edge=False, padding=0)
    rows.add_column(first, overflow="fold")
    for heading in headings:
        rows.add_column(heading, justify="right", no_wrap=True)
    return rows


def _show_mean(summary: Summary) -> str:
    return f"{_show_figure(summary.mean, 1)} ± {_show_figure(summary.sd, 1)}"


def _show_figure(figure: float | None, digits: int) -> str:
    if figure is None:
        return "–"
    return str(figure) if isinstance(figure, int) else f"{figure:.{digits}f}"
