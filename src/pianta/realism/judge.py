"""Whether a floor is built like real ones: the function behind the verb `pianta realism`."""

from __future__ import annotations

from collections.abc import Sequence

from pianta._arguments import check_argument
from pianta.building_types.model_file import read_default_building_model
from pianta.floor import Floor
from pianta.labels import LabelSet
from pianta.realism.model import Realism, RealismModel, learn_realism, realism_of_types
from pianta.rooms.completion import complete_labels


def judge_realism(floor: Floor, reference: RealismModel | Sequence[Floor] | None = None) -> Realism:
    """Compare a floor with real ones: how typical it is, and what is unusual in it (thesis, section 8.1).

    Parameters
    ----------
    floor
        The floor; rooms that nobody has labelled are labelled by pianta.
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
    >>> kinds = ("corridor", "ring", "hall")
    >>> made = [pianta.make_world(kind, seed=seed)[0] for kind in kinds for seed in range(2)]
    >>> rooms_without_doors = pianta.Floor((pianta.Room(1, box(0, 0, 4, 3)), pianta.Room(2, box(4, 0, 8, 3))))
    >>> pianta.judge_realism(rooms_without_doors, made).verdict
    'less typical than any of the 6 reference floors'
    """
    check_argument(floor, Floor, "floor", "a Floor of read or reconstruct")
    check_argument(reference, (RealismModel, list, tuple, type(None)), "reference", "floors, or a model of them")
    if reference is None:
        model = realism_of_types(read_default_building_model())
    elif isinstance(reference, RealismModel):
        model = reference
    else:
        real = [complete_labels(each, LabelSet.R_C).floor for each in reference]
        model = learn_realism(real, label_set=LabelSet.R_C)
    return model.judge(complete_labels(floor, model.label_set).floor)
