"""Build wheel and sdist into dist/, check them, and try the wheel in an empty environment: `make dist`.

docs/develop/release.md says what is checked.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tarfile
import tomllib
import venv
import zipfile
from collections import Counter
from pathlib import Path, PurePosixPath
from tempfile import TemporaryDirectory

ROOT = Path(__file__).parents[1]
DIST = ROOT / "dist"
MAX_MEGABYTES = 25
RESULTS = {"floor.geojson", "graph.json", "picture.png", "rooms.png"}
# What a build adds to the files of the repository.
ADDED = {"PKG-INFO", ".gitignore", "pyproject.toml"}


def main() -> int:
    """Build, check and try; the exit code is 1 if a check fails."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    shutil.rmtree(DIST, ignore_errors=True)
    run(sys.executable, "-m", "build", "--outdir", DIST, ROOT)
    (wheel,), (sdist,) = [*DIST.glob("*.whl")], [*DIST.glob("*.tar.gz")]
    run(sys.executable, "-m", "twine", "check", "--strict", wheel, sdist)
    packages = project["tool"]["hatch"]["build"]["targets"]["wheel"]["packages"]
    faults = [*check_size(wheel), *check_size(sdist), *check_wheel(wheel, packages), *check_sdist(sdist)]
    for fault in faults:
        sys.stderr.write(f"{fault}\n")
    if not faults:
        try_wheel(wheel, version=project["project"]["version"])
    return bool(faults)


def run(*command: object, **options: object) -> str:
    """What a command prints; it is printed here too, and a command that fails stops the script."""
    print("$", *command, flush=True)  # noqa: T201
    words = [str(word) for word in command]
    done = subprocess.run(words, check=False, text=True, stdout=subprocess.PIPE, **options)  # type: ignore[call-overload] # noqa: S603
    print(done.stdout, flush=True)  # noqa: T201
    if done.returncode:
        sys.exit(done.returncode)
    return str(done.stdout)


def check_size(path: Path) -> list[str]:
    """A line if a file is too large."""
    megabytes = path.stat().st_size / 1e6
    print(f"{path.name}: {megabytes:.1f} MB")  # noqa: T201
    return [f"{path.name} has {megabytes:.1f} MB, {MAX_MEGABYTES} are allowed"] * (megabytes > MAX_MEGABYTES)


def check_wheel(path: Path, packages: list[str]) -> list[str]:
    """A wheel has what git knows of its packages, and nothing else."""
    with zipfile.ZipFile(path) as archive:
        names = {name for name in archive.namelist() if not PurePosixPath(name).parts[0].endswith(".dist-info")}
    show_contents(path, names)
    expected = {name.removeprefix("src/") for package in packages for name in list_tracked(package)}
    faults = compare(path, names, expected)
    tests = sorted(name for name in names if {"tests", "docs"} & {*PurePosixPath(name).parts})
    return [*faults, *(f"{path.name} has {name}" for name in tests)]


def check_sdist(path: Path) -> list[str]:
    """A sdist has all sources and models, no tests, and nothing that git does not know."""
    with tarfile.open(path) as archive:
        names = {name.partition("/")[2] for name in archive.getnames() if not archive.getmember(name).isdir()}
    show_contents(path, names)
    tracked = {*list_tracked()}
    faults = [f"{path.name} has {name}, which git does not know" for name in sorted(names - tracked - ADDED)]
    faults += [f"{path.name} lacks {name}" for name in list_tracked("src") if name not in names]
    return faults + [f"{path.name} has {name}" for name in sorted(names) if name.startswith("tests/")]


def show_contents(path: Path, names: set[str]) -> None:
    """Print the number of files by folder."""
    counts = Counter("/".join(PurePosixPath(name).parts[:2]) for name in names)
    lines = [f"  {count:4} {folder}" for folder, count in sorted(counts.items())]
    print(f"{path.name}: {len(names)} files", *lines, sep="\n", flush=True)  # noqa: T201


def compare(path: Path, names: set[str], expected: set[str]) -> list[str]:
    """A line for each file that is missing or not expected."""
    lacks = [f"{path.name} lacks {name}" for name in sorted(expected - names)]
    return lacks + [f"{path.name} has {name}, which git does not know" for name in sorted(names - expected)]


def list_tracked(folder: str = ".") -> list[str]:
    """The files of a folder that git knows."""
    listed = subprocess.run(["git", "ls-files", folder], cwd=ROOT, check=True, text=True, stdout=subprocess.PIPE)  # noqa: S603, S607
    return listed.stdout.splitlines()


def try_wheel(wheel: Path, *, version: str) -> None:
    """Install a wheel into an empty environment, and read the sample from a folder outside of the repository."""
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    with TemporaryDirectory() as name:
        folder = Path(name)
        venv.create(folder / "venv", with_pip=True)
        binaries = folder / "venv" / "bin"
        run(binaries / "python", "-m", "pip", "install", "--quiet", wheel, cwd=folder, env=environment)
        printed = run(binaries / "pianta", "--version", cwd=folder, env=environment)
        if printed.split()[-1] != version:
            sys.exit(f"pianta --version prints {printed.strip()!r}, expected {version}")
        run(binaries / "pianta", "world", "sample", "-o", "demo", cwd=folder, env=environment)
        run(binaries / "pianta", "read", "demo/map.yaml", "-o", "building", cwd=folder, env=environment)
        written = {path.name for path in (folder / "building").iterdir()}
        if written != RESULTS:
            sys.exit(f"pianta read wrote {sorted(written)}, expected {sorted(RESULTS)}")
    print(f"{wheel.name} works in an empty environment")  # noqa: T201


if __name__ == "__main__":
    sys.exit(main())
