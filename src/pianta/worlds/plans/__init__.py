"""Drawn plans of synthetic floors, for tests and training."""
