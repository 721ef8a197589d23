"""What a room's name says of its label: a dictionary of words in several languages, and priors on labels from it.

name_dictionary.json has kinds of rooms. A kind has a `function` (F/C/E/S), `labels` (building type -> labels) and
`words` (language -> words and phrases). Files of users are of the same form, and their words come before those of
pianta.
"""

from __future__ import annotations

import unicodedata
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from functools import cache, cached_property
from pathlib import Path
from typing import Annotated

from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict, Field

from pianta.errors import LabelError
from pianta.io._checked import FileFormat, read_checked
from pianta.io._faults import validation_as
from pianta.labels import FCES, SCHEMAS, LabelSchema, standard_building_type, standard_name

FORMAT = FileFormat("pianta room words", 1)
MAX_FILE_BYTES = 256 * 2**10
# What is left for the labels that a name does not speak of, all together: by how well a word was found.
P_OTHER_EXACT_MATCH, P_OTHER_PART_MATCH, P_OTHER_FUZZY_MATCH = 0.05, 0.15, 0.2
# Words shorter than this are not looked for within others, which go on for so many letters, and not among misread ones.
LEAST_PART, LEAST_REST, LEAST_LIKE = 5, 3, 5
# How alike a misread word must be (difflib.SequenceMatcher.ratio); when more, before parts of words are looked for.
ALIKE, VERY_ALIKE = 0.84, 0.87

# Letters for which OCR takes digits.
_LOOK_ALIKE = str.maketrans("01358", "olesb")


@dataclass(frozen=True)
class RoomNameEntry:
    """What a word may stand for.

    function: its place in F/C/E/S where the building type says nothing. labels: building type -> labels.
    words: language -> words and phrases.
    """

    function: FCES
    labels: Mapping[str, tuple[str, ...]]
    words: Mapping[str, tuple[str, ...]]


@dataclass(frozen=True)
class RoomNameDictionary:
    """A dictionary: kinds of rooms by the words for them."""

    kinds: tuple[RoomNameEntry, ...]

    @cached_property
    def by_phrase(self) -> Mapping[str, Mapping[int, int]]:
        """Folded phrase -> index of a kind -> in how many languages the phrase means it."""
        found: dict[str, dict[int, int]] = {}
        for index, kind in enumerate(self.kinds):
            for phrase in (phrase for phrases in kind.words.values() for phrase in {*map(normalize_name, phrases)}):
                counts = found.setdefault(phrase, {})
                counts[index] = counts.get(index, 0) + 1
        return found

    @cached_property
    def by_length(self) -> Mapping[int, tuple[str, ...]]:
        """The phrases by how many words they have, sorted."""
        counts = {len(phrase.split()) for phrase in self.by_phrase}
        return {count: tuple(sorted(p for p in self.by_phrase if len(p.split()) == count)) for count in sorted(counts)}

    def extended(self, other: RoomNameDictionary) -> RoomNameDictionary:
        """The dictionary with the words of another one, which come first where both have a word."""
        theirs = set(other.by_phrase)
        kept = tuple(
            RoomNameEntry(
                kind.function,
                kind.labels,
                {
                    language: tuple(word for word in words if normalize_name(word) not in theirs)
                    for language, words in kind.words.items()
                },
            )
            for kind in self.kinds
        )
        return RoomNameDictionary((*other.kinds, *kept))


@dataclass(frozen=True)
class PhraseMatch:
    """A phrase of the dictionary in a name, and what is left for it not to be meant."""

    phrase: str
    doubt: float


def normalize_name(text: str) -> str:
    """A name in small letters without accents and signs, with single blanks."""
    plain = unicodedata.normalize("NFKD", text.casefold().replace("'s", "s").replace("’s", "s"))
    return " ".join(
        "".join(sign if sign.isalnum() else " " for sign in plain if not unicodedata.combining(sign)).split()
    )


def match_phrase(name: str, words: RoomNameDictionary) -> PhraseMatch | None:
    """The phrase of the dictionary that a name has; None for none.

    The longest one of its words as they are; else what it is very much like, as OCR misreads letters; else the longest
    part of a word, as in German compounds; else what it is rather like.
    """
    tokens = normalize_name(name).split()
    # AULA4 is numbered, and CLA55 misread.
    spelt = [token.rstrip("0123456789") or token for token in tokens]
    for variant in (spelt, [_spell(token) for token in tokens]):
        whole = _find_whole(variant, words)
        if whole:
            return PhraseMatch(whole, P_OTHER_EXACT_MATCH)
    tokens = [_spell(token) for token in spelt]
    like = _find_like(tokens, words, VERY_ALIKE)
    part = None if like else _find_part(tokens, words)
    if part:
        return PhraseMatch(part, P_OTHER_PART_MATCH)
    like = like or _find_like(tokens, words, ALIKE)
    return PhraseMatch(like, P_OTHER_FUZZY_MATCH) if like else None


def _spell(token: str) -> str:
    """A word with letters for the digits that OCR takes for them."""
    letters = sum(map(str.isalpha, token))
    return token.translate(_LOOK_ALIKE) if letters >= 3 else token


def _runs(tokens: Sequence[str], words: RoomNameDictionary) -> list[str]:
    """All successive words of a name, no more than a phrase has, the longest first."""
    most = max(words.by_length, default=0)
    ends = range(len(tokens) + 1)
    runs = [" ".join(tokens[start:end]) for end in ends for start in range(max(0, end - most), end)]
    return sorted(runs, key=lambda run: -len(run))


