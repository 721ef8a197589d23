"""Buildings as graphs: features of rooms, and metrics of graphs (thesis, chapter 5)."""
