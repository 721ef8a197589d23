"""The verb bench: the tables of the thesis, measured again."""

from __future__ import annotations

from importlib import import_module

import typer

from pianta.cli.terminal import show_examples

# In the order of the help. Each is a folder with a BENCH.
BENCHES = (
    *(
        "layout",
        "segmentation",
        "departures",
        "cost",
        "graphs",
        "types",
        "places",
        "buildings",
        "generation",
        "drawing",
    ),
    *("prediction", "realism", "partial", "exploration", "online", "plans", "robustness", "calibration", "evacuation"),
    *("patterns", "noise"),
)

app = typer.Typer(no_args_is_help=True, help="Measure the tables of the thesis again, on the maps that you have.")
for name in BENCHES:
    bench = import_module(f"pianta_bench.{name}").BENCH
    app.command(name, epilog=show_examples(bench.examples))(bench.make_command())
