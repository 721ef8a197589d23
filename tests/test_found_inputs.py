"""Inputs that fuzzing has found stay harmless, and a small piece of fuzzing runs as `make fuzz` runs it."""

import os
import subprocess
import sys
import warnings
from pathlib import Path

import pytest

from tests.mutation import refused_in_one_line

ROOT = Path(__file__).parents[1]
FOLDER = ROOT / "tests" / "found_inputs"
# Those that need packages which may not be installed, or networks
SLOW_TARGETS = ("commands", "ifc", "pdf", "dxf", "svg")


@pytest.fixture(scope="module")
def targets(tmp_path_factory):
    pytest.importorskip("ezdxf")
    pytest.importorskip("ifcopenshell")
    from fuzzing.targets import list_targets

    return list_targets(tmp_path_factory.mktemp("targets"))


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(file.name for file in FOLDER.iterdir()))
def test_what_was_found_is_read_or_refused_in_one_line(targets, tmp_path, name, monkeypatch):
    target = targets[name.rpartition("-")[0]]
    monkeypatch.chdir(tmp_path)
    file = tmp_path / f"input{target.suffix}"
    file.write_bytes((FOLDER / name).read_bytes())
    with refused_in_one_line(), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        target.read(file)


@pytest.mark.slow
def test_every_seed_is_read(targets, tmp_path):
    """Mutations of what is refused at once would find nothing."""
    for name, target in targets.items():
        assert target.seeds, name
        for number, seed in enumerate(target.seeds):
            if name in ("commands", "pgm"):
                continue
            file = tmp_path / f"{name}-{number}{target.suffix}"
            file.write_bytes(seed)
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                target.read(file)


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(os, "fork"), reason="this system has no limits of processes")
def test_a_piece_of_fuzzing_counts_inputs_and_keeps_what_it_finds(tmp_path):
    command = [sys.executable, str(ROOT / "fuzzing" / "fuzz.py"), "kth", "georeference", "--inputs", "40"]
    done = subprocess.run(
        [*command, "--jobs", "1", "--seed", "2", "--out", str(tmp_path / "found")],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert "0 findings" in done.stdout
    assert not list((tmp_path / "found").iterdir())
