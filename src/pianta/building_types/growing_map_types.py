"""The building type of a map that is still growing, by two models: of whole floors, and of parts of floors.

To the forest of whole floors a part of a school looks like no type that it knows: rooms that were seen through a door
are small, and corridors have few doors. The other model was trained on readings of maps of which a robot has seen a
part. The more rooms are complete, the less it counts.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np

from pianta.building_types.map_type_file import read_default_map_type_model
from pianta.building_types.map_types import OTHER, MapTypeModel, MapTypePrediction, describe_map
from pianta.building_types.partial_map_type_file import read_default_partial_map_type_model
from pianta.building_types.partial_map_types import PartialMapTypeModel
from pianta.errors import LabelError
from pianta.floor import Floor
from pianta.rooms.features import RoomContext, describe_rooms

# The model of parts has the weight 1 - (share of complete rooms) ** this. Chosen among six functions by the logarithmic
# loss of parts of floors whose building was left out.
COMPLETE_EXPONENT = 3


@dataclass(frozen=True, eq=False)
class GrowingMapTypeModel:
    """A model of the building types of maps that may show only a part of a floor.

    floor_model: of whole floors. partial_model: of parts of floors, with the same classes.
    Raises LabelError if the classes differ.
    """

    floor_model: MapTypeModel
    partial_model: PartialMapTypeModel

    def __post_init__(self) -> None:
        if self.floor_model.classes != self.partial_model.classes:
            raise LabelError(
                f"the model of whole floors knows {', '.join(self.floor_model.classes)}, that of parts "
                f"{', '.join(self.partial_model.classes)}; train both on the same types"
            )

    def predict(self, floor: Floor, *, context: RoomContext | None = None) -> MapTypePrediction:
        """The type of a floor, by its rooms and doors alone; raises LabelError for a floor without rooms.

        It is the weighted geometric mean of both predictions. context: of its rooms, by `describe_rooms`; None to
        compute it.
        """
        if not floor.rooms:
            raise LabelError("the floor has no rooms, so its building type cannot be predicted")
        features = describe_map(context or describe_rooms(floor))
        complete = float(np.mean([not room.partial for room in floor]))
        weight = 1 - complete**COMPLETE_EXPONENT
        by_floors, by_parts = (model.predict_description(features) for model in (self.floor_model, self.partial_model))
        return mix_predictions(by_floors, by_parts, weight)

    @property
    def buildings(self) -> frozenset[str]:
        """All buildings that one of both models was trained on."""
        return frozenset((*self.floor_model.examples.buildings, *self.partial_model.examples.buildings))

    def leave_out(self, building: str) -> GrowingMapTypeModel:
        """The model of all other buildings, trained anew; raises LabelError if neither model knows the building."""
        if building not in self.buildings:
            raise LabelError(f"the model was not trained on {building!r}, so it cannot be left out; check the name")
        return GrowingMapTypeModel(self.floor_model.leave_out(building), self.partial_model.leave_out(building))


def mix_predictions(first: MapTypePrediction, second: MapTypePrediction, weight: float) -> MapTypePrediction:
    """The geometric mean of two predictions over the same types; weight: of the second one, 0 … 1."""
    one, two = ({**each.probabilities, OTHER: each.neither} for each in (first, second))
    mixed = {name: one[name] ** (1 - weight) * two[name] ** weight for name in one}
    total = sum(mixed.values())
    neither = mixed.pop(OTHER) / total
    return MapTypePrediction({name: value / total for name, value in mixed.items()}, neither)


@cache
def read_default_growing_map_type_model() -> GrowingMapTypeModel:
    """The models that come with pianta."""
    return GrowingMapTypeModel(read_default_map_type_model(), read_default_partial_map_type_model())
