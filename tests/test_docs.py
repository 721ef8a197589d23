"""The pages of the documentation name what exists: imports, links and files."""

import ast
import importlib
import inspect
import re
from pathlib import Path
from types import ModuleType

import pytest

import pianta
from tests.test_import_order import LEVELS

ROOT = Path(__file__).parents[1]
MODELS = ROOT / "src" / "pianta" / "models"
PAGES = [
    *(ROOT / "README.md", ROOT / "benchmarks" / "README.md", ROOT / "training" / "README.md"),
    *sorted((ROOT / "docs").rglob("*.md")),
    *sorted(MODELS.glob("*.md")),
]
SCRIPTS = sorted(file for folder in ("docs", "training", "benchmarks") for file in (ROOT / folder).glob("*.py"))


def relative_name(path: Path) -> str:
    return str(path.relative_to(ROOT))


def find_missing(code: str) -> list[str]:
    """What a code imports from pianta that is not there."""
    missing: list[str] = []
    for node in ast.walk(ast.parse(code)):
        if isinstance(node, ast.Import):
            for alias in node.names:
                if alias.name.partition(".")[0] == "pianta":
                    importlib.import_module(alias.name)
        elif isinstance(node, ast.ImportFrom) and str(node.module).partition(".")[0] == "pianta":
            module = importlib.import_module(str(node.module))
            missing += [f"{node.module}.{alias.name}" for alias in node.names if not has(module, alias.name)]
    return missing


def has(module: ModuleType, name: str) -> bool:
    if hasattr(module, name):
        return True
    try:
        importlib.import_module(f"{module.__name__}.{name}")
    except ModuleNotFoundError:
        return False
    return True


def anchors(page: Path) -> set[str]:
    headings = re.findall(r"^#+ (.+)$", page.read_text(encoding="utf-8"), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


@pytest.mark.parametrize("page", PAGES, ids=relative_name)
def test_snippets_import_what_is_there(page):
    for snippet in re.findall(r"```python\n(.*?)```", page.read_text(encoding="utf-8"), re.DOTALL):
        assert find_missing(snippet) == []


@pytest.mark.parametrize("script", SCRIPTS, ids=relative_name)
def test_scripts_import_what_is_there(script):
    assert find_missing(script.read_text(encoding="utf-8")) == []


@pytest.mark.parametrize("page", PAGES, ids=relative_name)
def test_links_lead_somewhere(page):
    for link in re.findall(r"\]\(([^)\s]+)\)", page.read_text(encoding="utf-8")):
        if link.startswith("http"):
            continue
        path, _, anchor = link.partition("#")
        target = page.parent / path if path else page
        assert target.exists(), link
        assert not anchor or anchor in anchors(target), link


@pytest.mark.parametrize("page", PAGES, ids=relative_name)
def test_files_that_a_page_names_are_there(page):
    named = re.findall(r"`((?:src|tests|training|benchmarks|docs)/[\w/.-]+)`", page.read_text(encoding="utf-8"))
    assert [name for name in named if not (ROOT / name).exists()] == []


def test_the_page_of_the_house_has_every_folder_in_the_order_of_imports():
    page = (ROOT / "docs" / "reference" / "house.md").read_text(encoding="utf-8")
    listed = [name.removesuffix(".py") for name in re.findall(r"^\| `([\w.]+)/?` \|", page, re.MULTILINE)]
    there = {path.stem for path in MODELS.parent.iterdir() if path.suffix in {".py", ""}} - {"__pycache__"}
    levels = [name for level in LEVELS for name in level if name in there and not name.startswith("__")]
    assert [name for name in listed if name in there] == levels


class TestPageOfPython:
    PAGE = (ROOT / "docs" / "reference" / "api.md").read_text(encoding="utf-8")
    ROWS = re.findall(r"^\| `(\w+)(?:\((.*?)\))?` \|", PAGE, re.MULTILINE)

    def test_lists_every_public_name_once(self):
        assert sorted(name for name, _ in self.ROWS) == sorted(pianta.__all__)

    @pytest.mark.parametrize(("name", "arguments"), ROWS)
    def test_names_arguments_that_are_there(self, name, arguments):
        public = getattr(pianta, name)
        named = [argument for argument in arguments.split(", ") if argument not in {"", "*", "…"}]
        if callable(public) and named:
            there = [*inspect.signature(public).parameters]
            assert sorted(named, key=there.index) == named

    def test_names_every_picture(self):
        assert {*re.findall(r"`(plot_\w+)`", self.PAGE)} == {*pianta.plot.__all__}
