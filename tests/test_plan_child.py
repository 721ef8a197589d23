"""Readers of plans in a child process: what it answers, how it is bounded, and how it ends."""

import os
import pickle
import subprocess
import sys
from io import BytesIO
from pathlib import Path

import ezdxf
import numpy as np
import pytest

import pianta
from pianta.errors import PlanError, PlanWarning
from pianta.io.drawings import _child
from pianta.io.drawings._child import BoundedReader, _Answer, _AnswerUnpickler, read_in_child
from pianta.io.drawings._drawing import LayerChoice, PlanDrawing
from pianta.io.drawings.dxf import read_dxf_plan
from pianta.io.drawings.svg import read_svg_plan
from tests.ifc_models import Model

SVG = (
    "<svg xmlns='http://www.w3.org/2000/svg' width='9' height='9'><path id='wall' d='M0 0H9V9Z' stroke='black'/></svg>"
)
needs_limits = pytest.mark.skipif(not hasattr(os, "fork"), reason="this system has no limits of processes")


@pytest.fixture
def svg(tmp_path):
    path = tmp_path / "plan.svg"
    path.write_text(SVG, encoding="utf-8")
    return path


@pytest.fixture
def reader(tmp_path, monkeypatch):
    """A function that makes `read_in_child("own", …)` run the body of a function `read(path)`."""

    def make(body: str, *, seconds: int = 5) -> None:
        lines = "\n".join(f"    {line}" for line in body.splitlines())
        (tmp_path / "own_reader.py").write_text(f"def read(path):\n{lines}\n", encoding="utf-8")
        monkeypatch.syspath_prepend(tmp_path)
        monkeypatch.setattr(_child, "READERS", {"own": BoundedReader("own_reader:read", seconds, 2 * 2**30)})

    return make


def test_an_svg_is_read_as_in_this_process(svg):
    here, there = read_svg_plan(svg), read_in_child("svg", svg)
    assert isinstance(there, PlanDrawing)
    np.testing.assert_array_equal(here.lines, there.lines)
    np.testing.assert_array_equal(here.roles, there.roles)
    assert there.source == "plan.svg"


def test_a_dxf_is_read_with_its_layers(tmp_path):
    document = ezdxf.new(units=4)
    document.modelspace().add_lwpolyline([(0, 0), (4000, 0), (4000, 3000), (0, 0)], dxfattribs={"layer": "MURI"})
    document.saveas(tmp_path / "plan.dxf")
    choice = LayerChoice(walls=("muri",))
    here, there = (
        read_dxf_plan(tmp_path / "plan.dxf", layers=choice),
        read_in_child("dxf", tmp_path / "plan.dxf", layers=choice),
    )
    np.testing.assert_array_equal(here.roles, there.roles)
    assert (there.layers, there.metres_per_unit) == (here.layers, 0.001)
    with pytest.raises(PlanError, match="no layer"):
        read_in_child("dxf", tmp_path / "plan.dxf", layers=LayerChoice(walls=("none such",)))


def test_floors_of_an_ifc_come_back(tmp_path):
    model = Model()
    model.space(model.storey("Ground"), [(0, 0), (4000, 0), (4000, 3000), (0, 3000)], Name="2.04", LongName="Office")
    (here,) = model.read(tmp_path / "one.ifc")
    (there,) = read_in_child("ifc", tmp_path / "one.ifc")
    assert there.floor == here.floor
    assert (there.name, there.elevation) == (here.name, here.elevation)
    assert there.floor[1].polygon.area == pytest.approx(12)


def test_warnings_reach_the_parent(svg):
    svg.write_text(SVG.replace("<path", "<image href='a.png'/><path"), encoding="utf-8")
    with pytest.warns(PlanWarning, match="1 image"):
        read_in_child("svg", svg)


def test_errors_are_those_of_the_reader(svg):
    svg.write_text("<html/>", encoding="utf-8")
    with pytest.raises(PlanError, match="is no SVG, its outermost element is 'html'"):
        read_in_child("svg", svg)


