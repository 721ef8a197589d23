"""Draw the picture of docs/methods/evacuation.md: python docs/draw_evacuation.py."""

from __future__ import annotations

from pathlib import Path

import pianta
from pianta.plot.evacuation import draw_evacuation
from pianta.plot.figure import save_figure

IMAGES = Path(__file__).parent / "images"
SEED = 5
EXITS = (6, 22)


def main() -> None:
    """Evacuate a made floor around a courtyard, with two rooms that lead out."""
    floor, _ = pianta.make_world("ring", seed=SEED)
    evacuation = pianta.evacuate(floor, exits=EXITS, density=0.3)
    save_figure(draw_evacuation(evacuation), IMAGES / "evacuation.png")


if __name__ == "__main__":
    main()
