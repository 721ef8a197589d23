"""A simulated robot that explores a building, and the policies that tell it where to go (thesis, section 8.3)."""
