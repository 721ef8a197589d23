"""`pianta view` as a user runs it."""

import json
import os
import re
import shutil
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from time import monotonic, sleep
from typing import Any

import pytest

import pianta.cli.view
from pianta.errors import OptionError
from pianta.view.export import DATA_ID, PREFIX, STATIC, escape_script
from pianta.view.folders import MAX_FOLDERS, find_folders
from tests.command_line import list_files, run_pianta
from tests.served_floors import FLOOR, Client, write_folder

pytest.importorskip("fastapi", reason="install pianta[web] to test the server")

ROOT = Path(__file__).parents[1]


@pytest.fixture(scope="module")
def building(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_folder(tmp_path_factory.mktemp("folders") / "building")


@pytest.fixture
def taken_port() -> Iterator[int]:
    with socket.socket() as other:
        other.bind(("127.0.0.1", 0))
        other.listen()
        yield other.getsockname()[1]


def read_data(report: Path) -> list[dict[str, Any]]:
    """The floors in a report."""
    text = report.read_text(encoding="utf-8")
    (data,) = re.findall(rf'<script type="application/json" id="{DATA_ID}">(.*?)</script>', text, re.DOTALL)
    maps: list[dict[str, Any]] = json.loads(data)["maps"]
    return maps


class TestServer:
    def test_it_prints_its_address_and_ends_at_an_interrupt(self, building):
        command = [sys.executable, "-m", "pianta", "view", str(building), "--no-browser"]
        environment = {**os.environ, "PYTHONPATH": str(ROOT / "src"), "PYTHONUNBUFFERED": "1"}
        with subprocess.Popen(
            command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
        ) as process:
            assert process.stdout is not None
            line = process.stdout.readline()
            match = re.match(r"1 floor at http://127\.0\.0\.1:(\d+)/([\w-]{32})/ \(Ctrl\+C ends it\)\n", line)
            assert match, line
            client = Client(int(match[1]))
            until = monotonic() + 20
            while client.ask("GET", f"/{match[2]}/api/maps").status != 200 and monotonic() < until:
                sleep(0.1)
            assert client.ask("GET", f"/{match[2]}/api/maps").json["maps"][0]["rooms"] == 3
            assert client.ask("GET", "/api/maps").status == 404
            process.send_signal(signal.SIGINT)
            out, err = process.communicate(timeout=30)
        assert (process.returncode, out, err) == (0, "", "")

    @pytest.mark.parametrize("flags", [[], ["--no-browser"]])
    def test_the_browser_opens_at_the_address(self, building, monkeypatch, flags):
        opened: list[str] = []
        monkeypatch.setattr("pianta.view.server.open_browser", opened.append)
        monkeypatch.setattr("pianta.view.server.serve", lambda app, listener: None)
        out = run_pianta("view", building, *flags).out
        assert opened == ([] if flags else re.findall(r"http://\S+", out))

    def test_tokens_differ(self, building, monkeypatch):
        monkeypatch.setattr("pianta.view.server.serve", lambda app, listener: None)
        outs = {run_pianta("view", building, "--no-browser").out.split("/")[3] for _ in range(3)}
        assert len(outs) == 3

    def test_a_port_that_is_taken(self, building, taken_port):
        code, out, err = run_pianta("view", building, "--port", taken_port, "--no-browser")
        assert (code, out) == (2, "")
        assert err == (
            f"error: --port {taken_port} cannot be used: Address already in use; leave it out for a free one\n"
        )

    def test_a_port_that_is_free(self, building, monkeypatch, taken_port):
        ports: list[int] = []
        monkeypatch.setattr("pianta.view.server.serve", lambda app, listener: ports.append(listener.getsockname()[1]))
        with socket.socket() as other:
            other.bind(("127.0.0.1", 0))
            free = other.getsockname()[1]
        assert run_pianta("view", building, "--port", free, "--no-browser").code == 0
        assert ports == [free]

    def test_the_extra_is_missing(self, building, monkeypatch):
        monkeypatch.setattr(pianta.cli.view, "find_spec", lambda name: None)
        code, _, err = run_pianta("view", building)
        assert (code, err.count("\n")) == (2, 1)
        assert "the page needs fastapi and uvicorn, install them: pip install 'pianta[web]'" in err

    def test_the_report_needs_no_extra(self, building, tmp_path):
        """Nothing of FastAPI is imported for a report."""
        code = f"""import sys
sys.modules["fastapi"] = sys.modules["uvicorn"] = sys.modules["starlette"] = None
from pianta.cli import main
main(["view", {str(building)!r}, "--html", {str(tmp_path / "report.html")!r}])"""
        environment = {**os.environ, "PYTHONPATH": str(ROOT / "src")}
        done = subprocess.run(
            [sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=False
        )
        assert (done.returncode, done.stderr) == (0, "")

    @pytest.mark.parametrize("name", ["nothing", "empty", "file"])
    def test_a_folder_without_a_floor(self, tmp_path, name):
        (tmp_path / "empty").mkdir()
        (tmp_path / "file").write_text("text")
        code, _, err = run_pianta("view", tmp_path / name)
        assert (code, err.count("\n")) == (2, 1)
        assert f"{name}' has no floor.geojson, give a folder of `pianta read`" in err

    def test_damaged_corrections(self, building, tmp_path):
        folder = shutil.copytree(building, tmp_path / "building")
        (folder / "corrections.json").write_text("{")
        files = list_files(folder)
        for flags in (["--no-browser"], ["--html", tmp_path / "report.html"]):
            code, _, err = run_pianta("view", folder, *flags)
            assert (code, err.count("\n")) == (2, 1)
            assert "corrections.json" in err
        assert list_files(tmp_path) == {f"building/{name}": content for name, content in files.items()}


class TestFolders:
    def test_a_gallery_has_the_folders_in_a_folder_and_their_storeys(self, tmp_path):
        for name in ("b", "a", "c/floor-1", "c/floor-2"):
            write_empty(tmp_path / name)
        (tmp_path / "notes").mkdir()
        assert find_folders([tmp_path]) == {
            name: (tmp_path / name).resolve() for name in ("a", "b", "c/floor-1", "c/floor-2")
        }

    def test_names_differ(self, tmp_path):
        for name in ("x/building", "y/building", "z/other"):
            write_empty(tmp_path / name)
        folders = find_folders([tmp_path / name for name in ("x/building", "y/building", "z/other")])
        assert len(folders) == 3
        assert "other" in folders

    def test_a_folder_that_is_given_twice_is_shown_once(self, tmp_path):
        write_empty(tmp_path / "a")
        assert [*find_folders([tmp_path / "a", tmp_path, tmp_path / "a" / "floor.geojson"])] == ["a"]

    def test_the_working_directory_has_its_own_name(self, tmp_path, monkeypatch):
        write_empty(tmp_path / "here")
        monkeypatch.chdir(tmp_path / "here")
        assert [*find_folders(["."])] == ["here"]

    def test_too_many(self, tmp_path, monkeypatch):
        for name in "abc":
            write_empty(tmp_path / name)
        monkeypatch.setattr("pianta.view.folders.MAX_FOLDERS", 2)
        with pytest.raises(OptionError, match="3 floors are too many for a page, give 2 at most"):
            find_folders([tmp_path])
        assert MAX_FOLDERS > 2


def write_empty(folder: Path) -> None:
    folder.mkdir(parents=True)
    (folder / "floor.geojson").write_text("{}")


class TestReport:
    def test_a_report_has_everything_in_one_file(self, building, tmp_path):
        report = tmp_path / "report.html"
        code, out, err = run_pianta("view", building, "--html", report)
        assert (code, out, err) == (0, f"1 floor, in {report}\n", "")
        (state,) = read_data(report)
        assert (state["name"], state["writable"]) == ("building", False)
        assert state["background"]["url"].startswith("data:image/png;base64,")
        text = report.read_text(encoding="utf-8")
        assert re.findall(r'<(?:link|script|img|iframe)\b[^>]*\b(?:src|href)="(?!data:)[^"]*"', text) == []
        assert "sourceMappingURL" not in text
        assert "default-src 'none'" in text

    def test_a_report_replaces_no_floor(self, building, tmp_path):
        folder = shutil.copytree(building, tmp_path / "building")
        files = list_files(folder)
        code, _, err = run_pianta("view", folder, "--html", folder / "floor.geojson")
        assert (code, err.count("\n"), "give a name that ends in .html" in err) == (2, 1, True)
        assert list_files(folder) == files

    def test_a_report_has_the_corrections(self, building, tmp_path):
        folder = shutil.copytree(building, tmp_path / "building")
        assert run_pianta("correct", folder, "--merge", 1, 2).code == 0
        run_pianta("view", folder, "--html", tmp_path / "report.html")
        (state,) = read_data(tmp_path / "report.html")
        assert [each["kind"] for each in state["corrections"]] == ["merge"]

    def test_a_folder_of_folders_is_one_report(self, building, tmp_path):
        for name in "ab":
            shutil.copytree(building, tmp_path / "maps" / name)
        report = tmp_path / "report.html"
        assert run_pianta("view", tmp_path / "maps", building, "--html", report).out.startswith("3 floors, in ")
        assert [(state["map"], state["name"]) for state in read_data(report)] == [(0, "a"), (1, "b"), (2, "building")]

    @pytest.mark.parametrize(
        "name", ["<img src=x onerror=alert(1)>", "</script><script>alert(1)</script>", "<!--<script>", "]]>&amp;"]
    )
    def test_names_end_no_element(self, tmp_path, name):
        rooms = tuple(replace(room, name=name) for room in FLOOR)
        folder = write_folder(tmp_path / "building", replace(FLOOR, rooms=rooms, source=name))
        report = tmp_path / "report.html"
        run_pianta("view", folder, "--html", report)
        assert name not in report.read_text(encoding="utf-8")
        (state,) = read_data(report)
        assert state["floor"]["features"][0]["properties"]["name"] == name

    def test_scripts_are_as_in_the_page(self, building, tmp_path):
        """Each script of the page is in the report, and modules name each other by the import map."""
        report = tmp_path / "report.html"
        run_pianta("view", building, "--html", report)
        text = report.read_text(encoding="utf-8")
        page = (STATIC / "index.html").read_text(encoding="utf-8")
        for name in re.findall(r'<script[^>]*src="static/([\w.-]+)"', page):
            lines = escape_script((STATIC / name).read_text(encoding="utf-8")).splitlines()
            assert max(lines, key=len) in text
        (modules,) = re.findall(r'<script type="importmap">(.*?)</script>', text)
        named = set(re.findall(rf"""from ["']{PREFIX}([\w.-]+)["']""", text))
        assert {PREFIX + name for name in named} <= json.loads(modules)["imports"].keys()
        assert not re.search(r"""^import .*["']\./""", text, re.MULTILINE)

    def test_a_script_cannot_end_its_element(self):
        assert escape_script('a = "</script>"; b = "<!--"; 1 </script/.x') == (
            'a = "\\x3c/script>"; b = "\\x3c!--"; 1 \\x3c/script/.x'
        )

    def test_a_file_that_cannot_be_written(self, building, tmp_path):
        (tmp_path / "folder").mkdir()
        for name in ("folder", "folder/file/report.html"):
            (tmp_path / "folder" / "file").write_text("text")
            code, _, err = run_pianta("view", building, "--html", tmp_path / name)
            assert (code, err.count("\n")) == (2, 1)
            assert str(tmp_path) in err

    @pytest.mark.parametrize("flags", [["--port", "8080"], ["--no-browser"]])
    def test_options_of_the_server_are_not_for_a_report(self, building, tmp_path, flags):
        code, _, err = run_pianta("view", building, "--html", tmp_path / "report.html", *flags)
        assert (code, "leave out --port and --no-browser" in err) == (2, True)
        assert not (tmp_path / "report.html").exists()
