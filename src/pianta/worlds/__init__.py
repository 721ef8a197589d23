"""Synthetic floors, their furniture, doors and glass, and simulated maps of them.

Floors: plain shapes (floors), homes, workplaces; layouts and wall_axes build them. In them: furniture, dense_furniture
of pieces, door_leaves, glass. Maps: scan, partial_scan.
"""
