"""GridMap to Floor: walls, lines, faces, rooms, doors (thesis, chapter 3)."""
