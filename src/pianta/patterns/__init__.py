"""Model floor plan: groups of rooms that a building repeats, on a floor or from storey to storey (section 4.2.2)."""
