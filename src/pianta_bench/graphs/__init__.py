"""Table 5.1: buildings as graphs."""
