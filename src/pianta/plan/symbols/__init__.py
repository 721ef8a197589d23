"""Symbols on a sheet: templates, matching and signs."""
