"""Bench: one verb of `pianta bench`, declared as data; and the command that runs any of them."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Annotated, Any

import typer

from pianta.cli.terminal import stdout, track_items
from pianta.errors import OptionError
from pianta.io._files import short_repr
from pianta.io._folders import atomic_folder, check_output_folder

Scheduler = Annotated[
    str | None,
    typer.Option(
        metavar="ADDRESS|FILE",
        help="Dask scheduler, or the file that it has written; its workers run the steps instead of --jobs.",
    ),
]
Json = Annotated[Path | None, typer.Option("--json", help="File for every figure and its item.", metavar="FILE")]


@dataclass(frozen=True, kw_only=True)
class Bench:
    """The command `pianta bench NAME`; the folder NAME has measure.py, tables.py and perhaps figures.py.

    help: what it measures, what it reads, in the lines of a terminal. examples: command lines.
    options: by argument of `measure` the annotation, with typer.Option, and the default.
    pictures: what --pictures writes; empty without pictures.
    """

    name: str
    help: str
    examples: tuple[str, ...]
    options: Mapping[str, tuple[Any, Any]] = field(default_factory=dict)
    pictures: str = ""

    def make_command(self) -> Callable[..., None]:
        """The function that typer calls: it measures, prints the tables, and writes figures and pictures."""
        options = dict(self.options)
        if "jobs" in options:
            options["scheduler"] = (Scheduler, None)
        options["json"] = (Json, None)
        if self.pictures:
            help_ = f"Folder for {self.pictures}."
            options["pictures"] = (Annotated[Path | None, typer.Option(help=help_, metavar="DIR")], None)

        def command(**arguments: Any) -> None:
            self.run(**arguments)

        command.__doc__ = self.help
        command.__annotations__ = {name: annotation for name, (annotation, _) in options.items()}
        command.__signature__ = inspect.Signature(  # type: ignore[attr-defined]
            [
                inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, annotation=annotation, default=default)
                for name, (annotation, default) in options.items()
            ]
        )
        return command

    def run(
        self,
        *,
        json: Path | None = None,
        pictures: Path | None = None,
        scheduler: str | None = None,
        **options: Any,
    ) -> None:
        """Measure, print, save; exit with the code 1 if an item failed. Bad options are refused before the long run.

        scheduler: of a Dask cluster that runs the steps, as of `read_batch`. options: arguments of `measure` of the
        bench.
        """
        check_outputs(json, pictures)
        from pianta_bench.harness.parallel import use_scheduler
        from pianta_bench.harness.report import save_results, show_tables

        measure = self._import("measure").measure
        if "pictures" in inspect.signature(measure).parameters:
            options["pictures"] = pictures
        with use_scheduler(scheduler):
            results = measure(track=track_items, **options)
        tables = self._import("tables").tabulate(results)
        stdout.print(show_tables(tables, results))
        if json:
            with atomic_folder(json.parent) as folder:
                save_results(self.name, tables, results, folder / json.name)
        if pictures and (save_figures := self._find_save_figures()):
            with atomic_folder(pictures) as folder:
                save_figures(results, folder)
        if results.failed:
            raise typer.Exit(1)

    def _find_save_figures(self) -> Any:
        """The function that writes pictures of the results; None for a bench that draws them while it measures."""
        has_figures = find_spec(f"pianta_bench.{self.name}.figures")
        return getattr(self._import("figures"), "save_figures", None) if has_figures else None

    def _import(self, module: str) -> Any:
        return import_module(f"pianta_bench.{self.name}.{module}")


def check_outputs(json: Path | None, pictures: Path | None) -> None:
    """Refuse, before the long run, a JSON file or a folder of pictures that cannot be written."""
    for folder in (json and json.parent, pictures):
        if folder:
            check_output_folder(folder)
    if json and json.is_dir():
        raise OptionError(f"JSON file {short_repr(json)} is a folder, give the name of a file")
