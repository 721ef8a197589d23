"""Scores of reconstructed layouts and segmentations against the truth (thesis, section 3.2)."""
