"""The exceptions and warnings of pianta, rooted in ValueError and UserWarning."""


class PiantaError(ValueError):
    """Something given to pianta cannot be used; the message says what, the value, and the remedy, in one line.

    It is a ValueError. Each kind of what can be wrong has a subclass in `pianta.errors`.

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


class BuildingError(PiantaError):
    """A layout XML of a building cannot be read."""


class OptionError(PiantaError):
    """An option or parameter has a value that makes no sense."""


class DataError(PiantaError):
    """The data that a benchmark measures on is missing."""


class PlanError(PiantaError):
    """A picture or drawing of a plan cannot be read."""


class PlanWarning(UserWarning):
    """A plan was readable but not all of it; the message says what was found and what was done about it."""


class MapWarning(UserWarning):
    """A map was readable but suspicious; the message says what was found and what was done about it."""


class BuildingWarning(UserWarning):
    """A layout XML had defects that were repaired; the message lists them."""


class GraphError(PiantaError):
    """A graph that a kernel cannot compare: what is no simple undirected graph, nodes without labels."""


class LabelError(PiantaError):
    """A label that no schema has, or a schema that is none."""


class ModelError(PiantaError):
    """A model file that cannot be used, or data that no model can be trained on."""


class RelationError(PiantaError):
    """Facts that contradict their signatures, or a file of facts that cannot be read."""
