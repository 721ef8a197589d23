"""Which modules may import which: the folders of pianta have levels, and every import leads downwards."""

import ast
from functools import cache
from pathlib import Path

import networkx as nx
import pytest

import pianta

PACKAGE = Path(pianta.__file__).parent
# From the top down; docs/reference/house.md says what each one holds.
LEVELS = (
    ("__init__", "__main__"),
    ("cli",),
    ("view",),
    ("ros",),
    ("batch",),
    ("reading",),
    ("plot",),
    ("model_files",),
    ("evacuation",),
    ("exploration",),
    ("mapping",),
    ("prediction",),
    ("generation",),
    ("realism",),
    ("building_types",),
    ("relational",),
    ("patterns",),
    ("corrections",),
    ("rooms",),
    ("worlds",),
    ("plan",),
    ("layout",),
    ("evaluation",),
    ("graphs",),
    ("io",),
    ("navigation",),
    ("building",),
    ("models",),
    ("floor",),
    ("gridmap",),
    ("labels",),
    ("_arguments",),
    ("_types",),
    ("errors",),
)
# Methods of results and models that users expect there; each imports what it calls when it is called.
SHORTCUTS = {
    ("pianta.floor._floor", "pianta.io.floors"),
    ("pianta.building", "pianta.io.writers.convert"),
    ("pianta.floor._floor", "pianta.io.geodataframes"),
    ("pianta.floor._floor", "pianta.io.writers.convert"),
    ("pianta.floor._floor", "pianta.plot.floor"),
    ("pianta.floor._floor", "pianta.view.notebook"),
    ("pianta.floor._corrected", "pianta.corrections.by_id"),
    ("pianta.floor._corrected", "pianta.corrections.correct"),
    ("pianta.floor._corrected", "pianta.corrections.kinds"),
    ("pianta.evacuation.evacuation", "pianta.plot.evacuation"),
    ("pianta.gridmap", "pianta.io.maps"),
    ("pianta.gridmap", "pianta.plot.grid"),
    ("pianta.generation.type_model", "pianta.generation.type_model_file"),
    ("pianta.rooms.model", "pianta.rooms.model_file"),
    ("pianta.building_types.model", "pianta.building_types.model_file"),
}
LEVEL = {name: level for level, names in enumerate(LEVELS) for name in names}


@cache
def list_imports() -> list[tuple[str, str]]:
    """Pairs of a module and one of pianta that it imports, at its top or within a function."""
    pairs = []
    for file in sorted(PACKAGE.rglob("*.py")):
        parts = ("pianta", *file.relative_to(PACKAGE).with_suffix("").parts)
        module = ".".join(parts).removesuffix(".__init__")
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom) and node.module and node.module.startswith("pianta."):
                # A name can be a module of the package, or something in it.
                names = [f"{node.module}.{alias.name}" for alias in node.names]
                pairs += [(module, name if is_module(name) else node.module) for name in names]
    return [pair for pair in pairs if pair not in SHORTCUTS and pair[0] != "pianta"]


def is_module(name: str) -> bool:
    path = PACKAGE.joinpath(*name.split(".")[1:])
    return path.with_suffix(".py").is_file() or path.is_dir()


def test_there_is_no_circle() -> None:
    """Imports within functions count too."""
    assert len(list_imports()) > 1000
    graph = nx.DiGraph(list_imports())
    assert [sorted(circle) for circle in nx.strongly_connected_components(graph) if len(circle) > 1] == []


def test_every_folder_and_file_has_a_level() -> None:
    names = {path.stem for path in PACKAGE.iterdir() if path.suffix in {".py", ""}} - {"__init__", "__pycache__"}
    assert names <= LEVEL.keys()


def test_every_import_leads_downwards() -> None:
    upward = [
        f"{module} imports {name}"
        for module, name in list_imports()
        if LEVEL[name.split(".")[1]] < LEVEL[module.split(".")[1]]
    ]
    assert upward == []


@pytest.mark.parametrize("name", sorted({path.parent.name for path in PACKAGE.rglob("__init__.py")}))
def test_every_folder_has_a_description(name: str) -> None:
    (folder,) = {path.parent for path in PACKAGE.rglob("__init__.py") if path.parent.name == name}
    docstring = ast.get_docstring(ast.parse((folder / "__init__.py").read_text(encoding="utf-8")))
    assert docstring
    assert len(docstring) > 20


def test_the_library_does_not_need_the_benches() -> None:
    importing = [
        str(file.relative_to(PACKAGE))
        for file in sorted(PACKAGE.rglob("*.py"))
        if "pianta_bench" in file.read_text(encoding="utf-8")
    ]
    assert importing == []
