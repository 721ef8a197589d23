"""Pictures and drawings of plans, read into the map of a floor, its doors and its names (thesis, section 3.3)."""
