"""Options of the verb bench."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from pianta.layout.reconstruct import METHODS
from pianta_bench.data.folders import LAYOUT_SET_NAMES, SET_NAMES

PLACE_SPLITS = ("experiments", "figure")

Data = Annotated[
    Path | None, typer.Option(help="Folder of the data; $PIANTA_DATA, or ../shared/data, unless given.", metavar="DIR")
]
Method = Annotated[str, typer.Option(help=f"How rooms are found: {', '.join(METHODS)}.")]
Methods = Annotated[
    list[str] | None,
    typer.Option("--method", help=f"How rooms are found, may be repeated: {', '.join(METHODS)}; all unless given."),
]
Sets = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        help=f"Which maps, may be repeated: {', '.join(SET_NAMES)}; all in the data unless given.",
        metavar="NAME",
    ),
]
LayoutSets = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        help=f"Which maps, may be repeated: {', '.join(LAYOUT_SET_NAMES)}; schools unless given.",
        metavar="NAME",
    ),
]
DepartureSets = Annotated[
    list[str] | None,
    typer.Option(
        "--set", help="Which maps, may be repeated: schools, survey, furniture; all three unless given.", metavar="NAME"
    ),
]
Items = Annotated[
    list[str] | None,
    typer.Option("--item", help="Only the map of this name, may be repeated.", metavar="NAME"),
]
AsPrinted = Annotated[
    bool, typer.Option("--as-printed", help="Method thesis as the thesis prints it, without our departures.")
]
WithAsPrinted = Annotated[bool, typer.Option("--as-printed", help="Measure Algorithm 1 as the thesis prints it, too.")]
LayoutMaps = Annotated[bool, typer.Option("--maps", help="Print the doors and edges of each map too.")]
Maps = Annotated[bool, typer.Option("--maps", help="Print the rows of the maps; always done for a single method.")]
TypeMaps = Annotated[bool, typer.Option("--maps", help="Predict the building types of robots' maps instead.")]
EvacuationMaps = Annotated[bool, typer.Option("--maps", help="Read robots' maps, and compare with their drawn floors.")]
Count = Annotated[bool, typer.Option("--count", help="Count right, split and merged rooms and wrong doors (IoU 0.6).")]
PlaceSplit = Annotated[
    str,
    typer.Option("--split", help=f"How labels are divided into R/C and F/C/E/S: {', '.join(PLACE_SPLITS)} (Fig. 4.5)."),
]
Jobs = Annotated[
    int | None, typer.Option(help="Processes that share the work, unless given one for each core.", min=1, max=1024)
]
# Of benches that measure times, which processes beside change: one unless given.
TimedJobs = Annotated[
    int, typer.Option("--jobs", min=1, help="Processes; the figures, except times, do not depend on them.")
]
Seed = Annotated[int, typer.Option(help="The same seed gives the same figures.", min=0, max=2**31)]

BuildingTypes = Annotated[
    list[Path] | None,
    typer.Option("--types", help="Folder of buildings of one type; repeat it for each type.", metavar="DIR"),
]
Trees = Annotated[int, typer.Option(help="Of each forest of Extra-Trees; the thesis has 500.", min=1, max=10000)]
