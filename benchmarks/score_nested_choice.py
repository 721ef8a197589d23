"""Score the method `structure` with thresholds that are chosen without the buildings on which they are scored.

Run: OMP_NUM_THREADS=1 python benchmarks/score_nested_choice.py NETWORKS [--data DIR] [--scores FILE] [--rounds N]

NETWORKS is the folder of score_left_out_buildings.py: each map is read by a network that its building was left out of.
For each group of FOLDS the thresholds of CANDIDATES are chosen on the maps of the other groups, and scored on those of
the group. The start is the first candidate of each, not the value that pianta has. One threshold after the other takes
the candidate with the highest mean of IoU and F1, the mean over maps of a building first, then over buildings; until
nothing changes, at most N rounds. The networks of the other groups have seen the buildings of the group, so the choice
could still profit from them by this way; to exclude that, networks for all pairs of groups would be needed.

Schools take no part: they are scored with the thresholds that are chosen on all other maps, by pianta's own network.

--scores keeps every score in a file, so that a run that was stopped goes on. Printed are the thresholds of each group;
what each candidate gave on all maps; by set the mean ± sd with the values of pianta, with the nested choice, at the
start, and with one choice on all maps (which sees everything); and the difference of nested choice and pianta by map,
with a 95 % interval of a bootstrap of buildings.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections import defaultdict
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
from score_left_out_buildings import FOLDS, SETS, use_network

from pianta._types import Floats
from pianta.evaluation.segmentation import score_labels
from pianta.layout._numbering import assemble_floor
from pianta.layout.parameters import StructureParameters
from pianta.layout.structure import evidence, pieces, reconstruct
from pianta_bench.data.folders import find_data
from pianta_bench.data.map_sets import MapSet, choose_sets
from pianta_bench.segmentation.measure import cut_spaces

# The threshold of the multicut is a constant of pieces.py, the others are fields of StructureParameters.
CAUTION = "CAUTION"
SCHOOLS = "schools"
NOT_SCHOOLS = "all but schools"
OWN_NETWORK = evidence._read_network
# Thresholds that were chosen on the maps of the benches, with the candidates from which the nested choice starts at the
# first: those of CAUTION are those of its comment, the others lie around what a door or a small room measures.
CANDIDATES = {
    CAUTION: (0.0, 0.5, 0.75, 1.0, 1.5),
    "mouth_ratio": (0.5, 0.65, 0.8),
    "saddle_ratio": (0.84, 0.92, 0.98),
    "clutter_size": (1.0, 1.5, 2.0),
    "room_width": (0.35, 0.5, 0.7),
    "room_area": (0.25, 0.5, 1.0),
}
START = tuple(values[0] for values in CANDIDATES.values())
SHIPPED = tuple(pieces.CAUTION if name == CAUTION else getattr(StructureParameters(), name) for name in CANDIDATES)
DRAWS = 2000  # of the bootstrap

# Values of CANDIDATES, in their order.
Setting: TypeAlias = tuple[float, ...]
# The name of a set, and of a map in it.
MapName: TypeAlias = tuple[str, str]


@dataclass
class Scorer:
    """Mean IoU and F1 of maps by settings, %, each computed once.

    scores: by set, map and setting. file: where they are kept, if anywhere.
    """

    data: Path
    networks: Path
    sets: dict[str, MapSet]
    buildings: dict[MapName, str]
    scores: dict[tuple[MapName, Setting], tuple[float, float]]
    file: Path | None
    evidence: dict[MapName, Any] = field(default_factory=dict)

    def fill(self, wanted: Iterable[tuple[MapName, Setting]]) -> None:
        """Compute the scores that are missing, map by map."""
        missing = defaultdict(list)
        for name, setting in dict.fromkeys(wanted):
            if (name, setting) not in self.scores:
                missing[name].append(setting)
        for name, settings in missing.items():
            self._score_map(name, settings)

    def _score_map(self, name: MapName, settings: Sequence[Setting]) -> None:
        part, item = name
        mapset = self.sets[part]
        true_map = mapset.read(self.data / mapset.folder, item)
        truth = cut_spaces(true_map.spaces, true_map, mapset)
        if part == SCHOOLS:
            evidence._read_network = OWN_NETWORK
        else:
            use_network(self.networks, self.buildings[name])
        with Memory(name, self.evidence):
            for setting in settings:
                pieces.CAUTION, *_ = setting
                fields = dict(zip(CANDIDATES, setting, strict=True))
                del fields[CAUTION]
                parameters = StructureParameters(**fields)
                try:
                    rooms, _ = reconstruct.list_regions(reconstruct.divide_floor(true_map.grid, parameters), parameters)
                    floor = assemble_floor(rooms, [], [], true_map.grid)
                    labels = floor.label_image(true_map.grid).astype(np.int32)
                    scores = score_labels(cut_spaces(labels, true_map, mapset), truth)
                    self.scores[name, setting] = 100 * scores.mean_iou, 100 * scores.f1
                except Exception as error:  # counts as 0, as in the benches
                    sys.stderr.write(f"{part} {item} {setting}: {error}\n")
                    self.scores[name, setting] = 0.0, 0.0
        pieces.CAUTION = SHIPPED[0]
        self._save()

    def _save(self) -> None:
        if self.file:
            self.file.write_text(json.dumps([[*key, value] for key, value in self.scores.items()]), encoding="utf-8")

    def mean(self, names: Sequence[MapName], setting: Setting) -> float:
        """Mean of IoU and F1: of the maps of each building, then of the buildings."""
        buildings = defaultdict(list)
        for name in names:
            buildings[self.buildings[name]].append(sum(self.scores[name, setting]) / 2)
        return float(np.mean([np.mean(each) for each in buildings.values()]))


# Functions of the first steps, with the fields of StructureParameters that change their results.
STEPS: dict[str, tuple[str, ...]] = {
    "remove_noise": (),
    "find_boxes": (),
    "evaluate_map": (),
    "find_floor_space": ("clutter_size",),
    "cut_into_pieces": ("clutter_size", "saddle_ratio", "mouth_ratio"),
}


class Memory:
    """Within it the first steps of the method are not repeated for settings of one map that do not change them."""

    def __init__(self, name: MapName, evidence: dict[MapName, Any]) -> None:
        self.own = {step: getattr(reconstruct, step) for step in STEPS}
        self.results: dict[tuple[Any, ...], Any] = {}
        self.name, self.evidence = name, evidence

    def __enter__(self) -> None:
        for step in STEPS:
            setattr(reconstruct, step, self._remember(step))

    def __exit__(self, *_: object) -> None:
        for step, function in self.own.items():
            setattr(reconstruct, step, function)
        self.evidence[self.name] = self.results.get(("evaluate_map",), self.evidence.get(self.name))

    def _remember(self, step: str) -> Callable[..., Any]:
        def run(*arguments: Any, **options: Any) -> Any:  # noqa: ANN401 (functions of any arguments)
            parameters = next((each for each in arguments if isinstance(each, StructureParameters)), None)
            key = (step, *(getattr(parameters, name) for name in STEPS[step]))
            if key not in self.results:
                evidence = self.evidence.get(self.name) if step == "evaluate_map" else None
                self.results[key] = self.own[step](*arguments, **options) if evidence is None else evidence
            return self.results[key]

        return run


def main() -> None:
    """Choose, score and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("networks", type=Path)
    parser.add_argument("--data", type=Path)
    parser.add_argument("--scores", type=Path)
    parser.add_argument("--rounds", type=int, default=2)
    options = parser.parse_args()
    data = find_data(options.data)
    chosen_sets = choose_sets((*SETS, SCHOOLS), data)
    every = [(mapset.name, item) for mapset, items in chosen_sets.items() for item in items]
    names = [name for name in every if name[0] != SCHOOLS]
    scorer = Scorer(
        data,
        options.networks,
        {mapset.name: mapset for mapset in chosen_sets},
        {
            (mapset.name, item): mapset.building_of(data, item)
            for mapset, items in chosen_sets.items()
            for item in items
        },
        read_scores(options.scores) if options.scores and options.scores.exists() else {},
        options.scores,
    )
    groups = {
        f"without group {fold}": [n for n in names if fold_of(scorer.buildings[n]) != fold]
        for fold in range(len(FOLDS))
    }
    groups["all maps"] = names
    chosen, trace = choose_settings(scorer, groups, rounds=options.rounds)
    nested = {
        name: chosen["all maps" if name[0] == SCHOOLS else f"without group {fold_of(scorer.buildings[name])}"]
        for name in every
    }
    ways = {
        "values of pianta": dict.fromkeys(every, SHIPPED),
        "nested choice": nested,
        "start": dict.fromkeys(every, START),
        "chosen on all maps": dict.fromkeys(every, chosen["all maps"]),
    }
    for settings in ways.values():
        scorer.fill(settings.items())
    print_choices(scorer, groups, chosen)
    print_candidates(scorer, names, trace["all maps"])
    print_scores(scorer, ways)


