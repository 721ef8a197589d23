"""The numbers of storeys, as maps of the earth have them: 0 at the ground."""

from __future__ import annotations

from collections.abc import Mapping

from pianta.building import Building

# A storey is below the ground if its floor is as much lower than the ground floor, metres; chosen by hand.
BELOW = -0.5


def number_storeys(building: Building) -> Mapping[str, int]:
    """The number of each storey by its name: 0 for the lowest that is not below height 0, or for the first."""
    heights = [storey.elevation for storey in building]
    ground = next((index for index, height in enumerate(heights) if height is not None and height >= BELOW), 0)
    return {storey.name: index - ground for index, storey in enumerate(building)}
