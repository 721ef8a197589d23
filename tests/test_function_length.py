"""Functions stay short: what a function does fits on half a screen."""

import ast
from pathlib import Path

import pianta

PACKAGE = Path(pianta.__file__).parent
# Lines of a body, docstring and signature not counted.
LONGEST = 40


def measure_bodies() -> dict[str, int]:
    """Lines of the body of each function, by file and name."""
    lines = {}
    for file in sorted(PACKAGE.rglob("*.py")):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
                body = node.body[1:] if ast.get_docstring(node, clean=False) is not None else node.body
                if body:
                    last = body[-1].end_lineno or body[-1].lineno
                    lines[f"{file.relative_to(PACKAGE)}:{node.lineno} {node.name}"] = last - body[0].lineno + 1
    return lines


def test_no_function_is_longer_than_half_a_screen() -> None:
    lines = measure_bodies()
    assert len(lines) > 2000
    assert {name: length for name, length in lines.items() if length > LONGEST} == {}
