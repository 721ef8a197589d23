"""Time the simulator of exploration: scans a second, and seconds for a run (docs/methods/exploration.md).

Run: OMP_NUM_THREADS=1 python benchmarks/time_simulator.py [--building FILE]. Needs numba (pianta[sim]); about half a
minute. Exit code 1 where numba does not make 2,000 scans of 360 beams a second.

Processor time on one core. A scan is one of the lidar with its noise; mapped, it is also taken into the occupancy grid.
"""

from __future__ import annotations

import argparse
import sys
import time
import warnings
from collections.abc import Callable

import numpy as np

from pianta.exploration import beams
from pianta.exploration.explore import explore
from pianta.exploration.lidar import Lidar, Pose, scan
from pianta.exploration.occupancy import OccupancyGrid
from pianta.exploration.policies import POLICIES, make_policy
from pianta.exploration.starts import find_starts
from pianta.exploration.world import World, build_world
from pianta.io.buildings.read import read_building
from pianta.worlds.floors import make_floor

# Scans a second that numba must reach.
BAR = 2000
# Scans that are timed, with numba and without.
SCANS = {True: 2000, False: 40}


def main() -> None:
    """Print a row for each reach of the lidar, with numba and without, and one for each policy."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--building", help="file of a building to explore [a synthetic ring]")
    building = parser.parse_args().building
    warnings.simplefilter("ignore")
    world = build_world(read_building(building) if building else make_floor("ring", seed=0))
    missed = False
    print(f"{'360 beams':24}{'scans/s':>10}{'mapped/s':>10}")
    for numba in (True, False):
        beams.has_numba = lambda numba=numba: numba  # type: ignore[assignment]
        for reach in (8.0, 20.0):
            alone, mapped = count_scans(world, Lidar(reach=reach), SCANS[numba])
            missed |= numba and alone < BAR
            print(f"{reach:4.0f} m, {'numba' if numba else 'Python':16}{alone:10.0f}{mapped:10.0f}", flush=True)
    beams.has_numba = lambda: True  # type: ignore[assignment]
    explore(world, make_policy("gain"), max_distance=5)
    print(f"{'policy':24}{'s':>10}{'metres':>10}{'scans':>8}")
    for policy in POLICIES:
        started = time.process_time()
        run = explore(world, make_policy(policy))
        spent = time.process_time() - started
        print(f"{policy:24}{spent:10.2f}{run.distance[-1]:10.0f}{len(run.area):8}", flush=True)
    sys.exit(missed)


def count_scans(world: World, lidar: Lidar, scans: int) -> tuple[float, float]:
    """Scans a second of processor time, from free places all over the world: alone, and mapped."""
    rng = np.random.default_rng(0)
    cells = np.argwhere(world.free)
    points = [world.point((row, col)) for row, col in cells[rng.integers(len(cells), size=scans)].tolist()]
    poses = [Pose(*point) for point in [*find_starts(world)[:1], *points]]
    grid = OccupancyGrid(world)
    ranges = [scan(world, pose, lidar, rng) for pose in poses]
    grid.add_scan(poses[0], lidar, ranges[0])
    alone = measure(lambda: [scan(world, pose, lidar, rng) for pose in poses])
    adding = measure(lambda: [grid.add_scan(pose, lidar, values) for pose, values in zip(poses, ranges, strict=True)])
    return len(poses) / alone, len(poses) / (alone + adding)


def measure(run: Callable[[], object]) -> float:
    """Processor time of one run, s."""
    started = time.process_time()
    run()
    return time.process_time() - started


if __name__ == "__main__":
    main()
