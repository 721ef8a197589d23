"""What lies beyond the explored part of a floor (thesis, section 8.3)."""
