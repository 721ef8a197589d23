"""The public interface: its names, their docstrings and their examples."""

import ast
import doctest
import inspect
import os
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import fields, is_dataclass
from functools import cached_property
from pathlib import Path
from types import FunctionType

import pytest
from numpydoc.docscrape import NumpyDocString
from numpydoc.validate import validate

import pianta
from pianta import errors, plot
from pianta.building_types.model import BuildingTypeModel
from pianta.evacuation.evacuation import DoorUse, Evacuation, WayOut
from pianta.evaluation.floor_scores import FloorScores
from pianta.exploration.record import Exploration
from pianta.generation.type_model import TypeModel
from pianta.layout.explanation import Border, Explanation
from pianta.mapping.events import Event
from pianta.navigation.cleaning import CleaningPlan, Coverage
from pianta.patterns.model_floor_plan import Chance, Motion, Occurrence, Pattern
from pianta.plan.read_plan import PlanFloor, PlanReading
from pianta.plan.sheets.sheet import PlanScale
from pianta.prediction.prediction import OpenEnd, SampleInterval
from pianta.reading.reading import StoreyReading
from pianta.realism.model import Realism
from pianta.rooms.model import RoomModel
from tests.hidden_figures import hiding_figures

SOURCE = Path(pianta.__file__)
# Results of public functions that are no public names themselves.
RESULTS = (
    Border,
    BuildingTypeModel,
    Chance,
    CleaningPlan,
    Coverage,
    DoorUse,
    Evacuation,
    Explanation,
    Exploration,
    FloorScores,
    Motion,
    Occurrence,
    OpenEnd,
    Pattern,
    RoomModel,
    PlanFloor,
    PlanReading,
    PlanScale,
    Realism,
    SampleInterval,
    StoreyReading,
    Event,
    TypeModel,
    WayOut,
)
CHECKS = {
    *("GL01", "GL02", "GL03", "GL05", "GL06", "GL07", "GL08", "GL09", "GL10"),
    *("SS01", "SS02", "SS03", "SS04", "SS05", "SS06"),
    *("PR01", "PR02", "PR03", "PR05", "PR06", "PR07", "PR08", "PR09", "PR10"),
    *("RT01", "RT02", "RT03", "RT04", "RT05", "YD01", "SA02", "SA03", "SA04"),
}
# Left out: ES01, SA01 and EX01, since one line is enough for simple functions; PR04, since types are in annotations.


def find_public() -> dict[str, object]:
    public = {f"pianta.{name}": getattr(pianta, name) for name in pianta.__all__}
    public |= {f"pianta.plot.{name}": getattr(plot, name) for name in plot.__all__}
    public |= {f"pianta.errors.{name}": value for name, value in vars(errors).items() if inspect.isclass(value)}
    return public | {result.__qualname__: result for result in RESULTS}


PUBLIC = find_public()
DOCUMENTED = [name for name, value in PUBLIC.items() if inspect.isclass(value) or inspect.isfunction(value)]


def list_members(public: object) -> Iterator[tuple[str, object]]:
    """The methods and properties of a class, by the names by which users call them."""
    for name, value in vars(public).items() if inspect.isclass(public) else ():
        is_member = isinstance(value, FunctionType | property | cached_property | classmethod)
        if is_member and not name.startswith("_"):
            yield name, value


def run_python(code: str) -> str:
    environment = {**os.environ, "PYTHONPATH": str(SOURCE.parents[1])}
    command = [sys.executable, "-W", "error", "-c", code]
    return subprocess.run(command, capture_output=True, text=True, check=True, env=environment).stdout.strip()


