"""Labels of rooms in the label sets of the thesis, and the schema that lists those of a building type (section 4.3).

Each label maps upwards to F/C/E/S, and that to R/C. The thesis maps them in three ways (LabelConvention), because its
experiments and its graphs depart from its figure.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from enum import StrEnum
from functools import cached_property

from pianta.errors import LabelError

MAX_NAME_LENGTH = 100  # characters of a label


class RC(StrEnum):
    """L_R/C: a space for an activity, or one that connects spaces."""

    ROOM = "ROOM"
    CORRIDOR = "CORRIDOR"


class FCES(StrEnum):
    """L_F/C/E/S: core activity of the building, connection on a floor, way to other floors or outside, support."""

    FUNCTIONAL = "FUNCTIONAL"
    CONNECTION = "CONNECTION"
    ENTRANCE = "ENTRANCE"
    SERVICE = "SERVICE"


class GeneralLabel(StrEnum):
    """L_general of section 4.2.1: two types of connecting rooms, and the size of the others."""

    CORRIDOR = "C"
    HALL = "H"
    SMALL = "S"
    MEDIUM = "M"
    BIG = "B"


class LabelSet(StrEnum):
    """The label sets, from the coarsest to the labels of a building type."""

    R_C = "R/C"
    F_C_E_S = "F/C/E/S"
    GENERAL = "general"
    TYPE = "type"


class LabelConvention(StrEnum):
    """The thesis' three ways to map labels to F/C/E/S and R/C.

    FIGURE: Fig. 4.5. CONNECTION and ENTRANCE are CORRIDOR; a school's gym and conference room are SERVICE.
    EXPERIMENTS: sections 5.3, 6.2 and 8.1. Only CONNECTION is CORRIDOR; a school's gym and conference room are
        FUNCTIONAL.
    GRAPHS: Table 5.1 and chapter 7. CORRIDOR, HALL, LOBBY, ENTRANCE and OPENSPACE are CORRIDOR; F/C/E/S is that of
        EXPERIMENTS.
    """

    FIGURE = "figure"
    EXPERIMENTS = "experiments"
    GRAPHS = "graphs"


def standard_name(name: str) -> str:
    """A label's name in capitals, with one space between words.

    Raises LabelError for an empty name, more than 100 characters, or some that cannot be printed.
    """
    return _check_name(_one_spaced(name).upper())


def normalize_label(text: str | None) -> str | None:
    """A label in capitals with single blanks, whether a schema has it or not; None for an empty one."""
    return _one_spaced(text or "").upper() or None


def standard_building_type(building_type: str) -> str:
    """A building type in lower case, with one space between words.

    Raises LabelError as standard_name does.
    """
    return _check_name(_one_spaced(building_type).lower())


def _one_spaced(text: str) -> str:
    return " ".join(text.split())


def _check_name(name: str) -> str:
    """The same name; LabelError if it is empty, too long or not printable."""
    if not name:
        raise LabelError("the name is empty, give a word")
    if len(name) > MAX_NAME_LENGTH:
        raise LabelError(f"the name {name[:20]!r}… has {len(name)} characters, give {MAX_NAME_LENGTH} at most")
    if not name.isprintable():
        raise LabelError(f"the name {name!r} has characters that cannot be printed, leave them out")
    return name


def standard_color(color: str) -> str:
    """A colour as #rrggbb, in lower case.

    Raises LabelError for any other text.
    """
    standard = color.lower()
    if not re.fullmatch("#[0-9a-f]{6}", standard):
        raise LabelError(f"the colour {color[:20]!r} is invalid, give #rrggbb")
    return standard


@dataclass(frozen=True)
class Label:
    """A label of a building type, and its labels in the coarser sets.

    name: in any case, becomes capitals. function: in F/C/E/S, by Fig. 4.5. general: in L_general.
    color: #rrggbb, of Figs. 5.2 and 5.3.
    in_experiments: in F/C/E/S in the experiments; None for the same as `function`.
    corridor_in_graphs: whether it is a corridor in Table 5.1; None for whether it is a CONNECTION.

    Raises LabelError for an invalid name or colour, and if function and general contradict each other:
    a CONNECTION is C or H, FUNCTIONAL and SERVICE are S, M or B (section 4.3.1), an ENTRANCE is any.
    """

    name: str
    function: FCES
    general: GeneralLabel
    color: str
    in_experiments: FCES | None = None
    corridor_in_graphs: bool | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "name", standard_name(self.name))
        object.__setattr__(self, "color", standard_color(self.color))
        connects = self.general in (GeneralLabel.CORRIDOR, GeneralLabel.HALL)
        if self.function is not FCES.ENTRANCE and connects is not (self.function is FCES.CONNECTION):
            raise LabelError(
                f"{self.name} is {self.function} and of size {self.general}; "
                "give a CONNECTION the size C or H, FUNCTIONAL and SERVICE S, M or B"
            )

    def function_in(self, convention: LabelConvention = LabelConvention.EXPERIMENTS) -> FCES:
        """Its label in F/C/E/S."""
        return self.function if convention is LabelConvention.FIGURE else self.in_experiments or self.function

    def room_or_corridor(self, convention: LabelConvention = LabelConvention.EXPERIMENTS) -> RC:
        """Its label in R/C."""
        function = self.function_in(convention)
        corridor = function is FCES.CONNECTION
        if convention is LabelConvention.FIGURE:
            corridor |= function is FCES.ENTRANCE
        if convention is LabelConvention.GRAPHS and self.corridor_in_graphs is not None:
            corridor = self.corridor_in_graphs
        return RC.CORRIDOR if corridor else RC.ROOM

    def map_to(self, label_set: LabelSet, convention: LabelConvention = LabelConvention.EXPERIMENTS) -> str:
        """Its label in a set."""
        match label_set:
            case LabelSet.R_C:
                return self.room_or_corridor(convention)
            case LabelSet.F_C_E_S:
                return self.function_in(convention)
            case LabelSet.GENERAL:
                return self.general
            case LabelSet.TYPE:
                return self.name


@dataclass(frozen=True)
class LabelSchema:
    """The labels of a building type, L_type of the thesis.

    Parameters
    ----------
    building_type
        The type in any case, becomes lower case.
    labels
        At least one; each name once.

    Raises
    ------
    LabelError
        There is no label or no building type, or names occur more than once; the message lists them.

    References
    ----------
    M. Luperto, PhD thesis, section 4.3.

    Examples
    --------
    >>> from pianta.labels import SCHOOL
    >>> SCHOOL.building_type, len(SCHOOL.labels)
    ('school', 23)
    """

    building_type: str
    labels: tuple[Label, ...]

    def __post_init__(self) -> None:
        building_type = standard_building_type(self.building_type)
        object.__setattr__(self, "building_type", building_type)
        object.__setattr__(self, "labels", tuple(self.labels))
        if not self.labels:
            raise LabelError(f"the schema of {building_type!r} has no label, give one at least")
        counts = Counter(label.name for label in self.labels)
        repeated = sorted(name for name, count in counts.items() if count > 1)
        if repeated:
            raise LabelError(f"the schema of {building_type!r} has labels twice: {', '.join(repeated)}")

    @cached_property
    def by_name(self) -> Mapping[str, Label]:
        """The labels by their names."""
        return {label.name: label for label in self.labels}

    def map_labels(
        self,
        names: Iterable[str | None],
        label_set: LabelSet,
        *,
        convention: LabelConvention = LabelConvention.EXPERIMENTS,
    ) -> list[str]:
        """Map names of labels to a coarser label set.

        Parameters
        ----------
        names
            Labels of the schema, in any case. None, for a room without a label, is refused.
        label_set
            The set to map to: R/C, F/C/E/S, L_general, or the schema's own.
        convention
            The convention of the thesis for R/C and F/C/E/S.

        Returns
        -------
        list of str
            A label of the set for each name.

        Raises
        ------
        LabelError
            A name is not in the schema; the message lists all of them.

        Examples
        --------
        >>> from pianta.labels import SCHOOL, LabelSet
        >>> [str(label) for label in SCHOOL.map_labels(["classroom", "hall"], LabelSet.R_C)]
        ['ROOM', 'CORRIDOR']
        """
        names = list(names)
        labels = [self._find(name) for name in names]
        unknown = sorted({repr(name) for name, label in zip(names, labels, strict=True) if label is None})
        if unknown:
            raise LabelError(
                f"labels {', '.join(unknown)} are not in the schema of {self.building_type!r}, "
                f"which has {', '.join(self.by_name)}; rename them or give a schema that has them"
            )
        return [label.map_to(label_set, convention) for label in labels if label]

    def _find(self, name: str | None) -> Label | None:
        return None if name is None else self.by_name.get(_one_spaced(name).upper())
