"""A dictionary of room names in several languages, and the prior on labels that a room's name gives.

name_dictionary.json has entries with a `function` (F/C/E/S), `labels` (building type -> labels) and `words` (language
-> words and phrases). Files of users have the same format, and take precedence over pianta's.
"""

from __future__ import annotations

import unicodedata
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
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
# Probability of all other labels together, by the kind of match. All values below were chosen by hand.
P_OTHER_EXACT_MATCH = 0.05
P_OTHER_PART_MATCH = 0.15
P_OTHER_FUZZY_MATCH = 0.2
# Letters of the shortest word that may match as a part of another, letters of the rest of that one, and letters of the
# shortest word that may match fuzzily.
MIN_PART = 5
MIN_REST = 3
MIN_FUZZY = 5
# Least similarity of a misread word (difflib.SequenceMatcher.ratio); with the second, it takes precedence over parts.
MIN_SIMILARITY = 0.84
HIGH_SIMILARITY = 0.87

# Letters that OCR confuses with digits.
_CONFUSED_DIGITS = str.maketrans("01358", "olesb")


def _upper(value: object) -> object:
    return value.strip().upper() if isinstance(value, str) else value


def _check_phrase(phrase: str) -> str:
    if not normalize_name(phrase):
        raise ValueError("a word has no letter, leave it out")
    return phrase


_Label = Annotated[str, AfterValidator(standard_name)]
_Phrase = Annotated[str, Field(max_length=100), AfterValidator(_check_phrase)]
_Type = Annotated[str, AfterValidator(standard_building_type)]


@dataclass(frozen=True)
class RoomNameEntry:
    """What rooms with some names are for.

    function: F/C/E/S, unless the labels of the building type say otherwise. words: language -> words and phrases.
    labels: building type -> labels.
    """

    __pydantic_config__ = ConfigDict(extra="forbid")

    function: Annotated[FCES, BeforeValidator(_upper)]
    words: Annotated[Mapping[str, tuple[_Phrase, ...]], Field(min_length=1)]
    labels: Mapping[_Type, tuple[_Label, ...]] = field(default_factory=dict)


@dataclass(frozen=True)
class RoomNameDictionary:
    """A dictionary of room names: entries by their words."""

    entries: tuple[RoomNameEntry, ...]

    @cached_property
    def by_phrase(self) -> Mapping[str, Mapping[int, int]]:
        """Normalised phrase -> index of an entry -> in how many languages the entry has the phrase."""
        by_phrase: dict[str, dict[int, int]] = {}
        for index, entry in enumerate(self.entries):
            for phrase in (phrase for phrases in entry.words.values() for phrase in {*map(normalize_name, phrases)}):
                counts = by_phrase.setdefault(phrase, {})
                counts[index] = counts.get(index, 0) + 1
        return by_phrase

    @cached_property
    def by_length(self) -> Mapping[int, tuple[str, ...]]:
        """The phrases by their number of words, sorted."""
        counts = {len(phrase.split()) for phrase in self.by_phrase}
        return {count: tuple(sorted(p for p in self.by_phrase if len(p.split()) == count)) for count in sorted(counts)}

    def extended(self, other: RoomNameDictionary) -> RoomNameDictionary:
        """The dictionary with the words of another one, which replaces the entries of its words."""
        own = tuple(replace(entry, words=_drop_phrases(entry.words, other.by_phrase)) for entry in self.entries)
        return RoomNameDictionary((*other.entries, *own))


def _drop_phrases(words: Mapping[str, tuple[str, ...]], phrases: Mapping[str, object]) -> dict[str, tuple[str, ...]]:
    return {
        language: tuple(word for word in each if normalize_name(word) not in phrases)
        for language, each in words.items()
    }


@dataclass(frozen=True)
class PhraseMatch:
    """A phrase of the dictionary in a name, and the probability that the room has another label."""

    phrase: str
    p_other: float


def normalize_name(text: str) -> str:
    """A name in lower case without accents and punctuation, with single spaces."""
    # Decomposed before and after folding the case, as 𝐀 is a letter without case until it becomes A.
    folded = unicodedata.normalize("NFKD", text).casefold()
    plain = unicodedata.normalize("NFKD", folded.replace("'s", "s").replace("’s", "s"))
    return " ".join(
        "".join(sign if sign.isalnum() else " " for sign in plain if not unicodedata.combining(sign)).split()
    )


def match_phrase(name: str, words: RoomNameDictionary) -> PhraseMatch | None:
    """The phrase of the dictionary in a name, or None.

    In order: the longest exact match; a very similar phrase, for letters that OCR misread; the longest word that is
    part of a word of the name, as in German compounds; a similar phrase.
    """
    tokens = normalize_name(name).split()
    # AULA4 is numbered, and CLA55 misread.
    without_numbers = [token.rstrip("0123456789") or token for token in tokens]
    for variant in (without_numbers, [_replace_digits(token) for token in tokens]):
        exact = _find_exact(variant, words)
        if exact:
            return PhraseMatch(exact, P_OTHER_EXACT_MATCH)
    tokens = [_replace_digits(token) for token in without_numbers]
    fuzzy = _find_fuzzy(tokens, words, HIGH_SIMILARITY)
    part = None if fuzzy else _find_part(tokens, words)
    if part:
        return PhraseMatch(part, P_OTHER_PART_MATCH)
    fuzzy = fuzzy or _find_fuzzy(tokens, words, MIN_SIMILARITY)
    return PhraseMatch(fuzzy, P_OTHER_FUZZY_MATCH) if fuzzy else None


