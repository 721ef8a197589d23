"""Poses in rooms and at doors: YAML, as RViz's panel of Nav2 loads waypoints, or JSON."""

from __future__ import annotations

import json
from math import cos, sin
from pathlib import Path
from typing import Any

import yaml

from pianta.building import Building
from pianta.errors import FloorError
from pianta.io.writers._formats import WriteOptions
from pianta.io.writers._only_storey import get_only_storey
from pianta.navigation.waypoints import Pose, find_approaches, find_room_poses

DIGITS = 4  # of metres and radians, after the point


def write_waypoints(building: Building, target: Path, options: WriteOptions) -> list[str]:
    """The pose of each room in `waypoints`, by its id, and those of each door in `doors`; JSON if the file is .json."""
    floor, grid = get_only_storey(building, "waypoints")
    poses = find_room_poses(floor, grid, robot_radius=options.robot_radius)
    if not poses:
        raise FloorError(f"a robot of {options.robot_radius} m radius fits nowhere, give a smaller robot_radius")
    waypoints = {}
    for room_id, pose in poses.items():
        texts = {"name": floor[room_id].name, "label": floor[room_id].label}
        present = {key: text for key, text in texts.items() if text is not None}
        waypoints[f"room{room_id}"] = {"room": room_id, **present, **_describe_pose(pose)}
    approaches = find_approaches(floor, grid, robot_radius=options.robot_radius)
    doors = [{"door": each.door, "room": each.room, **_describe_pose(each.pose)} for each in approaches]
    content = {"frame": "map", "waypoints": waypoints, "doors": doors}
    text = (
        json.dumps(content, indent=1, ensure_ascii=False, allow_nan=False) + "\n"
        if target.suffix.lower() == ".json"
        else yaml.safe_dump(content, sort_keys=False, default_flow_style=None, allow_unicode=True)
    )
    target.write_text(text, encoding="utf-8")
    outside = [str(room.id) for room in floor if room.id not in poses]
    shut = sorted({*range(len(floor.doors))} - {each.door for each in approaches})
    notes = [f"the robot fits nowhere in rooms {', '.join(outside)}"] if outside else []
    return notes + ([f"the robot does not fit before doors {', '.join(map(str, shut))}"] if shut else [])


def _describe_pose(pose: Pose) -> dict[str, Any]:
    """x, y and yaw, and the same as the panel has it: x, y, z, and the quaternion w, x, y, z."""
    x, y, yaw, w, z = (
        round(value, DIGITS) for value in (pose.x, pose.y, pose.yaw, cos(pose.yaw / 2), sin(pose.yaw / 2))
    )
    return {"x": x, "y": y, "yaw": yaw, "pose": [x, y, 0.0], "orientation": [w, 0.0, 0.0, z]}
