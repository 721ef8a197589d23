"""The pages of the documentation name what exists: imports, links and files."""

import ast
import importlib
import inspect
import json
import re
import tomllib
from pathlib import Path
from types import ModuleType

import pytest

import pianta
from tests.test_import_order import LEVELS
from tests.test_public_names import RESULTS

ROOT = Path(__file__).parents[1]
MODELS = ROOT / "src" / "pianta" / "models"
PAGES = [
    *(ROOT / "README.md", ROOT / "benchmarks" / "README.md", ROOT / "training" / "README.md"),
    *sorted((ROOT / "docs").rglob("*.md")),
    *sorted(MODELS.glob("*.md")),
]
NOTEBOOKS = sorted((ROOT / "docs" / "tutorials").glob("*.ipynb"))
SCRIPTS = sorted(file for folder in ("docs", "training", "benchmarks") for file in (ROOT / folder).glob("*.py"))


def relative_name(path: Path) -> str:
    return str(path.relative_to(ROOT))


def find_missing(code: str) -> list[str]:
    """Names that a code imports from pianta and that do not exist."""
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
def test_imports_of_snippets_exist(page):
    for snippet in re.findall(r"```python\n(.*?)```", page.read_text(encoding="utf-8"), re.DOTALL):
        assert find_missing(snippet) == []


@pytest.mark.parametrize("script", SCRIPTS, ids=relative_name)
def test_imports_of_scripts_exist(script):
    assert find_missing(script.read_text(encoding="utf-8")) == []


@pytest.mark.parametrize("notebook", NOTEBOOKS, ids=relative_name)
def test_imports_of_notebooks_exist(notebook):
    assert find_missing("\n".join(read_cells(notebook, "code"))) == []


@pytest.mark.parametrize("notebook", NOTEBOOKS, ids=relative_name)
def test_notebooks_have_no_outputs(notebook):
    """`make site` runs them, and shows the outputs."""
    cells = json.loads(notebook.read_text(encoding="utf-8"))["cells"]
    assert [cell for cell in cells if cell.get("outputs") or cell.get("execution_count")] == []


def read_cells(notebook: Path, cell_type: str) -> list[str]:
    cells = json.loads(notebook.read_text(encoding="utf-8"))["cells"]
    return ["".join(cell["source"]) for cell in cells if cell["cell_type"] == cell_type]


@pytest.mark.parametrize("page", [*PAGES, *NOTEBOOKS], ids=relative_name)
def test_targets_of_links_exist(page):
    is_notebook = page.suffix == ".ipynb"
    text = "\n".join(read_cells(page, "markdown")) if is_notebook else page.read_text(encoding="utf-8")
    for link in re.findall(r"\]\(([^)\s]+)\)", text):
        if link.startswith("http"):
            continue
        path, _, anchor = link.partition("#")
        target = page.parent / path if path else page
        assert target.exists(), link
        assert not anchor or anchor in anchors(target), link


@pytest.mark.parametrize("page", PAGES, ids=relative_name)
def test_files_that_a_page_names_exist(page):
    named = re.findall(r"`((?:src|tests|training|benchmarks|docs)/[\w/.-]+)`", page.read_text(encoding="utf-8"))
    assert [name for name in named if not (ROOT / name).exists()] == []


@pytest.mark.parametrize("page", PAGES, ids=relative_name)
def test_modules_that_a_page_names_exist(page):
    """A page about a method names modules without their folder."""
    modules = {
        path.name
        for folder in ("src", "tests", "training", "benchmarks", "docs")
        for path in (ROOT / folder).rglob("*.py")
    }
    named = re.findall(r"`(?:[\w/]+/)?(\w+\.py)`", page.read_text(encoding="utf-8"))
    assert [name for name in named if name not in modules] == []


def test_the_page_of_the_house_has_every_folder_in_the_order_of_imports():
    page = (ROOT / "docs" / "reference" / "house.md").read_text(encoding="utf-8")
    listed = [name.removesuffix(".py") for name in re.findall(r"^\| `([\w.]+)/?` \|", page, re.MULTILINE)]
    there = {path.stem for path in MODELS.parent.iterdir() if path.suffix in {".py", ""}} - {"__pycache__"}
    levels = [name for level in LEVELS for name in level if name in there and not name.startswith("__")]
    assert [name for name in listed if name in there] == levels


def test_readme_is_short():
    assert len((ROOT / "README.md").read_text(encoding="utf-8").split()) < 900


def test_versions_agree():
    version = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["version"]
    assert pianta.__version__ == version
    assert f"\nversion: {version}\n" in (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    bench = tomllib.loads((ROOT / "src" / "pianta_bench" / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert (bench["version"], bench["dependencies"][0]) == (version, f"pianta=={version}")
    releases = re.findall(r"^## (.+)$", (ROOT / "CHANGELOG.md").read_text(encoding="utf-8"), re.MULTILINE)
    assert releases[0] == "Unreleased"
    assert releases[1].split()[0] == version


@pytest.mark.parametrize(
    "folder", sorted({page.parent for page in PAGES if page.is_relative_to(ROOT / "docs")}), ids=relative_name
)
def test_every_page_is_in_the_site(folder):
    """Pages that no table of contents names are missing in the navigation."""
    listed = {
        name
        for page in [*folder.glob("*.md"), ROOT / "docs" / "index.md"]
        for block in re.findall(r"```{toctree}\n(.*?)```", page.read_text(encoding="utf-8"), re.DOTALL)
        for name in re.findall(r"^[\w/-]+$", block, re.MULTILINE)
    }
    pages = {page.stem for page in [*folder.glob("*.md"), *folder.glob("*.ipynb")]} - {"index"}
    assert pages <= listed


def test_the_reference_has_every_public_name():
    page = (ROOT / "docs" / "reference" / "names.md").read_text(encoding="utf-8")
    named = re.findall(r"^   (pianta\.[\w.]+)$", page, re.MULTILINE)
    public = {f"pianta.{name}" for name in pianta.__all__ if name not in {"PiantaError", "errors", "plot"}}
    public |= {f"pianta.plot.{name}" for name in pianta.plot.__all__}
    public |= {f"pianta.errors.{name}" for name, value in vars(pianta.errors).items() if inspect.isclass(value)}
    public |= {f"{result.__module__}.{result.__qualname__}" for result in RESULTS}
    assert sorted(named) == sorted(public)


class TestPageOfPython:
    PAGE = (ROOT / "docs" / "reference" / "api.md").read_text(encoding="utf-8")
    ROWS = re.findall(r"^\| `(\w+)(?:\((.*?)\))?` \|", PAGE, re.MULTILINE)

    def test_lists_every_public_name_once(self):
        assert sorted(name for name, _ in self.ROWS) == sorted(pianta.__all__)

    @pytest.mark.parametrize(("name", "arguments"), ROWS)
    def test_names_existing_arguments(self, name, arguments):
        public = getattr(pianta, name)
        named = [argument for argument in arguments.split(", ") if argument not in {"", "*", "…"}]
        if callable(public) and named:
            there = [*inspect.signature(public).parameters]
            assert sorted(named, key=there.index) == named

    def test_names_every_picture(self):
        assert {*re.findall(r"`(plot_\w+)`", self.PAGE)} == {*pianta.plot.__all__}
