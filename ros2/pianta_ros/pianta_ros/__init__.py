"""Rooms of the map of a robot."""
