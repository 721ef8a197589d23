"""Readers of annotated buildings in the formats of several data sets."""
