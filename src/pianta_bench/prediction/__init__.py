"""Section 8.3: the unexplored part of a floor."""
