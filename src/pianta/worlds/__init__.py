"""Synthetic floors (floors), their furniture (furniture), and simulated maps of them (scan, partial_scan)."""
