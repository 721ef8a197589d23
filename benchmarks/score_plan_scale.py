"""Score the scale that is read from plans against true ones, of the rasters in `planfiles`.

Run: OMP_NUM_THREADS=1 python benchmarks/score_plan_scale.py [NAME ...] [--data DIR]

The true scales were measured by eye in the pictures, before the scale was read; how is part of the table. A scale is
right within 15 % of length. `in 80` and `in 95` are the shares of the true scales that the two intervals hold. Plans on
which nothing but the look shows the scale are listed, and counted apart.
"""

from __future__ import annotations

import argparse
import sys
import warnings
from math import exp, log
from pathlib import Path
from statistics import median
from typing import NamedTuple

from pianta.errors import PlanWarning
from pianta.plan.read_plan import read_plan
from pianta.plan.scale.evidence import RIGHT_FACTOR
from pianta.plan.sheets.sheet import PlanScale
from pianta_bench.data.folders import find_data

FOLDER = "planfiles/raster"


class TrueScale(NamedTuple):
    """Metres per pixel, how they were measured, and whether the plan shows them by more than its look."""

    resolution: float
    measured: str
    is_shown: bool = True


TRUE_SCALES = {
    "dfp_45765448.jpg": TrueScale(0.0330, "7.09 x 5.08 m on 214.5 x 154 px, 5.16 x 3.48 m on 156.5 x 106.5 px"),
    "f2b_example1.png": TrueScale(0.0150, "13, 8, 6 and 3 m² on 288 x 200, 125 x 283, 194 x 140 and 102 x 140 px"),
    "f2b_example4.png": TrueScale(0.0246, "10'1\" on 125 px, 11'7\" x 15'7\" on 143 x 193 px"),
    "f2b_example5.png": TrueScale(0.0161, "a cooker of 0.6 m on 37 px, treads of 0.26 m on 16.5 px"),
    "openings_ex1.jpg": TrueScale(0.0100, "a cooker and a worktop of 0.6 m on 60 px"),
    "tf2dfp_example4.png": TrueScale(0.0172, "12'8\" x 11'2\" on 238 x 188 px, 13'1\" x 11'5\" on 233 x 195 px"),
    "r2v_floorplan_1.png": TrueScale(0.0322, "6.7 and 6.5 mats of 1.62 m² on 128 x 82 and 124 x 82 px"),
    "programmer_house.png": TrueScale(0.0312, "10700 mm on 343 px"),
    "savonix_floor.gif": TrueScale(0.048, "eight doors of 0.9 m on 19 px"),
    "raumplanung.png": TrueScale(0.0499, "36 doors of 0.9 m on 18 px"),
    "evac_nf.png": TrueScale(0.116, "the review: the building is 25 m wide, on 216 px"),
    "hulme.jpg": TrueScale(0.106, "halls of 67 feet on 193 px"),
    "wifi_bosch.jpg": TrueScale(0.0262, "doors of 0.8 m on 30.5 px"),
    "evac_a.png": TrueScale(0.0175, "treads of 0.27 m on 15 px", is_shown=False),
    "resplan_sample.png": TrueScale(0.0200, "doors of 0.9 m on 45 px, without names and arcs", is_shown=False),
}


class Score(NamedTuple):
    """Of a plan: its true scale and the scale that was read."""

    true: TrueScale
    scale: PlanScale

    @property
    def factor(self) -> float:
        """By which the scale is wrong."""
        return self.scale.resolution / self.true.resolution

    def is_within(self, interval: tuple[float, float] | None) -> bool:
        """Whether an interval holds the true scale."""
        return interval is not None and interval[0] <= self.true.resolution <= interval[1]


def main() -> None:
    """Print the scale of each plan, then the shares."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", metavar="NAME", choices=[*TRUE_SCALES, []], help="file names of plans")
    parser.add_argument("--data", type=Path, help="folder of the data; $PIANTA_DATA, or ../shared/data, unless given")
    options = parser.parse_args()
    warnings.simplefilter("ignore", PlanWarning)
    scores = {}
    for name in options.names or TRUE_SCALES:
        reading = read_plan(find_data(options.data) / FOLDER / name)
        score = scores[name] = Score(TRUE_SCALES[name], reading.floors[0].scale)
        sys.stdout.write(f"{name} | {score.true.resolution:.3g} | {score.factor:.2f} | {score.scale}\n")
        sys.stdout.flush()
    print_shares("all", list(scores.values()))
    print_shares("shown by more than the look", [score for score in scores.values() if score.true.is_shown])


def print_shares(title: str, scores: list[Score]) -> None:
    """Print one line."""
    if not scores:
        return
    right = sum(abs(log(score.factor)) <= log(RIGHT_FACTOR) for score in scores)
    usual = sum(score.is_within(score.scale.interval) for score in scores)
    wide = sum(score.is_within(score.scale.wide_interval) for score in scores)
    typical = exp(median(abs(log(score.factor)) for score in scores))
    sys.stdout.write(
        f"{title}: {right} of {len(scores)} right, in 80: {usual}, in 95: {wide}, median factor {typical:.2f}\n"
    )


if __name__ == "__main__":
    main()
