"""Partial rooms, predicted as a whole (thesis, section 8.2)."""
