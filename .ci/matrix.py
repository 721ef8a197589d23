"""Run tests with other versions: Python 3.11 to 3.13, and the lowest versions of all dependencies.

    python .ci/matrix.py [3.11] [3.12] [3.13] [lowest]

Interpreters are looked for on the path and in pyenv; one that is not there is skipped, with a line. The lowest versions
are those that pyproject.toml allows and that have wheels, as `uv` resolves them for the oldest interpreter. Of each
quick test the first case is run, without those of real maps, of pages in a browser and of benches.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

ROOT = Path(__file__).parents[1]
VERSIONS = ("3.11", "3.12", "3.13")
LOWEST = "lowest"
# Of the tests, in their newest versions: the tests themselves are not for others
TEST_PACKAGES = ("hypothesis", "lxml", "numpydoc", "playwright", "psutil", "pytest", "pytest-xdist")

TESTS = (
    *("-q", "-n", "auto", "-m", "not slow and not data", "-p", "no:cacheprovider", "-p", "first_cases"),
    *(f"--ignore-glob=*test_{name}*" for name in ("bench", "notebook", "view")),
)


def main() -> int:
    """Run what is asked for; the exit code is 1 if tests fail."""
    failed = []
    for name in sys.argv[1:] or (*VERSIONS, LOWEST):
        interpreter = find_interpreter(VERSIONS[0] if name == LOWEST else name)
        if interpreter is None:
            sys.stdout.write(f"{name}: skipped, no such Python is at hand\n")
            continue
        with TemporaryDirectory(prefix="pianta-matrix-") as folder:
            python = install_lowest(interpreter, Path(folder)) if name == LOWEST else install(interpreter, Path(folder))
            variables = os.environ | {"OMP_NUM_THREADS": "1", "PYTHONPATH": str(Path(__file__).parent)}
            done = subprocess.run([str(python), "-m", "pytest", *TESTS], cwd=ROOT, env=variables, check=False)
        sys.stdout.write(f"{name}: {'passed' if done.returncode == 0 else 'FAILED'}\n")
        failed += [name] * (done.returncode != 0)
    return 1 if failed else 0


def find_interpreter(version: str) -> str | None:
    """The path of an interpreter; None if it is not there."""
    on_path = shutil.which(f"python{version}")
    if on_path is not None and subprocess.run([on_path, "--version"], capture_output=True, check=False).returncode == 0:
        return on_path
    pyenv = Path(os.environ.get("PYENV_ROOT", "~/.pyenv")).expanduser() / "versions"
    return next((str(path) for path in sorted(pyenv.glob(f"{version}.*/bin/python"))), None)


def make_environment(interpreter: str, folder: Path) -> Path:
    """The Python of a new environment, which has uv: pip takes minutes longer."""
    subprocess.run([interpreter, "-m", "venv", str(folder / "env")], check=True)
    python = folder / "env" / "bin" / "python"
    subprocess.run([str(python), "-m", "pip", "install", "-q", "uv"], check=True)
    return python


def install(interpreter: str, folder: Path) -> Path:
    """The Python of an environment with the versions of constraints.txt."""
    python = make_environment(interpreter, folder)
    into = [str(python), "-m", "uv", "pip", "install", "-q", "--python", str(python), "-c", "constraints.txt"]
    subprocess.run([*into, "-e", ".[dev]", "-e", "src/pianta_bench", "psutil"], cwd=ROOT, check=True)
    return python


def install_lowest(interpreter: str, folder: Path) -> Path:
    """The Python of an environment with the lowest versions."""
    python = make_environment(interpreter, folder)
    uv, wheels = [str(python), "-m", "uv", "pip"], ["--only-binary", ":all:"]
    lowest = folder / "lowest.txt"
    chosen = ["--resolution", "lowest-direct", "--extra", "all", "--python", str(python), "-o", str(lowest)]
    subprocess.run([*uv, "compile", "-q", *wheels, *chosen, "pyproject.toml"], cwd=ROOT, check=True)
    into = [*uv, "install", "-q", "--python", str(python)]
    subprocess.run([*into, *wheels, "-r", str(lowest)], cwd=ROOT, check=True)
    subprocess.run([*into, *wheels, *TEST_PACKAGES], cwd=ROOT, check=True)
    subprocess.run([*into, "--no-deps", "-e", ".", "-e", "src/pianta_bench"], cwd=ROOT, check=True)
    return python


if __name__ == "__main__":
    sys.exit(main())
