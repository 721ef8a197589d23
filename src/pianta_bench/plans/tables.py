"""What `pianta bench plans` prints: each plan, the kinds of plans, the worth of symbols, the bars."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from statistics import fmean, median

from pianta_bench.harness.comparison import Cell, ComparisonRow, ComparisonTable
from pianta_bench.plans.measure import READINGS, PlanBench, PlanResult
from pianta_bench.plans.plan_sets import KINDS, SCREENSHOT
from pianta_bench.plans.scores import COLUMNS, SCORES

WITH, WITHOUT = READINGS
SHOWN = (*SCORES, "doors_f1", "edges_f1")
HEADINGS = {column.key: column.heading.replace("\n", " ") for column in COLUMNS}
BESIDE = ("found", "true", "floors", "aside", "scale_error", "seconds")
BUILDINGS = ("school", "office")
# Plans smaller than this, in million pixels, tell little of the time that a large one takes.
LARGE, LARGE_MEANT = 2.0, 6.0
UNSOUND = "*"

Choice = Callable[[PlanResult], bool]


def tabulate_plans(bench: PlanBench) -> list[ComparisonTable]:
    """All tables of the bench but that of text."""
    real = [result for result in bench.results.get("real", ()) if result.rows]
    drawn = [result for result in bench.results.get("drawn", ()) if result.rows]
    tables = []
    if real:
        tables += [_tabulate_each("Plans, each", real), _tabulate_kinds(real), _tabulate_symbols("Plans", real)]
        tables.append(_tabulate_bars(real, bench))
    if drawn:
        tables += [_tabulate_each("Drawn plans, each", drawn, mean=True), _tabulate_symbols("Drawn plans", drawn)]
    return tables


def list_faults(bench: PlanBench) -> Iterator[str]:
    """A line for each plan that could not be read, or of which there is no truth, and what else went wrong."""
    for of, results in bench.results.items():
        for result in results:
            if result.truth_failure:
                yield f"{result.name} ({of}) has no truth, not counted: {result.truth_failure}"
            for reading, row in result.rows.items():
                if row.failure:
                    yield f"{result.name} ({of}, {reading}) failed, counts as 0: {row.failure}"
    if bench.text_failure:
        yield f"Names on drawn plans were not read: {bench.text_failure}"
    warned = sorted({row.item for rows in bench.items.values() for row in rows if row.warned})
    if warned:
        yield f"Warnings on {len(warned)} plans; --json lists them."


def is_sound(result: PlanResult) -> bool:
    """Whether a plan counts for the bars: a school or an office, no screenshot, with a sound truth."""
    return result.kind != SCREENSHOT and result.building_type in BUILDINGS and not result.defects


def figures_of(results: Sequence[PlanResult], key: str, reading: str = WITH) -> list[float | None]:
    """A figure of each plan."""
    return [result.rows[reading].figures[key] for result in results]


def accuracy_of(result: PlanResult, reading: str) -> float:
    """The mean of A_FC and A_BC, by which readings of a plan are compared."""
    figures = result.rows[reading].figures
    return ((figures["a_fc"] or 0.0) + (figures["a_bc"] or 0.0)) / 2


def _tabulate_each(title: str, results: Sequence[PlanResult], *, mean: bool = False) -> ComparisonTable:
    """A row a plan, kind by kind."""
    keys = (*SHOWN, *BESIDE)
    order = {kind: place for place, kind in enumerate(KINDS)}
    ordered = sorted(results, key=lambda result: (order.get(result.kind, len(order)), result.name))
    rows = [
        ComparisonRow(f"{result.name}{UNSOUND * bool(result.defects)}", tuple(_cells_of([result], keys)), 0)
        for result in ordered
    ]
    if mean:
        rows.append(ComparisonRow("mean", tuple(_cells_of(results, keys))))
    notes = [f"{UNSOUND} {result.name}: the truth {', '.join(result.defects)}." for result in ordered if result.defects]
    notes.append(
        "doors: within half the width of a true one, entrances left out; edges: pairs of rooms that doors join; aside: "
        "% of the found area in floors of the sheet that the truth does not tell of, which are not judged."
    )
    notes.append("scale error: of metres per pixel; annotators of real plans judged the width of a door by eye.")
    return ComparisonTable(f"{title}, {WITH}", tuple(HEADINGS[key] for key in keys), tuple(rows), tuple(notes), "%")


def _cells_of(results: Sequence[PlanResult], keys: Sequence[str]) -> Iterator[Cell]:
    for key in keys:
        yield Cell.over(figures_of(results, key))


def _tabulate_kinds(results: Sequence[PlanResult]) -> ComparisonTable:
    """Means by kind of drawing and of building, over sound truths, and medians of all."""
    sound = [result for result in results if is_sound(result)]
    kinds = [(kind, [result for result in sound if result.kind == kind]) for kind in KINDS]
    types = [(f"{name}s", [result for result in sound if result.building_type == name]) for name in BUILDINGS]
    apart = [
        ("truth not sound", [result for result in results if result.defects]),
        ("screenshots", [result for result in results if result.kind == SCREENSHOT]),
    ]
    groups = [*kinds, *types, ("all", sound)]
    rows = [_row_of(name, of) for name, of in groups if of]
    rows.append(ComparisonRow(f"all, median ({len(sound)})", tuple(_median(figures_of(sound, key)) for key in SHOWN)))
    rows += [_row_of(f"apart: {name}", of) for name, of in apart if of]
    notes = ("Kinds by the look of a plan; all: schools and offices with a sound truth, no screenshots.",)
    return ComparisonTable(f"Kinds of plans, {WITH}", tuple(HEADINGS[key] for key in SHOWN), tuple(rows), notes, "%")


def _row_of(name: str, results: Sequence[PlanResult]) -> ComparisonRow:
    return ComparisonRow(f"{name} ({len(results)})", tuple(_cells_of(results, SHOWN)))


def _median(figures: Sequence[float | None]) -> Cell:
    known = [figure for figure in figures if figure is not None]
    return Cell(median(known) if known else None, count=len(known))


def _tabulate_symbols(title: str, results: Sequence[PlanResult]) -> ComparisonTable:
    """Both readings of the plans that draw their doors, and what symbols add."""
    drawing = [result for result in results if result.draws_doors and not result.defects and result.kind != SCREENSHOT]
    rows = [
        ComparisonRow(reading, tuple(Cell.over(figures_of(drawing, key, reading)) for key in SHOWN))
        for reading in READINGS
    ]
    differences = tuple(
        Cell.over(
            one - other
            for one, other in zip(figures_of(drawing, key), figures_of(drawing, key, WITHOUT), strict=True)
            if one is not None and other is not None
        )
        for key in SHOWN
    )
    rows.append(ComparisonRow("difference", differences))
    names = f"{title} that draw their doors ({len(drawing)}), with and without symbols"
    return ComparisonTable(names, tuple(HEADINGS[key] for key in SHOWN), tuple(rows), tuple(_tell_better(drawing)), "%")


def _tell_better(results: Sequence[PlanResult]) -> Iterator[str]:
    better = sum(accuracy_of(result, WITH) > accuracy_of(result, WITHOUT) for result in results)
    equal = sum(accuracy_of(result, WITH) == accuracy_of(result, WITHOUT) for result in results)
    yield (
        f"Better with symbols, by the mean of A_FC and A_BC, on {better} of {len(results)} plans; "
        f"equal, which does not count as better, on {equal}."
    )


def _tabulate_bars(results: Sequence[PlanResult], bench: PlanBench) -> ComparisonTable:
    """The figures that are asked for, beside the bar and the aim of each."""
    sound = [result for result in results if is_sound(result)]
    drawing = [result for result in sound if result.draws_doors]
    better = [100.0 * (accuracy_of(result, WITH) > accuracy_of(result, WITHOUT)) for result in drawing]
    bars: list[tuple[str, float | None, float, float | None]] = []
    for key in ("a_fc", "a_bc"):
        bars.append((f"{HEADINGS[key]}, median, at least", _median(figures_of(sound, key)).mean, 82, 92))
        bars.append((f"{HEADINGS[key]}, mean, at least", Cell.over(figures_of(sound, key)).mean, 74, None))
    bars.append(("doors F1, median, at least", _median(figures_of(drawing, "doors_f1")).mean, 70, 85))
    bars.append(("better with symbols, % of plans, at least", fmean(better) if better else None, 80, None))
    bars.append(("seconds for 6 million pixels, at most", _slowest(results), 15 if bench.with_text else 5, None))
    bars.append(("printed names read exactly, %, at least", _share_of_names(bench), 90, None))
    rows = tuple(ComparisonRow(name, tuple(map(Cell, figures))) for name, *figures in bars)
    notes = (
        f"Schools and offices with a sound truth, {len(sound)}; doors, symbols: {len(drawing)} that draw their doors.",
        f"Seconds: the slowest of the plans above {LARGE:g} million pixels, in proportion.",
    )
    return ComparisonTable("Bars", ("measured", "bar", "aim"), rows, notes)


def _share_of_names(bench: PlanBench) -> float | None:
    """Percent of the names on drawn sheets that were read exactly."""
    if bench.text is None:
        return None
    exact, names = (
        sum(row.figures[key] or 0 for part in bench.text.parts for row in part.rows) for key in ("exact", "names")
    )
    return 100 * exact / names if names else None


def _slowest(results: Sequence[PlanResult]) -> float | None:
    """Seconds for LARGE_MEANT million pixels on the plan that was slowest for its size, of the large ones."""
    times = zip(figures_of(results, "seconds"), figures_of(results, "megapixels"), strict=True)
    large = [
        LARGE_MEANT * time / size for time, size in times if time is not None and size is not None and size > LARGE
    ]
    return max(large, default=None)
