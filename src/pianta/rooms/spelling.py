"""Names of rooms that were read from pixels, spelled as the words that rooms have: BURO is BÜRO, DUREAU is BUREAU.

A word is mended only if one word of the dictionary fits. Accents are restored where the only spelling of the word has
them, or another room of the floor shows which one is meant. A misread letter is mended where it looks like the right
one, in long words.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

from pianta.floor import Floor, Room
from pianta.rooms.name_dictionary import RoomNameDictionary, normalize_name

# Letters of the shortest word in which a misread letter is mended; names of people are often shorter. By hand
MIN_MISREAD = 6
# Letters of the shortest word whose accents are restored
MIN_ACCENTED = 3
# Letters that text readers confuse with each other
_SIMILAR_LETTERS = tuple(
    map(frozenset, ("bdopqcg", "eoc", "ao", "ilt1j", "uvwy", "hmnk", "mwn", "prf", "sbg", "xk", "ar"))
)
# Accents that are written on capitals in all languages; French, Spanish and Italian often leave the others out
_ON_CAPITALS = frozenset("äöüåñãõ")
_WORDS = re.compile(r"[^\W\d_]+")

Spellings = Mapping[str, frozenset[str]]


@dataclass(frozen=True)
class Vocabulary:
    """Words without accents -> their spellings in small letters; by_plain: those of the dictionary."""

    by_plain: Spellings
    on_floor: Mapping[str, Counter[str]]


def correct_spelling(floor: Floor, *words: RoomNameDictionary) -> Floor:
    """The floor with the misread words in the names of its rooms mended.

    words: dictionaries of the words that rooms have.

    Examples
    --------
    >>> from pianta.rooms.name_dictionary import read_default_room_name_dictionary
    >>> vocabulary = list_vocabulary(["BURO 1"], [read_default_room_name_dictionary()])
    >>> correct_name("BURO 1", vocabulary), correct_name("DUREAU DU MEDECIN", vocabulary)
    ('BÜRO 1', 'BUREAU DU MEDECIN')
    """
    vocabulary = list_vocabulary([room.name or "" for room in floor], words)

    def correct(room: Room) -> Room:
        return replace(room, name=correct_name(room.name, vocabulary)) if room.name else room

    return replace(floor, rooms=tuple(map(correct, floor)))


def list_vocabulary(names: Iterable[str], dictionaries: Iterable[RoomNameDictionary]) -> Vocabulary:
    """The words of dictionaries and of the names on a floor."""
    by_plain: dict[str, set[str]] = {}
    for dictionary in dictionaries:
        for phrase in (phrase for entry in dictionary.entries for each in entry.words.values() for phrase in each):
            for word in _WORDS.findall(phrase):
                by_plain.setdefault(normalize_name(word), set()).add(word.casefold())
    on_floor: dict[str, Counter[str]] = {}
    for word in (word for name in names for word in _WORDS.findall(name)):
        on_floor.setdefault(normalize_name(word), Counter())[word.casefold()] += 1
    return Vocabulary({plain: frozenset(spellings) for plain, spellings in by_plain.items()}, on_floor)


def correct_name(name: str, vocabulary: Vocabulary) -> str:
    """A name with its misread words mended."""
    return _WORDS.sub(lambda match: _correct_word(match.group(), vocabulary), name)


def _correct_word(word: str, vocabulary: Vocabulary) -> str:
    plain = normalize_name(word)
    spellings = vocabulary.by_plain.get(plain)
    if spellings is None:
        return _mend_letter(word, plain, vocabulary) if plain == word.casefold() else word
    if plain != word.casefold() or len(plain) < MIN_ACCENTED:
        return word
    if plain in spellings:
        # The word is spelled so in one language; other rooms may show that it is another one
        others = [each for each in vocabulary.on_floor.get(plain, ()) if each != plain and each in spellings]
        return _as_written(others[0], word) if len(others) == 1 else word
    accented = next(iter(spellings))
    is_certain = len(spellings) == 1 and (not word.isupper() or _accents(accented) <= _ON_CAPITALS)
    return _as_written(accented, word) if is_certain else word


def _accents(word: str) -> frozenset[str]:
    return frozenset(letter for letter in word if normalize_name(letter) != letter)


def _mend_letter(word: str, plain: str, vocabulary: Vocabulary) -> str:
    """The only word of the dictionary that differs by one letter that looks alike; else the word."""
    if len(plain) < MIN_MISREAD:
        return word
    near = [other for other in vocabulary.by_plain if len(other) == len(plain) and _is_misread(plain, other)]
    if len(near) != 1:
        return word
    spellings = vocabulary.by_plain[near[0]]
    return _as_written(near[0] if near[0] in spellings else min(spellings), word)


def _is_misread(plain: str, other: str) -> bool:
    """Whether two words of equal length differ by one letter that looks alike."""
    pairs = [frozenset(pair) for pair in zip(plain, other, strict=True) if pair[0] != pair[1]]
    return len(pairs) == 1 and any(pairs[0] <= group for group in _SIMILAR_LETTERS)


def _as_written(spelling: str, word: str) -> str:
    """A spelling in the capitals of a word."""
    if word.isupper():
        return spelling.upper()
    return spelling.capitalize() if word[:1].isupper() else spelling
