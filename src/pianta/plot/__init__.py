"""Pictures of grids, floors, graphs, predictions and explorations, on a matplotlib ax."""