@needs_limits
@pytest.mark.parametrize(
    ("body", "message"),
    [
        ("raise RuntimeError('x')", "makes its reader fail, RuntimeError: x; save it again, or report it"),
        ("def again(): again()\nagain()", "makes its reader fail, RecursionError"),
        ("import os, signal\nos.kill(os.getpid(), signal.SIGSEGV)", r"crashes its reader \(SIGSEGV\)"),
        ("return bytearray(3 * 2**30)", "takes more than 5 s or 2 GiB to read, give one floor"),
        ("import os\nos._exit(0)", "cannot be read in a child process"),
        ("path.with_name('w').write_text('w')", "makes its reader fail, OSError"),
        ("import socket\nsocket.create_connection(('127.0.0.1', 9))", "may not use socket"),
        ("import subprocess\nsubprocess.run(['true'])", "may not use subprocess"),
        ("import os\nos.system('true')", "may not use os.system"),
        ("import os\nreturn __import__('pianta').make_world", "cannot be read in a child process"),
    ],
    ids=["fails", "recurs", "crashes", "memory", "no answer", "writes", "network", "program", "shell", "function"],
)
def test_whatever_a_reader_does_is_one_line(svg, reader, body, message):
    reader(body)
    with pytest.raises(PlanError, match=message) as caught:
        read_in_child("own", svg)
    assert "\n" not in str(caught.value)
    assert str(caught.value).startswith(f"plan {str(svg)!r}")


@needs_limits
def test_a_reader_that_takes_too_long_is_stopped(svg, reader):
    reader("while True: pass", seconds=1)
    with pytest.raises(PlanError, match="takes more than 1 s"):
        read_in_child("own", svg)


def test_the_traceback_of_a_failure_is_a_note(svg, reader):
    reader("raise RuntimeError('x')")
    with pytest.raises(PlanError) as caught:
        read_in_child("own", svg)
    assert "own_reader.py" in caught.value.__notes__[0]


def test_the_child_has_no_environment(svg, reader, monkeypatch):
    monkeypatch.setenv("SECRET_TOKEN", "abc")
    reader("import os\nreturn sorted(os.environ)")
    names = read_in_child("own", svg)
    assert "OMP_NUM_THREADS" in names
    assert {"SECRET_TOKEN", "HOME", "PATH", "USER"}.isdisjoint(names)


def test_what_libraries_print_does_not_mix_with_the_answer(svg, reader):
    reader("import os\nprint('noise', flush=True)\nos.write(1, b'noise')\nreturn 7")
    assert read_in_child("own", svg) == 7


class _Evil:
    def __reduce__(self) -> tuple[object, ...]:
        return os.system, ("true",)


@pytest.mark.parametrize(
    "value", [_Evil(), subprocess.run, pianta.read, pianta.Room], ids=["code", "function", "of pianta", "class"]
)
def test_an_answer_holds_nothing_but_data(value):
    content = pickle.dumps(_Answer(value))
    if value is pianta.Room:
        assert _AnswerUnpickler(BytesIO(content)).load().result is pianta.Room
    else:
        with pytest.raises(pickle.UnpicklingError, match="an answer with"):
            _AnswerUnpickler(BytesIO(content)).load()


def test_deep_groups_of_an_svg_are_refused_by_read_plan(tmp_path):
    path = tmp_path / "deep.svg"
    path.write_text(SVG.replace("<path", "<g>" * 1000 + "<path").replace("</svg>", "</g>" * 1000 + "</svg>"))
    done = subprocess.run(
        [sys.executable, "-m", "pianta", "read", str(path), "-o", str(tmp_path / "o")],
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.returncode, done.stdout) == (2, "")
    assert "elements more than" in done.stderr
    assert "Traceback" not in done.stderr
    assert not Path(tmp_path / "o").exists()
