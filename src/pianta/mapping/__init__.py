"""Semantic mapping on-line: a building that is understood while its map grows."""
