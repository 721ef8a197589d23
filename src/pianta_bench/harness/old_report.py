"""A BenchTable as people read it, in a terminal of 80 columns or more."""

from __future__ import annotations

from collections.abc import Iterator
from math import isfinite

from rich import box
from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from pianta_bench.harness.table import BenchTable, Part, Summary

ABSENT = "–"


def show_bench_table(table: BenchTable, *, maps: bool = True) -> Group:
    """What the bench sums up; the parts, a row a map; what failed and why; our means beside printed ones; notes.

    maps: whether to show the rows of the maps.
    """
    names = ", ".join(table.methods)
    heading = Text(f"{table.title}, method{'s' * (len(table.methods) > 1)} {names}", style="bold")
    lines: list[RenderableType] = [heading, Text(), *_show_summaries(table)]
    for part in table.parts:
        shown = [*(_show_maps(part, table) if maps else ()), *_show_faults(part, table)]
        lines += [*shown, Text()] if shown else []
    comparison = [*_show_comparison(table)]
    lines += [*comparison[:1], Text(), *comparison[1:]] if comparison else []
    return Group(*lines, *map(Text, table.notes))


def _show_summaries(table: BenchTable) -> Iterator[RenderableType]:
    """A table a set, a row a method: mean ± sd of the scores, rooms found per true room, seconds, median of DT."""
    columns = {column.key: column for column in table.columns}
    headings = [columns[key].heading.replace("\n", " ").strip() for key in table.summarised]
    for name in dict.fromkeys(part.name for part in table.parts) if table.summarised else ():
        rows = start_table(name, *headings, "found\n/true", "time\ns", "time\nDT")
        for part in table.parts:
            if part.name == name:
                scores = [_show_mean(part.summarise(key)).replace(" ", "") for key in table.summarised]
                ratio, seconds = part.divide_sums(*table.ratios["found_per_true"]), part.summarise("seconds").mean
                times = show_figure(seconds, 1), show_figure(part.summarise("transforms").median, 0)
                rows.add_row(part.method, *scores, show_figure(ratio, 2), *times)
        yield rows
        yield from (_tell_what_lasted(part, table) for part in table.parts if part.name == name)
        yield Text()


def _tell_what_lasted(part: Part, table: BenchTable) -> Text:
    """Where maps grow: the rooms that the next step still has, and the ids that it still gives them."""
    rooms, ids = (part.divide_sums(*table.ratios[key]) for key in ("still_there", "kept_id"))
    if rooms is None or ids is None:
        return Text(end="")
    return Text(f"{part.method}: {rooms:.1%} of rooms are there in the next step, {ids:.1%} of these with their id.")


def _show_maps(part: Part, table: BenchTable) -> Iterator[RenderableType]:
    columns = [column for column in table.columns if column.printed]
    name = part.name if len(table.methods) == 1 else f"{part.name},\n{part.method}"
    rows = start_table(name, *(column.heading for column in columns))
    for row in part.rows:
        cells = (show_figure(row.figures[column.key], column.digits) for column in columns)
        rows.add_row(Text(row.item, style="red" if row.failure else ""), *cells)
    rows.add_section()
    summaries = [(part.summarise(column.key), column.digits) for column in columns]
    for name in ("mean", "sd", "median"):
        rows.add_row(name, *(show_figure(getattr(summary, name), digits) for summary, digits in summaries))
    yield rows


def _show_faults(part: Part, table: BenchTable) -> Iterator[RenderableType]:
    of = "" if len(table.methods) == 1 else f" ({part.name}, {part.method})"
    for row in part.rows:
        if row.failure:
            yield Text.assemble((f"{row.item} failed", "red"), f"{of}, scores not measured count as 0: {row.failure}")
    warned = sum(bool(row.warned) for row in part.rows)
    if warned:
        yield Text(f"Warnings on {warned} of {len(part.rows)} maps{of}; --json lists them.")


def _show_comparison(table: BenchTable) -> Iterator[RenderableType]:
    """Mean ± sd of the compared scores, ours first, where the thesis prints any; then on how many maps each are."""
    printed = {name for row in table.printed for name in row.figures}
    sets = [name for name in dict.fromkeys(part.name for part in table.parts) if name in printed]
    if not sets:
        return
    rows = start_table("mean ± sd, %", "maps", *(f"{name}\n{score}" for name in sets for score in table.scores))
    for method in table.methods:
        parts = [part for name in sets for part in table.parts if (part.name, part.method) == (name, method)]
        for count, keys in table.compared.items():
            means = [_show_mean(part.summarise(key)) for part in parts for key in keys]
            named = count if len(table.compared) > 1 else method
            rows.add_row(f"pianta, {named}", str(len(parts[0].rows)), *means)
    for row in table.printed:
        cells = [f"{mean:.1f} ± {sd:.1f}" for name in sets for mean, sd in row.figures[name]]
        rows.add_row(row.name, str(row.maps), *cells)
    yield rows
    most = max(row.maps for row in table.printed)
    yield Text(f"The thesis' figures are over {most} maps; here are {len(parts[0].rows)}.")


def start_table(first: str, *headings: str) -> Table:
    """A table without rows, of a column of names and columns of figures that are never cut."""
    rows = Table(box=box.SIMPLE_HEAD, show_edge=False, padding=0)
    rows.add_column(first, overflow="fold")
    for heading in headings:
        rows.add_column(heading, justify="right", no_wrap=True)
    return rows


def _show_mean(summary: Summary) -> str:
    return f"{show_figure(summary.mean, 1)} ± {show_figure(summary.sd, 1)}"


def show_figure(figure: float | None, digits: int) -> str:
    """A figure with so many digits behind the point, none behind a whole number; ABSENT for None, nan and infinity."""
    if figure is None or not isfinite(figure):
        return ABSENT
    return str(figure) if isinstance(figure, int) else f"{figure:.{digits}f}"
