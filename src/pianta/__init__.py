"""pianta reads buildings: rooms, doors and the topological graph from a robot's 2-D map."""

__version__ = "0.1.0"
