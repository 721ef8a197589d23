"""Plans to clean a floor: JSON with the rooms in their order and the paths of a robot in them."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from pianta._types import Floats
from pianta.building import Building
from pianta.floor import Floor
from pianta.io.writers._formats import WriteOptions
from pianta.io.writers._only_storey import get_only_storey
from pianta.navigation.cleaning import CleaningPlan, Coverage, plan_cleaning

DIGITS = 3  # of metres, after the point


def write_cleaning(building: Building, target: Path, options: WriteOptions) -> list[str]:
    """The plan of a floor; notes say how much it sweeps, and which rooms are left out."""
    floor, grid = get_only_storey(building, "cleaning")
    plan = plan_cleaning(floor, grid, robot_radius=options.robot_radius)
    content = {
        "frame": "map",
        "robot_radius": options.robot_radius,
        "coverage": round(plan.swept.coverage, DIGITS),
        "overlap": round(plan.swept.overlap, DIGITS),
        "rooms": [_describe_room(floor, plan, room) for room in plan.rooms],
    }
    target.write_text(json.dumps(content, ensure_ascii=False, allow_nan=False), encoding="utf-8")
    left_out = ", ".join(map(str, plan.left_out))
    return [_describe_coverage(plan.swept)] + ([f"the robot does not reach rooms {left_out}"] if left_out else [])


def _describe_room(floor: Floor, plan: CleaningPlan, room_id: int) -> dict[str, Any]:
    room = floor[room_id]
    texts = {key: text for key, text in (("name", room.title), ("label", room.label)) if text is not None}
    lines = {"way": _list_points(plan.ways[room_id]), "path": _list_points(plan.paths[room_id])}
    return {"room": room_id, **texts, **lines}


def _list_points(path: Floats) -> list[list[float]]:
    points: list[list[float]] = np.round(path, DIGITS).tolist()
    return points


def _describe_coverage(coverage: Coverage) -> str:
    return f"{coverage.coverage:.1%} of the reachable floor, {coverage.overlap:.0%} overlap, {coverage.length:.0f} m"
