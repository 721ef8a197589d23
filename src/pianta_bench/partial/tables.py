"""IoU of predicted rooms by run, how far confidence can be trusted, and which rooms are called partial."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from statistics import fmean

from pianta_bench.harness.records import Record, Results
from pianta_bench.harness.tables import Cell, FilledTable, Table
from pianta_bench.partial.maps import SIMULATED
from pianta_bench.partial.measure import GUESSES, MIN_UNSEEN, WALL, EvaluatedRoom

# Share of a true room from which on predictions have to hold; section 8.2 leaves it open, chosen before measuring.
A_THIRD = 1 / 3
CONFIDENCE_BINS = ((0.0, 0.4), (0.4, 0.6), (0.6, 0.75), (0.75, 1.0))
NOTES = (
    "seen: what was seen of a room, as it is; rectangle: the one around that, along the walls nearby.",
    (
        f"A room is truly partial if more than {100 * MIN_UNSEEN:.0f} % of the true room is unknown, but for what is "
        f"thinner than {WALL:g} m. Each room is compared with the true one that it overlaps most."
    ),
    "freiburg79 r: true rooms are those that its last map shows, which is left out itself.",
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
    """IoU by run, for three choices of rooms, then how far confidence can be trusted, and what is called partial."""
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
    for run, of_run in runs.items():
        rooms = [room for room in of_run if is_chosen(room)]
        name = f"{run} ({len(rooms)})"
        for guess in GUESSES:
            for value in [100 * getattr(room, guess) for room in rooms] or [None]:
                yield {"run": name, "metric": guess, "value": value}
        for guess in GUESSES[:2]:
            for value in [100 * (room.predicted - getattr(room, guess)) for room in rooms] or [None]:
                yield {"run": name, "metric": f"over {guess}", "value": value}


def compare_confidence(runs: Mapping[str, Sequence[EvaluatedRoom]]) -> Iterator[Record]:
    """Confidence beside the IoU, by how high the confidence is, %."""
    for run, rooms in runs.items():
        for low, high in CONFIDENCE_BINS:
            # The last bin has its upper end.
            end = high + (high == 1)
            pairs: list[tuple[float | None, float | None]] = [
                (100 * room.confidence, 100 * room.predicted)
                for room in rooms
                if room.confidence is not None and low <= room.confidence < end
            ]
            name = f"{run}, {low:g} to {high:g} ({len(pairs)})"
            for confidence, iou in pairs or [(None, None)]:
                yield {"run": name, "metric": "confidence", "value": confidence}
                yield {"run": name, "metric": "IoU", "value": iou}


def compare_partial(runs: Mapping[str, Sequence[EvaluatedRoom]]) -> Iterator[Record]:
    """Which rooms that are truly partial are called so, and which that are called so are it."""
    for run, rooms in runs.items():
        called: list[bool | None] = [room.truly_partial for room in rooms if room.called_partial]
        true: list[bool | None] = [room.called_partial for room in rooms if room.truly_partial]
        name = f"{run} ({len(true)}, {len(called)})"
        for metric, flags in (("of truly partial, called", true), ("of called, truly partial", called)):
            for flag in flags or [None]:
                yield {"run": name, "metric": metric, "value": flag}
