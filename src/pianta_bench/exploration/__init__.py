"""Sections 8.3 and 8.4: how far robots drive."""
