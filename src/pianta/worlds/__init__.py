"""Synthetic floors (floors), what stands in them (furniture), and the maps that a robot would make of them (scan)."""
