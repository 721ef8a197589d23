"""Table 3.1b and more: rooms on real and simulated maps."""
