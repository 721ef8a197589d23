"""IoU of predicted rooms by run, calibration of the confidence, and recall of partial rooms."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from statistics import fmean

from pianta_bench.harness.records import Record, Results
from pianta_bench.harness.tables import Cell, FilledTable, Table
from pianta_bench.partial.guesses import GUESSES, PREDICTED
from pianta_bench.partial.maps import SIMULATED
from pianta_bench.partial.measure import MIN_UNSEEN, WALL, EvaluatedRoom

# Least explored share of a true room for the main table; section 8.2 leaves it open, chosen before measuring.
A_THIRD = 1 / 3
CONFIDENCE_BINS = ((0.0, 0.4), (0.4, 0.6), (0.6, 0.75), (0.75, 1.0))
NOTES = (
    (
        "seen: the explored part of a room; rectangle: the one around it, along the walls nearby; faces: all faces of "
        "Algorithm 1 in which it has a part (section 8.2). All of them, and the true rooms, end in the middle of walls."
    ),
    (
        f"A room is truly partial if more than {100 * MIN_UNSEEN:.0f} % of the true room is unknown; strips "
        f"thinner than {WALL:g} m do not count. Each room is compared with the true one that it overlaps most."
    ),
    "freiburg79 r: the true rooms are those of its last map, which is not evaluated.",
)
CHOICES: Mapping[str, Callable[[EvaluatedRoom], bool]] = {
    "at least a third seen": lambda room: room.called_partial and room.seen_share >= A_THIRD,
    "at least a third seen, truly partial": lambda room: room.truly_partial and room.seen_share >= A_THIRD,
    "all called partial": lambda room: room.called_partial,
}

IOU = Table(
    title="IoU with the true room, {method}, rooms: {choice}",
    rows=("run",),
    columns=("metric",),
    unit="%",
    notes=NOTES,
)
CONFIDENCE = Table(
    title="Confidence, the expected IoU, and the IoU",
    rows=("run",),
    columns=("metric",),
    unit="%",
)
RECALL = Table(
    title="Rooms that are called partial",
    rows=("run",),
    columns=("metric",),
    summarise=lambda flags: Cell(100 * fmean(flags) if flags != [None] else None, count=len(flags) - (flags == [None])),
    unit="%",
)


def tabulate(results: Results) -> list[FilledTable]:
    """IoU by run, for three choices of rooms; then confidence beside IoU, and which rooms are called partial."""
    runs: Mapping[str, Sequence[EvaluatedRoom]] = results.objects["rooms"]
    real = [room for run, rooms in runs.items() if run != SIMULATED for room in rooms]
    with_all = {**runs, **({"all real maps": real} if real else {})}
    method = results.options["method"]
    return [
        *(
            IOU.fill(compare_guesses(with_all, is_chosen), method=method, choice=choice)
            for choice, is_chosen in CHOICES.items()
        ),
        CONFIDENCE.fill(compare_confidence({"real": real, SIMULATED: runs.get(SIMULATED, ())})),
        RECALL.fill(compare_partial(with_all)),
    ]


def compare_guesses(
    runs: Mapping[str, Sequence[EvaluatedRoom]], is_chosen: Callable[[EvaluatedRoom], bool]
) -> Iterator[Record]:
    """IoU of each guess with the true room, and by how much the prediction is above the others, %."""
    for run, evaluated in runs.items():
        rooms = [room for room in evaluated if is_chosen(room)]
        name = f"{run} ({len(rooms)})"
        for guess in GUESSES:
            ious: list[float | None] = [100 * room.ious[guess] for room in rooms]
            for value in ious or [None]:
                yield {"run": name, "metric": guess, "value": value}
        for guess in GUESSES[:-1]:
            gains: list[float | None] = [100 * (room.ious[PREDICTED] - room.ious[guess]) for room in rooms]
            for value in gains or [None]:
                yield {"run": name, "metric": f"over {guess}", "value": value}


def compare_confidence(runs: Mapping[str, Sequence[EvaluatedRoom]]) -> Iterator[Record]:
    """Confidence beside the IoU, by how high the confidence is, %."""
    for run, rooms in runs.items():
        for low, high in CONFIDENCE_BINS:
            # The last bin has its upper end.
            end = high + (high == 1)
            pairs: list[tuple[float | None, float | None]] = [
                (100 * room.confidence, 100 * room.ious[PREDICTED])
                for room in rooms
                if room.confidence is not None and low <= room.confidence < end
            ]
            name = f"{run}, {low:g} to {high:g} ({len(pairs)})"
            for confidence, iou in pairs or [(None, None)]:
                yield {"run": name, "metric": "confidence", "value": confidence}
                yield {"run": name, "metric": "IoU", "value": iou}


def compare_partial(runs: Mapping[str, Sequence[EvaluatedRoom]]) -> Iterator[Record]:
    """Recall and precision of partial rooms: by truly partial room, and by room that is called partial."""
    for run, rooms in runs.items():
        called: list[bool | None] = [room.truly_partial for room in rooms if room.called_partial]
        true: list[bool | None] = [room.called_partial for room in rooms if room.truly_partial]
        name = f"{run} ({len(true)}, {len(called)})"
        for metric, flags in (("of truly partial, called", true), ("of called, truly partial", called)):
            for flag in flags or [None]:
                yield {"run": name, "metric": metric, "value": flag}
