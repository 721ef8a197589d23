"""Masks for Nav2's keep-out and speed filters: a map.yaml and its image in raw mode, which keeps each value 0 … 100."""

from __future__ import annotations

from pathlib import Path

from pianta.building import Building
from pianta.errors import OptionError
from pianta.io.ros_maps import save_ros_map
from pianta.io.writers._formats import WriteOptions
from pianta.io.writers._only_storey import get_only_storey
from pianta.navigation.choose_rooms import choose_rooms
from pianta.navigation.masks import FORBIDDEN, make_mask

MIN_SPEED = 1  # per cent; 0 is no limit for the speed filter


def write_keepout_mask(building: Building, target: Path, options: WriteOptions) -> list[str]:
    """A folder with keepout.yaml and keepout.png: 100 in the chosen rooms, 0 elsewhere."""
    if not options.rooms:
        raise OptionError("a keep-out mask of all rooms would keep the robot out of everything, give rooms")
    return _write_mask(building, target / "keepout.yaml", options, FORBIDDEN)


def write_speed_mask(building: Building, target: Path, options: WriteOptions) -> list[str]:
    """A folder with speed.yaml and speed.png: the per cent in the chosen rooms, 0, which is no limit, elsewhere."""
    value = round(options.speed)
    if value != options.speed or value < MIN_SPEED:
        raise OptionError(f"speed is {options.speed}, a mask holds whole per cent from {MIN_SPEED} to 100, give one")
    return _write_mask(building, target / "speed.yaml", options, value)


def _write_mask(building: Building, path: Path, options: WriteOptions, value: int) -> list[str]:
    floor, grid = get_only_storey(building, f"nav2-{path.stem}")
    rooms = choose_rooms(floor, options.rooms) if options.rooms else {room.id for room in floor}
    mask = make_mask(floor, grid, rooms, value)
    save_ros_map(mask, path, mode="raw")
    empty = sorted(rooms - {*floor.label_image(mask).ravel().tolist()})
    ids = ", ".join(map(str, sorted(rooms)))
    notes = [f"{'forbidden' if value == FORBIDDEN else f'{value} %'}: {'rooms' if len(rooms) > 1 else 'room'} {ids}"]
    notes += (
        ["the map has a yaw, which Nav2's filters refuse: the mask has a grid of its own"] if grid.origin[2] else []
    )
    return notes + ([f"no cell of the mask is in rooms {', '.join(map(str, empty))}"] if empty else [])
