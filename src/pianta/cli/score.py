"""The verb score: how well a floor agrees with the true one."""

from __future__ import annotations

from math import degrees, hypot, remainder, tau
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.table import Table

from pianta.cli.json_output import Json, check_json, write_json
from pianta.cli.terminal import Quiet, make_table, print_result, print_table
from pianta.errors import FloorError, OptionError
from pianta.floor import Floor
from pianta.layout.frames import Motion
from pianta.layout.room_ids import find_frame_motion, move_floor

if TYPE_CHECKING:
    from pianta.evaluation.floor_scores import FloorScores

EXAMPLES = (
    "pianta score building truth.xml",
    "pianta score building corrected --json scores.json",
    "pianta score building corrected/floor.geojson --align",
)
# Smaller motions are errors of maps, not other frames.
MIN_ANGLE = 0.5  # degrees
MIN_SHIFT = 0.2  # metres

FloorFile = Annotated[
    Path, typer.Argument(metavar="OUT", help="A folder of `pianta read`, a floor.geojson or a building XML.")
]
TruthFile = Annotated[
    Path, typer.Argument(metavar="TRUTH", help="The true floor: the same kinds; corrected floors are as corrected.")
]
Align = Annotated[
    bool, typer.Option("--align", help="Move OUT into the frame of TRUTH first, if they are of two frames.")
]


def score_floors(
    out: FloorFile, truth: TruthFile, *, align: Align = False, json_file: Json = None, quiet: Quiet = False
) -> None:
    """Score a floor against the true one: rooms, doors, edges and labels.

    Both are in metres of one map frame. Rooms match one to one with an IoU
    above 0.5; a door is right if its middle is within half a width of a true
    one, and at least within 0.45 m. A layout XML is read on the map of OUT, on
    which it was drawn, if OUT is a folder.

    A_FC is the share of the area found that lies in the true room which
    overlaps each room most, A_BC the share of the true area that lies in the
    found one; coverage has their means over rooms. FC is the share of the
    rooms, BC of the true ones, with the label of the room that overlaps them
    most.
    """
    from pianta.evaluation.floor_scores import score_floor

    quiet = check_json(json_file, quiet=quiet)
    floor, true_floor = _read_floor(out, None), _read_floor(truth, out)
    motion = _find_motion(true_floor, floor, align=align)
    scores = score_floor(move_floor(floor, motion) if align else floor, true_floor)
    write_json({"floor": str(out), "truth": str(truth), **scores.as_json()}, json_file)
    if quiet:
        return
    print_table(tabulate_detections(scores))
    for line in describe_scores(scores):
        print_result(line)
    if motion != Motion():
        moved = "OUT was moved" if align else "the floors have two frames: OUT would have to be moved, give --align,"
        angle = degrees(remainder(motion.angle, tau))
        print_result(f"{moved} by a rotation of {angle:.1f}° and a shift of {describe_shift(motion)}")


def tabulate_detections(scores: FloorScores) -> Table:
    """Table of rooms, doors, pairs and edges: true, found and right ones, and shares in %."""
    rows = {"rooms": scores.rooms, "doors": scores.doors, "pairs": scores.pairs, "edges": scores.edges}
    # A truth without doors, such as the segments of a vacuum, says nothing about them
    rows = rows if scores.doors.true else {"rooms": scores.rooms}
    shares = {"precision": "precision", "recall": "recall", "F1": "f1"}
    return make_table(
        {
            "": [*rows],
            "true": [str(each.true) for each in rows.values()],
            "found": [str(each.detected) for each in rows.values()],
            "right": [str(each.correct) for each in rows.values()],
            **{
                heading: [f"{100 * getattr(each, name):.1f}" for each in rows.values()]
                for heading, name in shares.items()
            },
        },
        left=("",),
    )


def describe_scores(scores: FloorScores) -> list[str]:
    """Coverage and labels, a line each."""
    covered = scores.coverage
    areas = f"A_FC {100 * covered.a_fc:.1f} %, A_BC {100 * covered.a_bc:.1f} %"
    lines = [] if scores.doors.true else ["TRUTH has no doors: doors, pairs and edges are not scored"]
    lines += [
        f"area: {areas}, mean IoU {100 * covered.mean_iou:.1f} %",
        f"coverage of rooms: precision {100 * covered.precision:.1f} %, recall {100 * covered.recall:.1f} %",
    ]
    if scores.labels_forward is not None and scores.labels_backward is not None:
        lines.append(f"labels: FC {100 * scores.labels_forward:.1f} %, BC {100 * scores.labels_backward:.1f} %")
    if scores.building_type is not None:
        lines.append(f"building type: {'right' if scores.building_type else 'wrong'}")
    return lines


def describe_shift(motion: Motion) -> str:
    """The shift of a motion."""
    return f"({motion.shift[0]:.2f}, {motion.shift[1]:.2f}) m"


def _read_floor(path: Path, map_folder: Path | None) -> Floor:
    """The floor of a folder or a file; a layout XML on the map of a folder, if that has one."""
    from pianta.io.buildings._formats import BuildingFormat, detect_building_format
    from pianta.io.buildings.read import read_building
    from pianta.io.buildings.thesis_xml import read_building_xml
    from pianta.io.graphs import FLOOR_FILE
    from pianta.io.maps import read_npz_map
    from pianta.reading.reading import OUTPUTS

    file = path / FLOOR_FILE if path.is_dir() else path
    grid_file = (map_folder or Path()) / OUTPUTS[-1]
    has_map = map_folder is not None and map_folder.is_dir() and grid_file.exists()
    if has_map and file.suffix.lower() == ".xml" and detect_building_format(file) == BuildingFormat.LAYOUT:
        return read_building_xml(file, grid=read_npz_map(grid_file))
    return read_building(file)


def _find_motion(truth: Floor, floor: Floor, *, align: bool) -> Motion:
    """The motion from the frame of a floor to that of the true one; none if they are in one frame.

    Raises OptionError if the floors must be aligned and are of two buildings.
    """
    motion = Motion()
    try:
        motion = find_frame_motion(truth, floor)
    except FloorError as error:
        if align:
            raise OptionError(f"--align finds no motion between the floors: {error}") from error
    is_small = abs(degrees(remainder(motion.angle, tau))) < MIN_ANGLE and hypot(*motion.shift) < MIN_SHIFT
    return Motion() if is_small else motion
