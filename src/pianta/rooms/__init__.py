"""What each room is for: features of a room in its building, models, names (thesis, chapters 4 and 5)."""
