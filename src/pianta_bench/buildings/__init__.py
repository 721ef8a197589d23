"""Table 6.1: rooms and whole buildings."""
