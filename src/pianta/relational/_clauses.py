"""A tokenizer of Prolog clauses without rules: atoms, numbers and punctuation between full stops."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from math import isinf
from typing import NamedTuple

from pianta.io._files import short_repr
from pianta.relational.facts import Value, write_term

MAX_CLAUSE_TOKENS = 1000
MAX_NUMBER_LENGTH = 300

# All quantifiers are possessive, so that any file takes linear time.
_TOKEN = re.compile(
    r"""
      (?P<skipped> \s++ | %[^\n]*+ | /\*(?s:.*?)\*/ )
    | (?P<end> \. (?=[\s%]|\Z) )
    | (?P<number> [+-]?+ [0-9]++ (?:\.[0-9]++)?+ (?:[eE][+-]?+[0-9]++)?+ (?!\w) )
    | (?P<word> [^\W\d] \w*+ )
    | (?P<quoted> ' (?: [^'\\\n] | '' | \\x[0-9a-fA-F]++\\ | \\[0-7]++\\ | \\[^\n] )*+ ' )
    | (?P<mark> :: | :- | [(),@] )
    | (?P<open> /\*(?s:.)*+ | ['"][^\n]*+ )
    | (?P<other> [^\s(),.%'"/]++ | . )
    """,
    re.VERBOSE,
)
_ESCAPE = re.compile(r"''|\\(?:x([0-9a-fA-F]{1,6})\\|([0-7]{1,7})\\|(.))")
_ESCAPED = {"n": "\n", "t": "\t", "r": "\r", "a": "\a", "b": "\b", "f": "\f", "v": "\v", "e": "\x1b"}
_ESCAPED |= {mark: mark for mark in "\\'\"`"}


class Token(NamedTuple):
    """kind: "atom", "number", "variable", "end", "fault" (value is the message), or the mark itself."""

    kind: str
    value: Value
    line: int


class ClauseError(Exception):
    """A fault of a clause."""


def split_clauses(text: str) -> Iterator[list[Token]]:
    """Clauses without their full stops; a clause without one ends with a fault."""
    clause: list[Token] = []
    for token in _split_tokens(text):
        if token.kind != "end":
            # The rest of an overlong clause is dropped, as its length is a fault.
            if len(clause) <= MAX_CLAUSE_TOKENS:
                clause.append(token)
            continue
        if clause:
            yield clause
        clause = []
    if clause:
        yield [*clause, Token("fault", "the clause has no end, write a full stop and a line break", clause[-1].line)]


def _split_tokens(text: str) -> Iterator[Token]:
    """The tokens of a text with their lines, without blanks and comments; invalid text is of kind "fault"."""
    line = 1
    for match in _TOKEN.finditer(text):
        group, text = str(match.lastgroup), match.group()
        if group != "skipped":
            yield _make_token(group, text, line)
        line += text.count("\n")


def _make_token(group: str, text: str, line: int) -> Token:
    """The token of a match; group: its name in _TOKEN. Text that is invalid becomes a token of kind "fault"."""
    match group:
        case "number":
            return _make_number(text, line)
        case "word":
            # A letter without case begins an atom.
            is_variable = text[0] == "_" or text[0].isupper() or text[0].istitle()
            return Token("variable" if is_variable else "atom", text, line)
        case "quoted":
            return _make_atom(text[1:-1], line)
        case "mark" | "end":
            return Token("end" if group == "end" else text, text, line)
    fault = "never ends, close it" if group == "open" else "is not of facts, put text in single quotes"
    return Token("fault", f"{short_repr(text[:30])} {fault}", line)


def _make_atom(quoted: str, line: int) -> Token:
    try:
        return Token("atom", _ESCAPE.sub(_unescape, quoted), line)
    except ClauseError as error:
        return Token("fault", str(error), line)


def _make_number(text: str, line: int) -> Token:
    if len(text) > MAX_NUMBER_LENGTH or isinf(float(text)):
        return Token("fault", f"the number {short_repr(text[:30])} is too large or has too many digits", line)
    is_integer = text.lstrip("+-").isdigit()
    return Token("number", int(text) if is_integer else float(text), line)


def _unescape(match: re.Match[str]) -> str:
    """The character that an escape sequence in single quotes stands for; ClauseError if it is unknown."""
    hexadecimal, octal, letter = match.groups()
    if hexadecimal or octal:
        code = int(hexadecimal, 16) if hexadecimal else int(octal, 8)
        if code < 0x110000 and not 0xD800 <= code < 0xE000:
            return chr(code)
    elif letter is None:
        return "'"
    elif letter in _ESCAPED:
        return _ESCAPED[letter]
    raise ClauseError(f"the escape {short_repr(match.group())} is unknown")


class Clause:
    """A clause that is parsed token by token."""

    def __init__(self, tokens: Sequence[Token]) -> None:
        self.tokens = tokens
        self.position = 0
        fault = next((token for token in tokens if token.kind == "fault"), None)
        if fault:
            raise ClauseError(str(fault.value))
        if any(token.kind == ":-" for token in tokens):
            raise ClauseError("the clause is a rule or directive, give the facts that follow from it")
        if len(tokens) > MAX_CLAUSE_TOKENS:
            raise ClauseError(f"the clause has more than {MAX_CLAUSE_TOKENS} parts, is a full stop missing?")

    def has(self, token_kind: str) -> bool:
        """Whether the next token is of a kind."""
        return self.position < len(self.tokens) and self.tokens[self.position].kind == token_kind

    def expect(self, token_kind: str, what: str) -> Value:
        """Read the value of the next token, which must be of a kind; `what` is its noun in messages."""
        if not self.has(token_kind):
            raise ClauseError(f"{self._describe()} where {what} belongs")
        self.position += 1
        return self.tokens[self.position - 1].value

    def expect_atom(self, what: str) -> str:
        """Read the next token, which must be an atom."""
        return str(self.expect("atom", what))

    def finish(self) -> None:
        """Raise ClauseError unless all tokens have been read."""
        if self.position < len(self.tokens):
            raise ClauseError(f"{self._describe()} where a full stop belongs")

    def expect_value(self) -> Value:
        """Read the next token, which must be an atom or a number."""
        value = self.expect("number" if self.has("number") else "atom", "an atom or a number")
        if self.has("("):
            raise ClauseError(f"{write_term(value)}(…) is a term within a fact, give an atom or a number")
        return value

    def _describe(self) -> str:
        """The next token and a verb, or that the clause ends, as the start of a message."""
        if self.position == len(self.tokens):
            return "the clause ends"
        token = self.tokens[self.position]
        value = write_term(token.value) if token.kind in ("atom", "number") else str(token.value)
        if token.kind == "variable":
            return f"the variable {short_repr(value)} stands"
        return f"{short_repr(value)} stands"
