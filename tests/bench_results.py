"""The results of a bench, as tests look at them."""

from io import StringIO
from typing import Any, NamedTuple

from rich.console import Console

from pianta_bench.harness.records import Results
from pianta_bench.harness.report import show_tables
from pianta_bench.harness.tables import FilledTable


class Row(NamedTuple):
    """An item with its figures by metric."""

    item: str
    figures: dict[str, Any]
    failure: str | None = None
    warnings: tuple[str, ...] = ()


def list_rows(results: Results, part: str, **fields: Any) -> list[Row]:
    """The items of a part with their figures, of records with these fields.

    An item that was measured in several ways has the failure and the warnings of each of them in turn.
    """
    names = dict.fromkeys(item.item for item in results.items if item.part == part)
    methods = results.options.get("methods", ())
    turn = methods.index(fields["method"]) if fields.get("method") in methods else 0
    rows = []
    for name in names:
        item = [item for item in results.items if (item.part, item.item) == (part, name)][turn]
        figures = {record["metric"]: record["value"] for record in results.select(part=part, item=name, **fields)}
        rows.append(Row(name, figures, item.failure, item.warnings))
    return rows


def show_lines(tables: list[FilledTable], results: Results, width: int = 80) -> list[str]:
    """What a terminal of a width shows."""
    console = Console(file=StringIO(), width=width)
    console.print(show_tables(tables, results))
    assert isinstance(console.file, StringIO)
    return [line.rstrip() for line in console.file.getvalue().splitlines()]
