"""Whether a floor is built like real ones: the function behind the verb `pianta realism`."""

from __future__ import annotations

from collections.abc import Sequence

from pianta._arguments import check_argument
from pianta.building_types.model_file import read_default_building_type_model
from pianta.floor import Floor
from pianta.labels import LabelSet
from pianta.realism.model import Realism, RealismModel, reference_from_types, train_realism
from pianta.rooms.completion import fill_missing_labels


def assess_realism(floor: Floor, reference: RealismModel | Sequence[Floor] | None = None) -> Realism:
    """Compare a floor with real ones: how typical it is, and what is unusual in it (thesis, section 8.1).

    Parameters
    ----------
    floor
        The floor; rooms without a manual label are labelled by pianta.
    reference
        Real floors of three buildings or more, or a model of them; None for those that come with pianta.

    Returns
    -------
    Realism
        `score` from 0 to 1: the share of the reference floors that are less like the others than this one is; and
        `reasons`, in words.

    Raises
    ------
    ModelError
        The reference has too few buildings.
    LabelError
        The floor has no rooms.

    References
    ----------
    M. Luperto, PhD thesis, section 8.1.

    Examples
    --------
    >>> import pianta
    >>> from shapely import box
    >>> worlds = [pianta.make_world(name, seed=seed)[0] for name in ("corridor", "ring", "hall") for seed in range(2)]
    >>> rooms_without_doors = pianta.Floor((pianta.Room(1, box(0, 0, 4, 3)), pianta.Room(2, box(4, 0, 8, 3))))
    >>> pianta.assess_realism(rooms_without_doors, worlds).verdict
    'less typical than any of the 6 reference floors'
    """
    check_argument(floor, Floor, "floor", "a Floor of read or reconstruct")
    check_argument(reference, (RealismModel, list, tuple, type(None)), "reference", "floors, or a model of them")
    if reference is None:
        model = reference_from_types(read_default_building_type_model())
    elif isinstance(reference, RealismModel):
        model = reference
    else:
        real = [fill_missing_labels(each, LabelSet.R_C).floor for each in reference]
        model = train_realism(real, label_set=LabelSet.R_C)
    return model.assess(fill_missing_labels(floor, model.label_set).floor)
