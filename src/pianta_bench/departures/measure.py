"""Rooms by Algorithm 1 as the thesis prints it, by ours, and by all that lie one departure from either."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import lru_cache, partial
from pathlib import Path
from typing import Any

from pianta.errors import DataError
from pianta.evaluation.coverage import score_layout
from pianta.floor import Floor
from pianta.gridmap import GridMap
from pianta.io._files import short_repr
from pianta.layout.parameters import CLUTTER, DEPARTURES, ThesisParameters
from pianta.layout.thesis.reconstruct import reconstruct_layout
from pianta_bench.data.folders import REMEDY, check_set, find_data
from pianta_bench.data.layout_sets import LAYOUT_SETS
from pianta_bench.data.map_sets import SETS, TrueMap, choose_sets
from pianta_bench.harness.records import Figures, Results, Track
from pianta_bench.layout.as_printed import AS_PRINTED, BARE_SETS
from pianta_bench.segmentation.measure import score_floor

DEPARTURE_SETS = ("schools", "survey", "furniture")
DEFAULT = "ours"
# Departures that do not change rooms, only which of them are partial.
NO_ROOMS = ("partial faces need an open edge",)
SCORES = ("a_fc_walls", "a_bc_walls", "precision_rest", "recall_rest", "mean_iou", "f1")
# Of these the difference from the variant that has one departure more or less.
CHANGES = ("mean_iou", "f1")
FAILED: Figures = {**dict.fromkeys(SCORES, 0.0), "rooms": 0.0}


def measure(data: Path | None = None, *, sets: Sequence[str] | None = None, track: Track = iter) -> Results:
    """Scores of all variants of Algorithm 1, and their differences from AS_PRINTED or DEFAULT, map by map.

    Variants: AS_PRINTED, the same with each departure alone ("+ …"), DEFAULT, and ours without each ("− …"). Doors are
    not looked for and partial rooms not predicted, which changes no score. Small groups of cells stay in empty maps as
    printed, and go in furnished ones, so that this departure changes nothing there.
    sets: of DEPARTURE_SETS, all unless given. track: wraps the names of the maps, to show progress.
    Raises OptionError for the name of no set, DataError if there are no maps.
    """
    for name in sets or ():
        check_set(name, DEPARTURE_SETS)
    folder = find_data(data)
    there = choose_sets(sets or (), folder)
    chosen = {mapset: items for mapset, items in there.items() if mapset.name in DEPARTURE_SETS}
    if not chosen:
        raise DataError(f"no data in {short_repr(folder)}: none of {', '.join(DEPARTURE_SETS)} is there, {REMEDY}")
    results = Results({"sets": [mapset.name for mapset in chosen]})
    jobs = [(mapset, item) for mapset, items in chosen.items() for item in items]
    for _, (mapset, item) in zip(track([item for _, item in jobs]), jobs, strict=True):
        read = lru_cache(maxsize=1)(partial(read_map_and_layout, folder, mapset.name, item))
        for variant, parameters in list_variants(mapset.name).items():
            measure_one = partial(measure_variant, read, mapset.name, parameters)
            results.measure(mapset.name, item, measure_one, failed=FAILED, variant=variant)
    add_changes(results)
    return results


def list_variants(part: str) -> dict[str, ThesisParameters]:
    """The variants of Algorithm 1 by name, for a set of maps."""
    departures = {
        name: values
        for name, values in DEPARTURES.items()
        if name not in NO_ROOMS and (name != CLUTTER or part in BARE_SETS)
    }
    printed = {key: value for values in departures.values() for key, value in values.items()}

    def without(values: Mapping[str, Any]) -> ThesisParameters:
        return ThesisParameters(**{key: value for key, value in printed.items() if key not in values})

    return {
        AS_PRINTED: without({}),
        **{f"+ {name}": without(values) for name, values in departures.items()},
        DEFAULT: ThesisParameters(),
        **{f"− {name}": ThesisParameters(**values) for name, values in departures.items()},
    }


def read_map_and_layout(data: Path, part: str, item: str) -> tuple[TrueMap, GridMap, Floor]:
    """A map as segmentation counts it, and as layouts are counted."""
    return SETS[part].read(data / SETS[part].folder, item), *LAYOUT_SETS[part].read(data, item)


def measure_variant(read: Any, part: str, parameters: ThesisParameters) -> Iterator[Figures]:
    """The scores of one map by one variant, %."""
    true_map, grid, truth = read()
    floor = reconstruct_layout(grid, parameters=parameters, with_doors=False)
    walls = score_layout([room.polygon for room in floor], [room.polygon for room in truth])
    figures = score_floor(floor, true_map, SETS[part])
    yield {
        "a_fc_walls": 100 * walls.a_fc,
        "a_bc_walls": 100 * walls.a_bc,
        **{score: figures[score] for score in SCORES if score in figures},
        "rooms": 100 * figures["found"] / figures["true"] if figures["found"] and figures["true"] else 0.0,
    }


def add_changes(results: Results) -> None:
    """Add for each map the differences of the variants from AS_PRINTED or DEFAULT."""
    values = {
        (record["part"], record["item"], record["variant"], record["metric"]): record["value"]
        for record in results.select(metric=CHANGES)
    }
    for (part, item, variant, metric), value in values.items():
        base = AS_PRINTED if variant.startswith("+") or variant == DEFAULT else DEFAULT
        if variant != AS_PRINTED:
            change = value - values[part, item, base, metric]
            results.add(part, item, {f"{metric}_change": change}, variant=variant)
