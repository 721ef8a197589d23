"""Where the sets of maps and buildings are, and how each is read."""
