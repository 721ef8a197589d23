"""Doors of a plan: swings of leaves, and lines from jamb to jamb."""
