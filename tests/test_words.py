"""Names, comments, messages and pages are in the field's words: none of the turns that once made them hard to read.

`python tests/test_words.py PATH ...` lists what is found. docs/reference/glossary.md has the words to use.
"""

import ast
import io
import re
import sys
import tokenize
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
# What is said instead, by name: of variables, parameters, functions and classes.
NAMES = {
    **dict.fromkeys(("found", "known", "told", "drawn", "kept", "seen", "judged", "given", "said"), "the noun"),
    **dict.fromkeys(
        ("made", "meant", "asked", "wished", "shown", "taken", "looked", "of", "whole", "like"), "the noun"
    ),
    "kind": "door_kind, building_type, file_format, input_kind; as a field of a class it may stay",
    "place": "index, position, location, room class",
    "places": "indices, positions, locations, room classes",
    "ours": "measured",
    "theirs": "published",
    "strange": "unusual",
}
# Words that no part of a name is.
PARTS = {
    *("told", "tell", "tells", "judge", "judges", "judged", "say", "says", "said", "meant", "lay", "lies", "strange"),
    *("nobody", "somebody", "astray", "wished", "wishes", "theirs", "ours", "doubt", "sure", "looked", "asked"),
}
# Words that no longer name begins with.
FIRST = {"of", "take", "weigh", "look", "spread"}
TURNS = (
    *(r"[Ss]o many", r"[Ss]o much(?! as)", r"\b(is|are|was|were) none\b", r"[Nn]obody", r"[Ss]omebody"),
    *(
        r"\b[Tt]old\b",
        r"\b[Tt]ells?\b",
        r"\b[Tt]elling\b",
        r"\b[Jj]udg(e|es|ed|ing)\b",
        r"\bsaid\b",
        r"\b(as )?of others\b",
    ),
    *(r"\bastray\b", r"\baside\b", r"\bthereof\b", r"\bwherein\b", r"\bnought\b", r"\b[Ii]n the place of\b"),
    *(r"\bno one\b", r"\bhave not\b(?! (been|yet))", r"\bhas no such\b", r"\b[Ss]trange(ly|r)?\b", r"\bdoubt(s|ed)?\b"),
    *(r"\bwhat is known\b", r"\bwhat was (seen|known|found|said)\b", r"\bthe like\b", r"\bwherever\b", r"\bshall\b"),
)
TURN = re.compile("|".join(f"(?:{turn})" for turn in TURNS))


def list_files(path: Path) -> list[Path]:
    """The files of Python, pages and notebooks of a folder, without this one, which has the words."""
    files = (
        [path] if path.is_file() else sorted(file for end in ("py", "md", "ipynb") for file in path.rglob(f"*.{end}"))
    )
    return [file for file in files if file.resolve() != Path(__file__).resolve()]


def find_faults(path: Path) -> list[str]:
    """Lines, names and turns of a file of Python or a page."""
    text = path.read_text(encoding="utf-8")
    faults = [*find_names(text), *find_turns_in_code(text)] if path.suffix == ".py" else find_turns(text, 1)
    return [f"{path}:{line}: {fault}" for line, fault in sorted(set(faults))]


def find_names(code: str) -> Iterator[tuple[int, str]]:
    tree = ast.parse(code)
    fields = {
        statement.target
        for node in ast.walk(tree)
        if isinstance(node, ast.ClassDef)
        for statement in node.body
        if isinstance(statement, ast.AnnAssign)
    }
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
            line, name = node.lineno, node.name
        elif isinstance(node, ast.arg):
            line, name = node.lineno, node.arg
        elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            line, name = node.lineno, "" if node in fields and node.id == "kind" else node.id
        else:
            continue
        if fault := find_fault(name):
            yield line, f"name {name} ({fault})"


def find_fault(name: str) -> str | None:
    """Why a name is hard to read, None if it is not."""
    bare = name.strip("_")
    if bare.lower() in NAMES:
        return NAMES[bare.lower()]
    parts = [part.lower() for part in re.split(r"_|(?<=[a-z0-9])(?=[A-Z])", bare) if part]
    if dialect := PARTS.intersection(parts):
        return ", ".join(sorted(dialect))
    return f"begins with {parts[0]}" if len(parts) > 1 and parts[0] in FIRST else None


def find_turns_in_code(code: str) -> Iterator[tuple[int, str]]:
    """Of comments, docstrings and messages."""
    # Most files have none, and tokens take much longer
    if not TURN.search(code):
        return
    texts = {tokenize.COMMENT, tokenize.STRING, getattr(tokenize, "FSTRING_MIDDLE", tokenize.STRING)}
    for token in tokenize.generate_tokens(io.StringIO(code).readline):
        if token.type in texts:
            yield from find_turns(token.string, token.start[0])


def find_turns(text: str, first_line: int) -> Iterator[tuple[int, str]]:
    for match in TURN.finditer(text):
        yield first_line + text[: match.start()].count("\n"), f"turn {match.group()!r}"


@pytest.mark.slow
@pytest.mark.parametrize("folder", ["src", "docs", "tests", "training", "benchmarks", "fuzzing", "README.md"])
def test_the_words_are_those_of_the_field(folder):
    files = list_files(ROOT / folder)
    assert files
    assert [fault for file in files for fault in find_faults(file)] == []


@pytest.mark.parametrize(
    ("code", "faults"),
    [
        ("found = 1", ["1: name found"]),
        ("def tell_error(of): ...", ["1: name of", "1: name tell_error"]),
        ("class JudgedFloor:\n    kind: str\n    place: int", ["1: name JudgedFloor", "3: name place"]),
        ("x = 'there are so many doors'", ["1: turn 'so many'"]),
        ('"""One.\n\nNobody knows."""\ny = 2  # is none', ["3: turn 'Nobody'", "4: turn 'is none'"]),
        ("foundation = matches = None  # is None", []),
        ("room_kinds = take = spread = 1", []),
    ],
)
def test_what_is_found(tmp_path, code, faults):
    file = tmp_path / "a.py"
    file.write_text(code)
    assert [fault.removeprefix(f"{file}:").split(" (")[0] for fault in find_faults(file)] == faults


if __name__ == "__main__":
    for file in (file for argument in sys.argv[1:] for file in list_files(Path(argument))):
        sys.stdout.writelines(f"{fault}\n" for fault in find_faults(file))
