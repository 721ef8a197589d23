"""The ways in which rooms are found, by name."""

METHODS = ("thesis",)
