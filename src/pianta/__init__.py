"""pianta reads buildings: rooms, what each is for, doors and the topological graph from a robot's 2-D map."""

__version__ = "0.1.0"
