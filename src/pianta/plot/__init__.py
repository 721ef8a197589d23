"""Pictures of grids, floors, graphs, predictions, explorations and evacuations, on a matplotlib ax.

Each plot_ function has an option `ax`, draws in metres if positions are known, and returns the ax; none shows it.
"""

from importlib import import_module

_MODULES = {
    "plot_area": "exploration",
    "plot_cleaning": "navigation",
    "plot_doors": "floor_parts",
    "plot_evacuation": "evacuation",
    "plot_exploration": "exploration",
    "plot_explanation": "explanation",
    "plot_explored": "prediction",
    "plot_floor": "floor",
    "plot_furniture": "floor_parts",
    "plot_graph": "room_marks",
    "plot_grid": "grid",
    "plot_model_floor_plan": "model_floor_plan",
    "plot_room_graph": "graphs",
    "plot_rooms": "floor_parts",
    "plot_route_graph": "navigation",
    "plot_skeleton": "prediction",
    "plot_walls": "floor_parts",
}
__all__ = list(_MODULES)


def __getattr__(name: str) -> object:
    if name not in _MODULES:
        raise AttributeError(f"module 'pianta.plot' has no attribute {name!r}")
    return getattr(import_module(f"pianta.plot.{_MODULES[name]}"), name)


def __dir__() -> list[str]:
    return sorted(__all__)