def fold_of(building: str) -> int:
    """The group of FOLDS with a building."""
    return next(fold for fold, buildings in enumerate(FOLDS) if building in buildings)


def read_scores(file: Path) -> dict[tuple[MapName, Setting], tuple[float, float]]:
    """The scores of an earlier run."""
    rows = json.loads(file.read_text(encoding="utf-8"))
    return {((part, item), tuple(setting)): (iou, f1) for (part, item), setting, (iou, f1) in rows}


def choose_settings(
    scorer: Scorer, groups: dict[str, list[MapName]], *, rounds: int
) -> tuple[dict[str, Setting], dict[str, list[list[Setting]]]]:
    """The setting of each group of maps, of equally good candidates the first; and the settings tried in each step."""
    chosen = dict.fromkeys(groups, START)
    trace: dict[str, list[list[Setting]]] = {group: [] for group in groups}
    for _ in range(rounds):
        before = dict(chosen)
        for position, values in enumerate(CANDIDATES.values()):
            tried = {
                group: [(*setting[:position], value, *setting[position + 1 :]) for value in values]
                for group, setting in chosen.items()
            }
            scorer.fill(
                (name, setting) for group, settings in tried.items() for setting in settings for name in groups[group]
            )
            for group, settings in tried.items():
                trace[group].append(settings)
                chosen[group] = max(settings, key=lambda setting: scorer.mean(groups[group], setting))
            sys.stderr.write(f"{list(CANDIDATES)[position]}: {chosen}\n")
        if chosen == before:
            break
    return chosen, trace


