"""What rooms are for: features of a room in its building, and classifiers of places (thesis, chapter 4)."""
