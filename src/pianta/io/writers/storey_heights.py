"""Elevations of storeys, for formats in three dimensions."""

from __future__ import annotations

from pianta.building import Building

STOREY_HEIGHT = 3.0  # metres from floor to floor where elevations are unknown; a usual one, chosen by hand


def list_elevations(building: Building) -> tuple[list[float], list[str]]:
    """The elevation of each storey, metres, and notes; all are STOREY_HEIGHT apart if one is unknown."""
    elevations = [storey.elevation for storey in building if storey.elevation is not None]
    if len(elevations) == len(building):
        return elevations, []
    notes = [f"elevations are unknown, storeys are {STOREY_HEIGHT} m apart"] if len(building) > 1 else []
    return [number * STOREY_HEIGHT for number in range(len(building))], notes
