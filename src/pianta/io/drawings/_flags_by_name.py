"""Why people may not count a space as a room, by its name: it is outside, a courtyard, an attic or a roof."""

from __future__ import annotations

import re
from collections.abc import Sequence
from types import MappingProxyType

from pianta.floor import OUTSIDE_FLAG

ATTIC, ROOF, COURTYARD = "attic", "roof", "courtyard"

# Words in the names of spaces, whole or as the start of a word, in the languages of the label dictionary.
_WORDS = MappingProxyType(
    {
        ATTIC: "attic dachboden spitzboden dachspitz dachraum grenier comble zolder vliering soffitta sottotetto "
        "desván sótão vindsutrymme kattovinde чердак 阁楼 小屋裏",
        ROOF: "roof dach dachfläche flachdach toit toiture dak tetto techo cubierta tejado telhado yttertak "
        "крыша 屋顶 屋根",
        OUTSIDE_FLAG: "balcon balkon balcón balcony terrass terrace terraza terrazza dachterrass dakterras loggia "
        "deck porch veranda exterior aussenbereich außenbereich балкон террас 阳台 バルコニー",
    }
)
# These occur as the start of names of inner rooms, such as Dachgeschoss, so they must be whole words.
_COMPLETE_WORDS = frozenset({"roof", "dach", "dak", "toit", "exterior", "deck"})
# The last words of names: a garden room is inside, and so is a winter garden.
_LAST_WORDS = MappingProxyType(
    {
        COURTYARD: "courtyard innenhof lichthof patio cour cortile binnenplaats innergård sisäpiha двор 中庭",
        OUTSIDE_FLAG: "garden garten jardin jardín giardino tuin trädgård puutarha сад 庭園",
    }
)
_WINTER = frozenset({"winter", "hiver"})


def find_flag_in_name(name: str) -> str | None:
    """What a name says of a room: that it is outside, a courtyard, an attic or a roof; None for any other."""
    words = _list_words(name)
    for flag in (OUTSIDE_FLAG, ATTIC, ROOF):
        for listed in _WORDS[flag].split():
            if any(word == listed or (listed not in _COMPLETE_WORDS and word.startswith(listed)) for word in words):
                return flag
    return next((flag for flag in _LAST_WORDS if _ends_with(words, flag)), None)


def names_garden(name: str) -> bool:
    """Whether a name is that of a garden, which is always on the ground."""
    return _ends_with(_list_words(name), OUTSIDE_FLAG)


def _list_words(name: str) -> list[str]:
    return re.findall(r"[^\W\d]+", name.casefold())


def _ends_with(words: Sequence[str], flag: str) -> bool:
    return bool(words) and not _WINTER.intersection(words) and words[-1] in _LAST_WORDS[flag].split()
