"""Plans of what lies beyond the explored part of a floor: sampled rooms, laid out behind its open ends."""
