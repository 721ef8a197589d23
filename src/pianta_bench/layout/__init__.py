"""Table 3.1a: layouts of schools; and doors and edges of layouts of schools, of the survey and of made worlds."""

from __future__ import annotations

from pianta_bench._options import AsPrinted, Data, Items, LayoutMaps, LayoutSets, Method
from pianta_bench.harness.bench import Bench

BENCH = Bench(
    name="layout",
    help="""Layouts of schools against the true ones (Table 3.1a); doors, edges.

    Reads slam/NAME.png and slam/NAME_gt.xml of the data, and by --set survey
    and furniture survey/NAME.png, NAME_furnitures.png and NAME_layout_gt.xml;
    --set worlds makes furnished worlds. A map that fails counts as 0; the exit
    code is then 1.
    """,
    examples=(
        "pianta bench layout",
        "pianta bench layout --pictures layouts",
        "pianta bench layout --method thesis --as-printed",
        "pianta bench layout --method structure --set schools --set survey --set worlds --maps",
    ),
    options={
        "data": (Data, None),
        "method": (Method, "thesis"),
        "sets": (LayoutSets, None),
        "items": (Items, None),
        "maps": (LayoutMaps, False),
        "as_printed": (AsPrinted, False),
    },
    pictures="a picture of every floor that was reconstructed",
)
