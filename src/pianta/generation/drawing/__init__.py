"""From the graph of a building to its floor: rooms with outlines, walls and doors."""
