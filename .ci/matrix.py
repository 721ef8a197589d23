"""Run tests with other versions: Python 3.11 to 3.13, and the lowest versions of all dependencies.

    python .ci/matrix.py [3.11] [3.12] [3.13] [lowest]
    python .ci/matrix.py --turn    one of 3.12, 3.13 and lowest, and a fifth of the files of tests, by the number of
                                   commits: all take too long in CI

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
TURN = "--turn"
SHARES = 5  # of the files of tests, of which a turn runs one
# Of the tests, in their newest versions: the tests themselves are not for others
TEST_PACKAGES = ("hypothesis", "lxml", "numpydoc", "playwright", "psutil", "pytest", "pytest-xdist")

TESTS = (
    *("-q", "-n", "auto", "-m", "not slow and not data", "-p", "no:cacheprovider", "-p", "first_cases"),
    *(f"--ignore-glob=*test_{name}*" for name in ("bench", "notebook", "view")),
)


def main() -> int:
    """Run what is asked for; the exit code is 1 if tests fail."""
    failed = []
    names, share = sys.argv[1:] or [*VERSIONS, LOWEST], "1/1"
    chosen = names
    if names == [TURN]:
        chosen, share = choose_by_turn()
    for name in chosen:
        interpreter = find_interpreter(VERSIONS[0] if name == LOWEST else name)
        if interpreter is None:
            sys.stdout.write(f"{name}: skipped, no such Python is at hand\n")
            continue
        with TemporaryDirectory(prefix="pianta-matrix-") as folder:
            try:
                install_all = install_lowest if name == LOWEST else install
                python = install_all(interpreter, Path(folder))
            except subprocess.CalledProcessError:
                if names != [TURN]:
                    raise
                sys.stdout.write(f"{name}: skipped, its packages cannot be installed\n")
                continue
            variables = os.environ | {
                "OMP_NUM_THREADS": "1",
                "PYTHONPATH": str(Path(__file__).parent),
                "TEST_SHARE": share,
            }
            done = subprocess.run([str(python), "-m", "pytest", *TESTS], cwd=ROOT, env=variables, check=False)
        sys.stdout.write(f"{name}, {share} of the files: {'passed' if done.returncode == 0 else 'FAILED'}\n")
        failed += [name] * (done.returncode != 0)
    return 1 if failed else 0


def choose_by_turn() -> tuple[list[str], str]:
    """One of all versions but the oldest, with which all tests are run, and the share of the files, such as 2/3."""
    command = ["git", "rev-list", "--count", "HEAD"]
    printed = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False).stdout.strip()
    others = (*VERSIONS[1:], LOWEST)
    round_number, turn = divmod(int(printed or 0), len(others))
    return [others[turn]], f"{round_number % SHARES + 1}/{SHARES}"


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
