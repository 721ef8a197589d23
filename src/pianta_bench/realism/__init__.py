"""Table 8.2: real and simulated offices."""
