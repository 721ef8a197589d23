"""A robot's map or a plan into a building: all stages that `pianta read` takes, as one function."""
