"""Build wheels and sdists of pianta and pianta-bench into dist/, check them, and try them in an empty environment.

Run by `make dist`.

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
# Folders with a pyproject.toml, and the packages in each.
PROJECTS = {ROOT: "src/pianta", ROOT / "src" / "pianta_bench": "src/pianta_bench"}
MAX_MEGABYTES = 25  # of each file
RESULTS = {"floor.geojson", "graph.json", "grid.npz", "picture.png", "rooms.png"}
# What a build adds to the files of the repository.
ADDED = {"PKG-INFO", ".gitignore", "pyproject.toml"}
# Files in the folder of a package that build it, and that a wheel does not have.
BUILDING = {"pyproject.toml", "README.md"}


def main() -> int:
    """Build, check and try; the exit code is 1 if a check fails."""
    shutil.rmtree(DIST, ignore_errors=True)
    faults: list[str] = []
    for project, package in PROJECTS.items():
        name = tomllib.loads((project / "pyproject.toml").read_text(encoding="utf-8"))["project"]["name"]
        run(sys.executable, "-m", "build", "--outdir", DIST, project)
        pattern = name.replace("-", "_")
        (wheel,), (sdist,) = [*DIST.glob(f"{pattern}-*.whl")], [*DIST.glob(f"{pattern}-*.tar.gz")]
        run(sys.executable, "-m", "twine", "check", "--strict", wheel, sdist)
        faults += [*check_size(wheel), *check_size(sdist), *check_wheel(wheel, package)]
        faults += check_sdist(sdist, package, project)
    for fault in faults:
        sys.stderr.write(f"{fault}\n")
    if not faults:
        try_wheels()
    return bool(faults)


def run(*command: object, **options: object) -> str:
    """What a command prints; it is printed here too, and a command that fails stops the script."""
    print("$", *command, flush=True)
    words = [str(word) for word in command]
    done = subprocess.run(words, check=False, text=True, stdout=subprocess.PIPE, **options)  # type: ignore[call-overload]
    print(done.stdout, flush=True)
    if done.returncode:
        sys.exit(done.returncode)
    return str(done.stdout)


def check_size(path: Path) -> list[str]:
    """A line if a file is too large."""
    megabytes = path.stat().st_size / 1e6
    print(f"{path.name}: {megabytes:.1f} MB")
    return [f"{path.name} has {megabytes:.1f} MB, {MAX_MEGABYTES} are allowed"] * (megabytes > MAX_MEGABYTES)


def check_wheel(path: Path, package: str) -> list[str]:
    """A wheel has what git knows of its package, but for what only builds it, and nothing else."""
    with zipfile.ZipFile(path) as archive:
        names = {name for name in archive.namelist() if not PurePosixPath(name).parts[0].endswith(".dist-info")}
    show_contents(path, names)
    building = {f"{package}/{name}" for name in BUILDING}
    expected = {name.removeprefix("src/") for name in list_tracked(package) if name not in building}
    faults = compare(path, names, expected)
    tests = sorted(name for name in names if {"tests", "docs"} & {*PurePosixPath(name).parts})
    return [*faults, *(f"{path.name} has {name}" for name in tests)]


def check_sdist(path: Path, package: str, project: Path) -> list[str]:
    """A sdist has all sources and models of its package, no tests, and nothing that git does not know."""
    with tarfile.open(path) as archive:
        names = {name.partition("/")[2] for name in archive.getnames() if not archive.getmember(name).isdir()}
    show_contents(path, names)
    prefix = "" if project == ROOT else f"{project.relative_to(ROOT).as_posix()}/"
    tracked = {name.removeprefix(prefix) for name in list_tracked() if name.startswith(prefix)}
    sources = {name.removeprefix(prefix) for name in list_tracked(package)}
    faults = [f"{path.name} has {name}, which git does not know" for name in sorted(names - tracked - ADDED)]
    faults += [f"{path.name} lacks {name}" for name in sorted(sources - names)]
    return faults + [f"{path.name} has {name}" for name in sorted(names) if name.startswith("tests/")]


def show_contents(path: Path, names: set[str]) -> None:
    """Print the number of files by folder."""
    counts = Counter("/".join(PurePosixPath(name).parts[:2]) for name in names)
    lines = [f"  {count:4} {folder}" for folder, count in sorted(counts.items())]
    print(f"{path.name}: {len(names)} files", *lines, sep="\n", flush=True)


def compare(path: Path, names: set[str], expected: set[str]) -> list[str]:
    """A line for each file that is missing or not expected."""
    lacks = [f"{path.name} lacks {name}" for name in sorted(expected - names)]
    return lacks + [f"{path.name} has {name}, which git does not know" for name in sorted(names - expected)]


def list_tracked(folder: str = ".") -> list[str]:
    """The files of a folder that git knows."""
    listed = subprocess.run(["git", "ls-files", folder], cwd=ROOT, check=True, text=True, stdout=subprocess.PIPE)  # noqa: S607
    return listed.stdout.splitlines()


def try_wheels() -> None:
    """Install pianta into an empty environment and read the sample outside of the repository; then add its benches."""
    version = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["version"]
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    with TemporaryDirectory() as name:
        folder = Path(name)
        venv.create(folder / "venv", with_pip=True)
        binaries = folder / "venv" / "bin"
        install = (binaries / "python", "-m", "pip", "install", "--quiet", "--find-links", DIST)
        run(*install, f"pianta=={version}", cwd=folder, env=environment)
        printed = run(binaries / "pianta", "--version", cwd=folder, env=environment)
        if printed.split()[-1] != version:
            sys.exit(f"pianta --version prints {printed.strip()!r}, expected {version}")
        run(binaries / "pianta", "world", "sample", "-o", "demo", cwd=folder, env=environment)
        run(binaries / "pianta", "read", "demo/map.yaml", "-o", "building", cwd=folder, env=environment)
        written = {path.name for path in (folder / "building").iterdir()}
        if written != RESULTS:
            sys.exit(f"pianta read wrote {sorted(written)}, expected {sorted(RESULTS)}")
        run(*install, f"pianta[bench]=={version}", cwd=folder, env=environment)
        if "segmentation" not in run(binaries / "pianta", "bench", "--help", cwd=folder, env=environment):
            sys.exit("pianta bench --help does not list its benches")
    print("pianta and its benches work in an empty environment")


if __name__ == "__main__":
    sys.exit(main())