def _replace_digits(token: str) -> str:
    """A word with letters for the digits that OCR confuses with them."""
    letters = sum(map(str.isalpha, token))
    return token.translate(_CONFUSED_DIGITS) if letters >= 3 else token


def _list_runs(tokens: Sequence[str], words: RoomNameDictionary) -> list[str]:
    """All runs of successive words of a name, no longer than the longest phrase, the longest run first."""
    most = max(words.by_length, default=0)
    ends = range(len(tokens) + 1)
    runs = [" ".join(tokens[start:end]) for end in ends for start in range(max(0, end - most), end)]
    return sorted(runs, key=lambda run: -len(run))


def _find_exact(tokens: Sequence[str], words: RoomNameDictionary) -> str | None:
    """The longest phrase in a name, also as plural in s, or two words written as one; None without any."""
    runs, phrases = _list_runs(tokens, words), words.by_phrase
    exact = next((run for run in runs if run in phrases), None)
    # A plural in s; then two words that a plan writes as one.
    exact = exact or next((run[:-1] for run in runs if run.endswith("s") and run[:-1] in phrases), None)
    pairs = words.by_length.get(2, ())
    return exact or max((pair for pair in pairs if pair.replace(" ", "") in tokens), key=len, default=None)


def _find_part(tokens: Sequence[str], words: RoomNameDictionary) -> str | None:
    """The longest word of the dictionary that starts or ends a token; of equals the end, the head of a compound."""
    parts = [
        (len(phrase), token.endswith(phrase), phrase)
        for token in tokens
        for phrase in words.by_length.get(1, ())
        if MIN_PART <= len(phrase) <= len(token) - MIN_REST and (token.startswith(phrase) or token.endswith(phrase))
    ]
    return max(parts)[2] if parts else None


def _find_fuzzy(tokens: Sequence[str], words: RoomNameDictionary, similarity: float) -> str | None:
    """The phrase most similar to the longest run of words with a similar one, or None; similarity: at least."""
    for run in _list_runs(tokens, words):
        if len(run) < MIN_FUZZY or not any(map(str.isalpha, run)):
            continue
        near = [phrase for phrase in words.by_length.get(len(run.split()), ()) if abs(len(phrase) - len(run)) <= 2]
        matches = get_close_matches(run, [phrase for phrase in near if len(phrase) >= MIN_FUZZY], 1, similarity)
        if matches:
            return matches[0]
    return None


def room_name_prior(name: str, labels: LabelSchema | None, words: RoomNameDictionary) -> dict[str, float] | None:
    """Probabilities of the labels of a building type, or of F/C/E/S if None, by nothing but a room's name.

    The labels of the matching entries share nearly all; an entry without a label of the type gives its share to the
    labels of its function. None if the dictionary has no word of the name.
    """
    match = match_phrase(name, words)
    if match is None:
        return None
    counts = words.by_phrase[match.phrase]
    names = list(FCES) if labels is None else [label.name for label in labels.labels]
    prior = dict.fromkeys(map(str, names), match.p_other / len(names))
    for index, count in counts.items():
        entry_labels = _list_entry_labels(words.entries[index], labels)
        if not entry_labels:
            return None
        for label in entry_labels:
            prior[label] += (1 - match.p_other) * count / sum(counts.values()) / len(entry_labels)
    return prior


def _list_entry_labels(entry: RoomNameEntry, labels: LabelSchema | None) -> list[str]:
    """The labels of an entry in a schema, or in F/C/E/S if None."""
    if labels is None:
        # Functions by the schemas of types, where none has that of the entry: an office is SERVICE in a school, and
        # FUNCTIONAL in an office building.
        schemas = ((SCHEMAS[name].by_name, names) for name, names in entry.labels.items() if name in SCHEMAS)
        functions = [{by_name[name].function_in() for name in names if name in by_name} for by_name, names in schemas]
        others = [each for each in functions if entry.function not in each]
        return sorted(map(str, {entry.function}.union(*others)))
    own = [name for name in entry.labels.get(labels.building_type, ()) if name in labels.by_name]
    return own or [label.name for label in labels.labels if label.function_in() is entry.function]


@cache
def read_default_room_name_dictionary() -> RoomNameDictionary:
    """The dictionary that comes with pianta: English, Italian, German, French, Spanish and Portuguese."""
    return parse_dictionary(Path(__file__).with_name("name_dictionary.json").read_bytes())


def read_room_name_dictionary(path: str | Path) -> RoomNameDictionary:
    """The dictionary of pianta, extended by a file of the same format.

    Raises LabelError, with every fault in one message, for a file that is no dictionary.
    """
    words = read_checked(path, "room words", LabelError, parse_dictionary, max_bytes=MAX_FILE_BYTES)
    return read_default_room_name_dictionary().extended(words)


class _File(BaseModel):
    model_config = ConfigDict(defer_build=True, extra="forbid", frozen=True)

    format: str
    version: str
    kinds: Annotated[tuple[RoomNameEntry, ...], Field(min_length=1)]


@validation_as(LabelError)
def parse_dictionary(content: bytes) -> RoomNameDictionary:
    """The dictionary of the content of a file; raises LabelError, with every fault in one message."""
    FORMAT.check_version(content, LabelError)
    return RoomNameDictionary(_File.model_validate_json(content).kinds)