class TestNames:
    def test_tables_agree(self):
        (block,) = [node for node in ast.parse(SOURCE.read_text(encoding="utf-8")).body if isinstance(node, ast.If)]
        typed = {}
        for node in block.body:
            assert isinstance(node, ast.ImportFrom)
            for alias in node.names:
                module = f"{node.module}.{alias.name}" if node.module == "pianta" else str(node.module)
                typed[alias.name] = module.removeprefix("pianta.")
        assert typed == pianta._MODULES
        assert pianta.__all__ == sorted(pianta._MODULES, key=lambda name: (not name.isupper(), name.islower(), name))

    @pytest.mark.parametrize("name", pianta.__all__)
    def test_every_name_exists(self, name):
        assert hasattr(pianta, name)
        assert name in dir(pianta)

    @pytest.mark.parametrize("name", plot.__all__)
    def test_every_picture_exists(self, name):
        assert getattr(plot, name).__name__ == name
        assert name in dir(plot)

    @pytest.mark.parametrize("module", [pianta, plot])
    def test_an_unknown_name_is_an_error(self, module):
        with pytest.raises(AttributeError, match="has no attribute 'read_minds'"):
            _ = module.read_minds

    def test_a_name_is_imported_once(self):
        assert pianta.read is pianta.read
        assert "read" in vars(pianta)

    def test_import_brings_nothing_with_it(self):
        code = "import importlib, typing, sys; before = {*sys.modules}; import pianta; print({*sys.modules} - before)"
        assert run_python(code) == "{'pianta'}"

    def test_functions_are_not_hidden_by_modules(self):
        code = (
            "import pianta, pianta.reading.read; from pianta import plot; import pianta.plot.floor; "
            "print(all(map(callable, (pianta.read, pianta.Floor, plot.plot_floor))), plot is pianta.plot)"
        )
        assert run_python(code) == "True True"


class TestDocstrings:
    @pytest.mark.parametrize("name", DOCUMENTED)
    def test_they_are_numpydoc(self, name):
        public = PUBLIC[name]
        path = f"{public.__module__}.{public.__qualname__}"  # type: ignore[attr-defined]
        faults = []
        for each in (path, *(f"{path}.{member}" for member, _ in list_members(public))):
            errors_found = [(code, message) for code, message in validate(each)["errors"] if code in CHECKS]
            is_result = each == path and is_dataclass(public)
            # Fields of a result are attributes, which test_they_name_all_fields checks.
            faults += [(each, code, message) for code, message in errors_found if not (is_result and code == "PR01")]
        assert faults == []

    @pytest.mark.parametrize("name", [name for name in DOCUMENTED if is_dataclass(PUBLIC[name])])
    def test_they_name_all_fields(self, name):
        public = PUBLIC[name]
        sections = NumpyDocString(inspect.cleandoc(str(public.__doc__)))
        entries = [*sections["Parameters"], *sections["Attributes"]]
        named = [each for entry in entries for each in (entry.name or entry.type).split(", ")]
        assert named == [field.name for field in fields(public)]  # type: ignore[arg-type]

    @pytest.mark.parametrize("name", DOCUMENTED)
    @pytest.mark.usefixtures("folder")
    def test_their_examples_run(self, name):
        failures: list[str] = []
        runner = doctest.DocTestRunner(verbose=False)
        for test in doctest.DocTestFinder().find(PUBLIC[name], name, globs={}):
            runner.run(test, out=failures.append)
        assert "".join(failures) == ""

    @pytest.fixture
    def folder(self, tmp_path, monkeypatch):
        """Examples write files into the working folder, and draw on hidden figures."""
        monkeypatch.chdir(tmp_path)
        with hiding_figures():
            yield


class TestSignatures:
    @pytest.mark.parametrize("name", DOCUMENTED)
    def test_options_are_given_by_name(self, name):
        """A function has one or two positional arguments; the last may have a default."""
        public = PUBLIC[name]
        functions = [public] if inspect.isfunction(public) else [value for _, value in list_members(public)]
        for function in filter(inspect.isfunction, functions):
            positional = [
                parameter
                for parameter in inspect.signature(function).parameters.values()
                if parameter.kind is parameter.POSITIONAL_OR_KEYWORD and parameter.name != "self"
            ]
            assert len(positional) <= 2
            assert sum(parameter.default is not parameter.empty for parameter in positional) <= 1
