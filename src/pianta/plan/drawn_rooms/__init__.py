"""Rooms that a vector plan draws as closed outlines, or encloses with lines, exactly as they are drawn."""
