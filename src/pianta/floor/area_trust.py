"""How far the areas of a floor are to be trusted: the one rule for tables, pictures, the page and the terminal."""

from __future__ import annotations

from enum import StrEnum

# What is written instead of an area if the scale is unknown.
NO_AREA = "?"
ROUGH_DIGITS = 2
_LOOK = "nothing but the look of the drawing shows it"
_REMEDY = "read the plan with --resolution, or correct it with pianta correct --area or --length"


class AreaTrust(StrEnum):
    """How far the areas of a floor, which follow from its scale, are to be trusted.

    Attributes
    ----------
    EXACT
        "exact": shown as they are, as those of every map.
    ROUGH
        "rough": shown with a mark, since they may be wrong by a factor of 2 or more.
    UNKNOWN
        "unknown": left out where people look, as nothing but the look of the drawing shows the scale.

    Examples
    --------
    >>> from pianta.floor.area_trust import AreaTrust
    >>> [trust.format_area(41.2) for trust in AreaTrust]
    ['41.2 m²', '≈ 41 m²', '?']
    """

    EXACT = "exact"
    ROUGH = "rough"
    UNKNOWN = "unknown"

    @classmethod
    def for_scale(cls, *, is_rough: bool, is_look: bool) -> AreaTrust:
        """Find the trust in the areas of a scale.

        Parameters
        ----------
        is_rough, is_look
            As of `PlanScale`.

        Returns
        -------
        AreaTrust
            UNKNOWN, ROUGH or EXACT.
        """
        if is_look:
            return cls.UNKNOWN
        return cls.ROUGH if is_rough else cls.EXACT

    @classmethod
    def from_member(cls, member: object) -> AreaTrust:
        """Read the trust in the areas of a floor.geojson.

        Parameters
        ----------
        member
            Its member `scale`, whatever that holds.

        Returns
        -------
        AreaTrust
            EXACT without a scale, and for a damaged one.
        """
        if not isinstance(member, dict):
            return cls.EXACT
        return cls.for_scale(is_rough=member.get("is_rough") is True, is_look=member.get("is_look") is True)

    @property
    def note(self) -> str:
        """Why areas are marked or left out, and what helps, in one line; empty for exact ones."""
        if self is AreaTrust.UNKNOWN:
            return f"scale unknown, areas left out: {_LOOK}; {_REMEDY}"
        return self.warning

    @property
    def warning(self) -> str:
        """The same for a file that has all areas."""
        if self is AreaTrust.UNKNOWN:
            return f"scale unknown, areas are not to be trusted: {_LOOK}; {_REMEDY}"
        return f"areas may be wrong by a factor of 2 or more; {_REMEDY}" if self is AreaTrust.ROUGH else ""

    def mark_size(self, text: str) -> str:
        """Mark a size that follows from the scale.

        Parameters
        ----------
        text
            Such as "5 m".

        Returns
        -------
        str
            Such as "5 m", "≈ 5 m" or "?".
        """
        if self is AreaTrust.UNKNOWN:
            return NO_AREA
        return f"≈ {text}" if self is AreaTrust.ROUGH else text

    def format_area(self, area: float, *, digits: int = 1) -> str:
        """Write an area with its mark.

        Parameters
        ----------
        area
            The area, m².
        digits
            After the point, of an exact area.

        Returns
        -------
        str
            Such as "41.2 m²", "≈ 41 m²" or "?".
        """
        if self is AreaTrust.ROUGH:
            return self.mark_size(f"{round_roughly(area)} m²")
        return self.mark_size(f"{area:.{digits}f} m²")


def round_roughly(area: float) -> str:
    """An area with the two digits that a rough one has."""
    return f"{float(f'{area:.{ROUGH_DIGITS}g}'):g}"
