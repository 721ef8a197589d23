"""Algorithm 1 of the thesis (section 3.1)."""
