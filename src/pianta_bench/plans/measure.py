"""Pictures of plans, read with and without their symbols, against their true layouts (section 3.3)."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from itertools import chain
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter
from typing import Any, TypeAlias

from PIL import Image

from pianta.errors import OptionError, PiantaError, PlanWarning
from pianta.io._files import one_line_reason
from pianta.plan.read_plan import PlanReading, read_plan
from pianta.plan.walls.segmentation import networks_without
from pianta_bench.data.building_of import building_of
from pianta_bench.data.folders import find_data
from pianta_bench.harness.parallel import run_steps
from pianta_bench.harness.records import Figures, Item, Results, Track
from pianta_bench.plans import SET_NAMES
from pianta_bench.plans.figures import save_plan_picture
from pianta_bench.plans.plan_sets import DRAWN_PLANS, TruePlan, draw_true_plan, find_image, list_plans, read_true_plan
from pianta_bench.plans.scores import FAILED, UNITS, match_floors, score_reading
from pianta_bench.plans.text import measure_text

WITH, WITHOUT = "with symbols", "without"
# By reading of each plan: whether symbols are handled.
READINGS = {WITH: True, WITHOUT: False}

# Reads a plan, as `read_plan` does with the keywords with_symbols and with_text.
PlanReader: TypeAlias = Callable[..., PlanReading]


def measure(
    data: Path | None = None,
    *,
    sets: Sequence[str] | None = None,
    only: Sequence[str] | None = None,
    with_text: bool = True,
    jobs: int = 1,
    pictures: Path | None = None,
    track: Track = iter,
    read: PlanReader | None = None,
) -> Results:
    """Read each plan twice, with and without its symbols, and score the floors; then read names on drawn sheets.

    data: the folder of the data, needed by the set "real". sets: of SET_NAMES, both by default. only: names of plans.
    with_text: whether what is written is read, too. jobs: processes. pictures: folder for NAME.png.
    track: wraps the names, to show progress. read: replaces `read_plan`.
    Raises OptionError for the name of no set or no plan, DataError if there are no plans.
    """
    names = choose_plans(data, sets or (), only or ())
    if pictures:
        pictures.mkdir(parents=True, exist_ok=True)
    folder = find_data(data) if "real" in names else None
    results = Results({"sets": [*names], "only": only, "with_text": with_text}, details={"units": UNITS})
    measure_one = partial(
        measure_plan, data=folder, with_text=with_text, pictures=pictures, read=read or _default_reader(folder)
    )
    steps = {name: partial(measure_one, name) for name in chain.from_iterable(names.values())}
    results.details["plans"] = []
    for plan in run_steps(steps, jobs=jobs, track=track):
        results.extend(plan)
        results.details["plans"].append(plan.details)
    if with_text and "drawn" in names and not only:
        try:
            results.extend(measure_text(track=track))
        except (ImportError, PiantaError) as error:
            results.details["text_failure"] = one_line_reason(error)
    return results


def choose_plans(data: Path | None, sets: Sequence[str], only: Sequence[str]) -> dict[str, list[str]]:
    """Names of the plans by set, without sets that have none; errors as of `measure`."""
    for name in sets:
        if name not in SET_NAMES:
            raise OptionError(f"set is {name!r}, give one of {', '.join(SET_NAMES)}")
    wanted = sets or ([] if only and all(name in DRAWN_PLANS for name in only) else ["real"]) + ["drawn"]
    names = {"real": list_plans(find_data(data))} if "real" in wanted else {}
    names |= {"drawn": list(DRAWN_PLANS)} if "drawn" in wanted else {}
    absent = sorted(set(only).difference(*names.values()))
    if absent:
        available = ", ".join(chain.from_iterable(names.values()))
        raise OptionError(f"plan {absent[0]!r} does not exist, give some of {available}")
    chosen = {part: [name for name in plans if not only or name in only] for part, plans in names.items()}
    return {part: plans for part, plans in chosen.items() if plans}


def measure_plan(name: str, *, data: Path | None, with_text: bool, pictures: Path | None, read: PlanReader) -> Results:
    """Both readings of one plan, which is synthetic if it is in DRAWN_PLANS; details: kind, defects, and scales."""
    part = "drawn" if name in DRAWN_PLANS else "real"
    results = Results(details={"set": part, "plan": name})
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # the defects of the truth are in the results
            plan = draw_true_plan(name) if name in DRAWN_PLANS else read_true_plan(data or Path(), name)
    except PiantaError as error:
        results.items.append(Item(f"{part}, truth", name, one_line_reason(error)))
        return results
    fields: dict[str, Any] = {
        "set": part,
        "kind": plan.kind,
        "building_type": plan.building_type,
        "draws_doors": plan.draws_doors,
        "is_sound": not plan.defects,
    }
    scales: dict[str, str] = {}
    results.details |= {**fields, "defects": plan.defects, "scales": scales}
    with TemporaryDirectory() as folder:
        if name in DRAWN_PLANS:
            file = Path(folder, f"{name}.png")
            Image.fromarray(plan.colors).save(file)
        else:
            file = find_image(data or Path(), name)
        for reading, with_symbols in READINGS.items():
            read_one = partial(read, file, with_symbols=with_symbols, with_text=with_text)
            measure_one = partial(_measure_reading, plan, read_one, scales=scales, reading=reading, pictures=pictures)
            results.measure(f"{part}, {reading}", name, measure_one, failed=FAILED, reading=reading, **fields)
    return results


def _measure_reading(
    plan: TruePlan, read: Callable[[], PlanReading], *, scales: dict[str, str], reading: str, pictures: Path | None
) -> Iterator[Figures]:
    """The figures of one reading; adds the source of its scale to `scales`, and saves its picture."""
    warnings.simplefilter("always", PlanWarning)
    rows, cols = plan.grid.shape
    yield {"true": len(plan.truth.rooms), "megapixels": rows * cols / 1e6}
    start = perf_counter()
    sheet = read()
    yield {"seconds": perf_counter() - start}
    figures = score_reading(sheet, plan)
    scales[reading] = sheet.floors[0].scale.source if sheet.floors else ""
    yield figures
    if pictures and READINGS[reading]:
        save_plan_picture(plan, match_floors(sheet.floors, plan)[0], figures, pictures / f"{plan.name}.png")


def _read_unseen(path: Path, *, with_symbols: bool, with_text: bool, data: Path) -> PlanReading:
    """A plan of the data, or a drawn one, read by the networks that were not fitted on its building."""
    inside = path.relative_to(data) if path.is_relative_to(data) else Path(path.name)
    networks = networks_without(building_of(data, inside.as_posix()))
    return read_plan(path, with_symbols=with_symbols, with_text=with_text, networks=networks)


def _default_reader(data: Path | None) -> PlanReader:
    return partial(_read_unseen, data=data or Path())
