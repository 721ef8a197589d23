"""pianta reads buildings: rooms, what each is for, doors and the topological graph from a robot's map or a plan.

The names in `__all__` are public. Each is imported when it is first used, so that `import pianta` takes no time.
All other modules are internal, unless a page of the documentation shows them, and may change without notice.
"""

from importlib import import_module
from typing import TYPE_CHECKING

__version__ = "0.2.0"

if TYPE_CHECKING:
    from pianta import errors, plot
    from pianta.batch.collect import collect_batch
    from pianta.batch.generate_batch import generate_batch
    from pianta.batch.predict_batch import predict_batch
    from pianta.batch.read_batch import read_batch
    from pianta.batch.run_batch import BatchItem
    from pianta.building import Building, Link, Storey
    from pianta.building_types.classify import classify_building
    from pianta.building_types.model import train_building_types
    from pianta.errors import PiantaError
    from pianta.evacuation.evacuate import evacuate
    from pianta.evaluation.floor_scores import score_floor
    from pianta.exploration.explore import explore
    from pianta.floor import Door, Floor, Furniture, Room
    from pianta.generation.drawing.draw import DrawnPlan, draw_plan
    from pianta.generation.generate import generate
    from pianta.generation.train import train_type
    from pianta.generation.world import make_world
    from pianta.gridmap import GridMap
    from pianta.io.buildings.read import read_building
    from pianta.io.floors import read_floor
    from pianta.io.maps import read_map
    from pianta.io.writers.convert import convert
    from pianta.io.writers.nav2_route import read_route_graph
    from pianta.labels import LabelSchema
    from pianta.layout.clean_map import clean_map
    from pianta.layout.explanation import explain
    from pianta.layout.parameters import StructureParameters, ThesisParameters
    from pianta.layout.reconstruct import METHODS, reconstruct
    from pianta.mapping.mapper import Mapper, MapUpdate
    from pianta.model_files import load_model
    from pianta.navigation.cleaning import plan_cleaning
    from pianta.navigation.route_graph import build_route_graph
    from pianta.patterns.model_floor_plan import ModelFloorPlan, find_model_floor_plan
    from pianta.plan.read_plan import read_plan
    from pianta.prediction.continuation.continuations import Continuation, Continuations, draw_continuations
    from pianta.prediction.continuation.shares import ShareGrid
    from pianta.prediction.prediction import Prediction, predict
    from pianta.reading.read import Failure, read, read_all
    from pianta.reading.reading import Reading
    from pianta.reading.series import read_series
    from pianta.realism.assess import assess_realism
    from pianta.rooms.label import label_rooms
    from pianta.rooms.training import train_rooms

__all__ = [
    "METHODS",
    "BatchItem",
    "Building",
    "Continuation",
    "Continuations",
    "Door",
    "DrawnPlan",
    "Failure",
    "Floor",
    "Furniture",
    "GridMap",
    "LabelSchema",
    "Link",
    "MapUpdate",
    "Mapper",
    "ModelFloorPlan",
    "PiantaError",
    "Prediction",
    "Reading",
    "Room",
    "ShareGrid",
    "Storey",
    "StructureParameters",
    "ThesisParameters",
    "assess_realism",
    "build_route_graph",
    "classify_building",
    "clean_map",
    "collect_batch",
    "convert",
    "draw_continuations",
    "draw_plan",
    "errors",
    "evacuate",
    "explain",
    "explore",
    "find_model_floor_plan",
    "generate",
    "generate_batch",
    "label_rooms",
    "load_model",
    "make_world",
    "plan_cleaning",
    "plot",
    "predict",
    "predict_batch",
    "read",
    "read_all",
    "read_batch",
    "read_building",
    "read_floor",
    "read_map",
    "read_plan",
    "read_route_graph",
    "read_series",
    "reconstruct",
    "score_floor",
    "train_building_types",
    "train_rooms",
    "train_type",
]

_MODULES = {
    "METHODS": "layout.reconstruct",
    "BatchItem": "batch.run_batch",
    "Building": "building",
    "Continuation": "prediction.continuation.continuations",
    "Continuations": "prediction.continuation.continuations",
    "Door": "floor",
    "DrawnPlan": "generation.drawing.draw",
    "Failure": "reading.read",
    "Floor": "floor",
    "Furniture": "floor",
    "GridMap": "gridmap",
    "LabelSchema": "labels",
    "MapUpdate": "mapping.mapper",
    "Mapper": "mapping.mapper",
    "Link": "building",
    "ModelFloorPlan": "patterns.model_floor_plan",
    "PiantaError": "errors",
    "Prediction": "prediction.prediction",
    "Reading": "reading.reading",
    "Room": "floor",
    "ShareGrid": "prediction.continuation.shares",
    "Storey": "building",
    "StructureParameters": "layout.parameters",
    "ThesisParameters": "layout.parameters",
    "build_route_graph": "navigation.route_graph",
    "classify_building": "building_types.classify",
    "clean_map": "layout.clean_map",
    "collect_batch": "batch.collect",
    "convert": "io.writers.convert",
    "draw_continuations": "prediction.continuation.continuations",
    "draw_plan": "generation.drawing.draw",
    "errors": "errors",
    "evacuate": "evacuation.evacuate",
    "explain": "layout.explanation",
    "explore": "exploration.explore",
    "find_model_floor_plan": "patterns.model_floor_plan",
    "generate": "generation.generate",
    "generate_batch": "batch.generate_batch",
    "assess_realism": "realism.assess",
    "label_rooms": "rooms.label",
    "load_model": "model_files",
    "make_world": "generation.world",
    "plan_cleaning": "navigation.cleaning",
    "plot": "plot",
    "predict": "prediction.prediction",
    "predict_batch": "batch.predict_batch",
    "read": "reading.read",
    "read_all": "reading.read",
    "read_batch": "batch.read_batch",
    "read_building": "io.buildings.read",
    "read_floor": "io.floors",
    "read_map": "io.maps",
    "read_plan": "plan.read_plan",
    "read_route_graph": "io.writers.nav2_route",
    "read_series": "reading.series",
    "reconstruct": "layout.reconstruct",
    "score_floor": "evaluation.floor_scores",
    "train_building_types": "building_types.model",
    "train_rooms": "rooms.training",
    "train_type": "generation.train",
}


def __getattr__(name: str) -> object:
    if name not in _MODULES:
        raise AttributeError(f"module 'pianta' has no attribute {name!r}")
    module = import_module(f"pianta.{_MODULES[name]}")
    value = module if name in {"errors", "plot"} else getattr(module, name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted([*__all__, "__version__"])
