"""The perceptions of robots by name."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pianta.errors import OptionError
from pianta.exploration.perception import Perception, PerfectPerception
from pianta.exploration.world import World

if TYPE_CHECKING:
    from pianta.mapping.mapper import Mapper

PERFECT, MAP = "perfect", "map"
# The names for `pianta explore --perception`.
PERCEPTIONS = (PERFECT, MAP)


def check_perception(name: str) -> None:
    """Raise OptionError for a name that is not in PERCEPTIONS."""
    if name not in PERCEPTIONS:
        raise OptionError(f"perception is {name!r}, give {' or '.join(PERCEPTIONS)}")


def make_perception(perception: str | Mapper, world: World) -> Perception:
    """The perception of a name in PERCEPTIONS, or that of a mapper.

    Raises OptionError for any other name.
    """
    if isinstance(perception, str):
        check_perception(perception)
    if perception == PERFECT:
        return PerfectPerception(world)
    # Imported late, because its imports are slow
    from pianta.exploration.map_perception import MapPerception
    from pianta.mapping.mapper import Mapper

    return MapPerception(Mapper() if isinstance(perception, str) else perception, world.floor)