def print_choices(scorer: Scorer, groups: dict[str, list[MapName]], chosen: dict[str, Setting]) -> None:
    """Print the thresholds of each group, and the mean that they were chosen by beside that of pianta's values."""
    sys.stdout.write(f"{'thresholds chosen on':24}{' '.join(f'{name:>13}' for name in CANDIDATES)}\n")
    for title, setting in ({"start": START, "values of pianta": SHIPPED} | chosen).items():
        sys.stdout.write(f"{title:24}{' '.join(f'{value:13g}' for value in setting)}")
        if title in groups:
            scorer.fill((name, SHIPPED) for name in groups[title])
            means = [scorer.mean(groups[title], each) for each in (setting, SHIPPED)]
            sys.stdout.write(f"   mean {means[0]:.1f}, with the values of pianta {means[1]:.1f}")
        sys.stdout.write("\n")


def print_candidates(scorer: Scorer, names: list[MapName], trace: list[list[Setting]]) -> None:
    """Print what the candidates gave on all maps, each threshold with the others as chosen so far: what it matters."""
    for position, settings in enumerate(trace):
        name = list(CANDIDATES)[position % len(CANDIDATES)]
        means = (f"{setting[position % len(CANDIDATES)]:g}: {scorer.mean(names, setting):.2f}" for setting in settings)
        sys.stdout.write(f"mean of all maps by {name}, the others as chosen so far: {', '.join(means)}\n")


def print_scores(scorer: Scorer, ways: dict[str, dict[MapName, Setting]]) -> None:
    """Print mean ± sd of IoU and F1 of each set, and the differences of the nested choice by map."""
    names = list(ways["nested choice"])
    parts = [*dict.fromkeys(part for part, _ in names), NOT_SCHOOLS]
    for part in parts:
        own = [name for name in names if name[0] in (SETS if part == NOT_SCHOOLS else (part,))]
        for way, settings in ways.items():
            values = np.array([scorer.scores[name, settings[name]] for name in own])
            (iou, f1), (iou_sd, f1_sd) = values.mean(axis=0), values.std(axis=0, ddof=1)
            text = f"mean IoU {iou:.1f} ± {iou_sd:.1f}, F1 {f1:.1f} ± {f1_sd:.1f}"
            sys.stdout.write(f"{part} ({len(own)}), {way}: {text}\n")
        nested, shipped = (
            np.array([scorer.scores[name, ways[way][name]] for name in own])
            for way in ("nested choice", "values of pianta")
        )
        low, high = bootstrap_buildings([scorer.buildings[name] for name in own], nested - shipped)
        change = (nested - shipped).mean(axis=0)
        worse, better = ((nested - shipped).sum(axis=1) < -1e-9).sum(), ((nested - shipped).sum(axis=1) > 1e-9).sum()
        sys.stdout.write(
            f"{part}: nested − pianta IoU {change[0]:+.1f} ({low[0]:+.1f} … {high[0]:+.1f}), "
            f"F1 {change[1]:+.1f} ({low[1]:+.1f} … {high[1]:+.1f}); {worse} maps worse, {better} better\n"
        )


def bootstrap_buildings(owners: Sequence[str], values: Floats) -> tuple[Floats, Floats]:
    """The 95 % interval of the mean of values, shape (maps, columns), when buildings are drawn with replacement.

    owners: the building of each map.
    """
    rows = [[i for i, owner in enumerate(owners) if owner == building] for building in sorted(set(owners))]
    random = np.random.default_rng(0)
    means = [
        values[[row for building in random.integers(len(rows), size=len(rows)) for row in rows[building]]].mean(axis=0)
        for _ in range(DRAWS)
    ]
    low, high = np.quantile(means, (0.025, 0.975), axis=0)
    return np.asarray(low), np.asarray(high)


if __name__ == "__main__":
    main()
