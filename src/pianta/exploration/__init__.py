"""Simulated robots that explore a building, and the policies that choose their targets (thesis, section 8.3)."""
