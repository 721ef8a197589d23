"""Section 8.2: rooms that were seen in part."""
