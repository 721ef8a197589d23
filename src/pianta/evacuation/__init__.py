"""Evacuation of a floor (thesis, section 8.4): exits, walking distances, rooms with one way out, time with queues."""
