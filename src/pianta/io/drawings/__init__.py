"""Readers of vector plans: DXF, SVG, PDF and IFC."""
