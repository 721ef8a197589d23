"""What kind of building a floor belongs to (thesis, section 6.2)."""
