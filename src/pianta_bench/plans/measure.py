"""Pictures of plans, read with and without their symbols, against their true layouts (section 3.3)."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import chain
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter
from typing import Protocol

from PIL import Image

from pianta.errors import OptionError, PiantaError, PlanWarning
from pianta.io._files import one_line_reason
from pianta_bench.data.annotated_floors import read_buildings_of_files
from pianta_bench.data.folders import find_data
from pianta_bench.harness.comparison import Items
from pianta_bench.harness.table import BenchTable, Figures, Row, measure_row
from pianta_bench.plans.figures import save_plan_picture
from pianta_bench.plans.plan_sets import (
    DRAWN,
    KIND_OF_PLAN,
    TruePlan,
    draw_true_plan,
    find_image,
    list_plans,
    read_true_plan,
)
from pianta_bench.plans.scores import COLUMNS, PlanRead, judge_floors, score_reading

SET_NAMES = ("real", "drawn")
# Readings of each plan, by whether symbols are handled.
READINGS: Mapping[str, bool] = {"with symbols": True, "without": False}


class PlanReader(Protocol):
    """Reads a plan, as pianta.plan.read_plan.read_plan does."""

    def __call__(self, path: Path, *, with_symbols: bool, with_text: bool) -> PlanRead:
        """The floors on a sheet."""


@dataclass(frozen=True)
class PlanResult:
    """What was measured on a plan.

    kind, building_type, draws_doors, defects: as of TruePlan. rows: by the names of READINGS.
    scales: by the same, where the scale is from. truth_failure: why there is no truth, and nothing was measured.
    """

    name: str
    kind: str
    building_type: str = ""
    draws_doors: bool = True
    defects: tuple[str, ...] = ()
    rows: Mapping[str, Row] = field(default_factory=dict)
    scales: Mapping[str, str] = field(default_factory=dict)
    truth_failure: str | None = None


@dataclass(frozen=True)
class PlanBench:
    """What was measured, by the names of SET_NAMES.

    text: how names on drawn sheets are read. text_failure: why that was not measured, where it was wanted.
    """

    results: Mapping[str, Sequence[PlanResult]]
    with_text: bool
    text: BenchTable | None = None
    text_failure: str | None = None

    @property
    def items(self) -> Items:
        """Rows by set and reading."""
        return {
            f"{name}, {reading}": [result.rows[reading] for result in results if reading in result.rows]
            for name, results in self.results.items()
            for reading in READINGS
        }

    @property
    def failed(self) -> bool:
        """Whether a plan could not be read or has no truth, or names on a drawn sheet could not be read."""
        truths = any(result.truth_failure for results in self.results.values() for result in results)
        text = bool(self.text and self.text.failed)
        return truths or text or any(row.failure for rows in self.items.values() for row in rows)


def measure_plans(
    data: Path | None = None,
    *,
    sets: Sequence[str] = (),
    only: Sequence[str] = (),
    with_text: bool = True,
    jobs: int = 1,
    pictures: Path | None = None,
    track: Callable[[Sequence[str]], Iterable[str]] = iter,
    read: PlanReader | None = None,
) -> PlanBench:
    """Read each plan twice, with and without handling its symbols, and score what was found.

    data: the folder of the data, needed by the set "real". sets: of SET_NAMES, both when empty. only: names of plans.
    with_text: whether names are read, too. jobs: processes. pictures: an existing folder for NAME.png.
    track: wraps the names, to show progress. read: in place of read_plan.
    Raises OptionError for the name of no set or no plan, DataError when there are no plans.
    """
    names = choose_plans(data, sets, only)
    folder = find_data(data) if names.get("real") else None
    measure = partial(
        measure_plan, data=folder, with_text=with_text, pictures=pictures, read=read or _default_reader(folder)
    )
    jobs_of = [(name, name_of_set) for name_of_set, plans in names.items() for name in plans]
    done = list(_run_all(measure, [name for name, _ in jobs_of], jobs, track))
    results = {
        name_of_set: tuple(result for result, (_, of) in zip(done, jobs_of, strict=True) if of == name_of_set)
        for name_of_set in names
    }
    text, failure = _measure_text(track) if with_text and "drawn" in names and not only else (None, None)
    return PlanBench(results, with_text, text, failure)


def choose_plans(data: Path | None, sets: Sequence[str], only: Sequence[str]) -> dict[str, list[str]]:
    """Names of the plans by set, without sets that have none; errors as of measure_plans."""
    unknown = [name for name in sets if name not in SET_NAMES]
    if unknown:
        raise OptionError(f"set is {unknown[0]!r}, give one of {', '.join(SET_NAMES)}")
    wanted = sets or ([] if only and all(name in DRAWN for name in only) else ["real"]) + ["drawn"]
    names = {"real": list_plans(find_data(data))} if "real" in wanted else {}
    names |= {"drawn": list(DRAWN)} if "drawn" in wanted else {}
    strange = sorted(set(only).difference(*names.values()))
    if strange:
        known = ", ".join(chain.from_iterable(names.values()))
        raise OptionError(f"plan {strange[0]!r} is not there, give some of {known}")
    chosen = {of: [name for name in plans if not only or name in only] for of, plans in names.items()}
    return {of: plans for of, plans in chosen.items() if plans}


def measure_plan(
    name: str, *, data: Path | None, with_text: bool, pictures: Path | None, read: PlanReader
) -> PlanResult:
    """Both readings of one plan, which is drawn when its name is one of DRAWN."""
    try:
        with warnings.catch_warnings():
            # What is wrong with a truth is told by its defects.
            warnings.simplefilter("ignore")
            plan = draw_true_plan(name) if name in DRAWN else read_true_plan(data or Path(), name)
    except PiantaError as error:
        return PlanResult(name, KIND_OF_PLAN.get(name, ""), truth_failure=one_line_reason(error))
    with TemporaryDirectory() as folder:
        if name in DRAWN:
            file = Path(folder, f"{name}.png")
            Image.fromarray(plan.colors).save(file)
        else:
            file = find_image(data or Path(), name)
        return _measure_readings(plan, file, with_text=with_text, pictures=pictures, read=read)


def _measure_readings(
    plan: TruePlan, file: Path, *, with_text: bool, pictures: Path | None, read: PlanReader
) -> PlanResult:
    scales: dict[str, str] = {}

    def measure(reading: str) -> Iterator[Figures]:
        warnings.simplefilter("always", PlanWarning)
        rows, cols = plan.grid.shape
        yield {"true": len(plan.truth.rooms), "megapixels": rows * cols / 1e6}
        start = perf_counter()
        found = read(file, with_symbols=READINGS[reading], with_text=with_text)
        yield {"seconds": perf_counter() - start}
        figures = score_reading(found, plan)
        scales[reading] = found.floors[0].scale.source if found.floors else ""
        yield figures
        if pictures and READINGS[reading]:
            save_plan_picture(plan, judge_floors(found.floors, plan)[0], figures, pictures / f"{plan.name}.png")

    rows = {reading: replace(measure_row(reading, measure, columns=COLUMNS), item=plan.name) for reading in READINGS}
    return PlanResult(plan.name, plan.kind, plan.building_type, plan.draws_doors, plan.defects, rows, scales)


def _run_all(
    measure: Callable[[str], PlanResult],
    names: Sequence[str],
    jobs: int,
    track: Callable[[Sequence[str]], Iterable[str]],
) -> Iterator[PlanResult]:
    if jobs == 1:
        return (measure(name) for name in track(names))
    from joblib import Parallel, delayed

    made = Parallel(n_jobs=jobs, return_as="generator")(delayed(measure)(name) for name in names)
    return (result for _, result in zip(track(names), made, strict=True))


def _read_unseen(path: Path, *, with_symbols: bool, with_text: bool, buildings: Mapping[str, str]) -> PlanRead:
    """A plan read by the networks that were made without its building."""
    from pianta.plan.read_plan import read_plan
    from pianta.plan.walls.segmentation import networks_without

    networks = networks_without(buildings.get(path.stem, path.stem))
    return read_plan(path, with_symbols=with_symbols, with_text=with_text, networks=networks)


def _default_reader(data: Path | None) -> PlanReader:
    files = read_buildings_of_files(data) if data else {}
    return partial(_read_unseen, buildings={Path(file).stem: building for file, building in files.items()})


def _measure_text(track: Callable[[Sequence[str]], Iterable[str]]) -> tuple[BenchTable | None, str | None]:
    """How printed names are read, or why that cannot be measured."""
    from pianta_bench.plans.text import measure_text

    try:
        return measure_text(track=track), None
    except (ImportError, PiantaError) as error:
        return None, one_line_reason(error)