def _find_whole(tokens: Sequence[str], words: RoomNameDictionary) -> str | None:
    runs, phrases = _runs(tokens, words), words.by_phrase
    found = next((run for run in runs if run in phrases), None)
    # A plural in s; words that a plan writes in one.
    found = found or next((run[:-1] for run in runs if run.endswith("s") and run[:-1] in phrases), None)
    pairs = words.by_length.get(2, ())
    return found or max((pair for pair in pairs if pair.replace(" ", "") in tokens), key=len, default=None)


def _find_part(tokens: Sequence[str], words: RoomNameDictionary) -> str | None:
    """The longest word with which another one begins or ends; of equals an end, which says what a compound is."""
    parts = [
        (len(phrase), token.endswith(phrase), phrase)
        for token in tokens
        for phrase in words.by_length.get(1, ())
        if LEAST_PART <= len(phrase) <= len(token) - LEAST_REST and (token.startswith(phrase) or token.endswith(phrase))
    ]
    return max(parts)[2] if parts else None


def _find_like(tokens: Sequence[str], words: RoomNameDictionary, ratio: float) -> str | None:
    for run in _runs(tokens, words):
        if len(run) < LEAST_LIKE or not any(map(str.isalpha, run)):
            continue
        near = [phrase for phrase in words.by_length.get(len(run.split()), ()) if abs(len(phrase) - len(run)) <= 2]
        like = get_close_matches(run, [phrase for phrase in near if len(phrase) >= LEAST_LIKE], 1, ratio)
        if like:
            return like[0]
    return None


def room_name_prior(name: str, labels: LabelSchema | None, words: RoomNameDictionary) -> dict[str, float] | None:
    """Probabilities of the labels of a building type, or of F/C/E/S for None, given nothing but a room's name.

    The labels of what the name means share nearly all; a kind that has no label of the type gives to those of its
    function. None for a name of which the dictionary knows no word.
    """
    found = match_phrase(name, words)
    if found is None:
        return None
    kinds = words.by_phrase[found.phrase]
    names = list(FCES) if labels is None else [label.name for label in labels.labels]
    prior = dict.fromkeys(map(str, names), found.doubt / len(names))
    for index, count in kinds.items():
        meant = _labels_of_kind(words.kinds[index], labels)
        if not meant:
            return None
        for label in meant:
            prior[label] += (1 - found.doubt) * count / sum(kinds.values()) / len(meant)
    return prior


def _labels_of_kind(kind: RoomNameEntry, labels: LabelSchema | None) -> list[str]:
    if labels is None:
        # An office serves a school, and is what an office building is for
        of_types = ((SCHEMAS[of].by_name, names) for of, names in kind.labels.items() if of in SCHEMAS)
        meant = [{by_name[name].function_in() for name in names if name in by_name} for by_name, names in of_types]
        others = [functions for functions in meant if kind.function not in functions]
        return sorted(map(str, {kind.function}.union(*others)))
    own = [name for name in kind.labels.get(labels.building_type, ()) if name in labels.by_name]
    return own or [label.name for label in labels.labels if label.function_in() is kind.function]


@cache
def read_default_room_name_dictionary() -> RoomNameDictionary:
    """The dictionary that comes with pianta: English, Italian, German, French, Spanish and Portuguese."""
    return _parse_words(Path(__file__).with_name("name_dictionary.json").read_bytes())


def read_room_name_dictionary(path: str | Path) -> RoomNameDictionary:
    """The dictionary of pianta with the words of a file of the same form, which come first.

    Raises LabelError, with every fault in one message, for a file that is no dictionary.
    """
    words = read_checked(path, "room words", LabelError, _parse_words, max_bytes=MAX_FILE_BYTES)
    return read_default_room_name_dictionary().extended(words)


def _upper(value: object) -> object:
    return value.strip().upper() if isinstance(value, str) else value


def _check_phrase(phrase: str) -> str:
    if not normalize_name(phrase):
        raise ValueError("a word has no letter, leave it out")
    return phrase


class _Part(BaseModel):
    model_config = ConfigDict(defer_build=True, extra="forbid", frozen=True)


_Function = Annotated[FCES, BeforeValidator(_upper)]
_Label = Annotated[str, AfterValidator(standard_name)]
_Phrase = Annotated[str, Field(max_length=100), AfterValidator(_check_phrase)]
_Type = Annotated[str, AfterValidator(standard_building_type)]


class _Kind(_Part):
    function: _Function
    labels: dict[_Type, list[_Label]] = {}
    words: Annotated[dict[str, list[_Phrase]], Field(min_length=1)]


class _Dictionary(_Part):
    format: str
    version: str
    kinds: Annotated[list[_Kind], Field(min_length=1)]


@validation_as(LabelError)
def _parse_words(content: bytes) -> RoomNameDictionary:
    FORMAT.check_version(content, LabelError)
    dictionary = _Dictionary.model_validate_json(content)
    return RoomNameDictionary(
        tuple(
            RoomNameEntry(
                kind.function,
                {name: tuple(labels) for name, labels in kind.labels.items()},
                {language: tuple(phrases) for language, phrases in kind.words.items()},
            )
            for kind in dictionary.kinds
        )
    )
