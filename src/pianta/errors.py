"""The exceptions and warnings of pianta, rooted in ValueError and UserWarning."""


class PiantaError(ValueError):
    """An input of pianta cannot be used; the message names it, its value and the remedy, in one line.

    It is a ValueError. The subclasses in `pianta.errors` are for different inputs.

    Examples
    --------
    >>> import pianta
    >>> try:
    ...     pianta.read_map("nowhere.yaml")
    ... except pianta.PiantaError as error:
    ...     print(error)
    map 'nowhere.yaml' does not exist, check the path
    """


class MapError(PiantaError):
    """A grid map cannot be read, written or interpreted."""


class FloorError(PiantaError):
    """A floor (rooms, doors, walls) is inconsistent, or its file cannot be read."""


class CorrectionError(PiantaError):
    """A correction does not fit a floor, or a file of corrections cannot be read."""


class BuildingError(PiantaError):
    """A file of a building cannot be read."""


class OptionError(PiantaError):
    """An option or parameter has an impossible value."""


class WriteError(PiantaError):
    """A file or folder cannot be written; its cause is the OSError."""


class DataError(PiantaError):
    """The data that a benchmark measures on is missing."""


class PlanError(PiantaError):
    """A picture or drawing of a plan cannot be read."""


class PlanWarning(UserWarning):
    """A plan was read with parts left out; the message describes them."""


class MapWarning(UserWarning):
    """A map was read but is suspicious; the message describes the defect and its treatment."""


class BuildingWarning(UserWarning):
    """A building had defects, which may have been repaired; the message lists them."""


class GraphError(PiantaError):
    """A graph that a kernel cannot compare: it is directed, has parallel edges, or nodes without labels."""


class LabelError(PiantaError):
    """A label that is not in a schema, or an invalid schema."""


class ModelError(PiantaError):
    """A model file that cannot be used, or data that no model can be trained on."""


class RelationError(PiantaError):
    """Facts that contradict their signatures, or a file of facts that cannot be read."""
