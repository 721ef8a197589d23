"""Realism of an environment: whether it is built like real ones (thesis, section 8.1)."""
