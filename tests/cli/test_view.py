"""radiosity view: pages as files, and served until Ctrl-C."""

from __future__ import annotations

import http.client
import json
import signal
import subprocess
import webbrowser
from collections.abc import Callable
from pathlib import Path

import pytest
from known import Call, Runner

from radiosity.viewer import page
from radiosity.viewer.server import Server

QUICK = ["builtin:cornell-box", "--patches", 100, "--accuracy", 0.2]

try:
    page.page()
except page.MissingPageError:
    pytestmark = pytest.mark.skip(reason="the page is not built: make viewer")


def test_a_page_is_written(run: Runner, tmp_path: Path) -> None:
    done = run("view", *QUICK, "--export", "room.html", "--layers", "--json")
    assert (done.returncode, done.stderr) == (0, "")
    said = json.loads(done.stdout)
    assert (said["outputs"], said["layers"]) == (["room.html"], ["light"])
    assert said["report"]["patches"] < 200
    assert '<script type="application/gzip" id="radiosity-scene">' in (tmp_path / "room.html").read_text()
    assert [path.name for path in tmp_path.iterdir()] == ["room.html"]


def test_a_lit_model_is_exported_as_it_is(call: Call, tmp_path: Path) -> None:
    call("solve", *QUICK, "-o", "lit.glb", "--quiet")
    assert call("view", "lit.glb", "--export", "lit.html").startswith("wrote lit.html (")
    assert (tmp_path / "lit.html").is_file()


def test_layers_of_a_lit_model_are_refused(run: Runner, tmp_path: Path) -> None:
    run("solve", *QUICK, "-o", "lit.glb")
    done = run("view", "lit.glb", "--export", "lit.html", "--layers")
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr == (
        "radiosity: lit.glb: a lit model has the light of all lamps together: for --layers, give the scene\n"
    )
    assert not (tmp_path / "lit.html").exists()


@pytest.mark.parametrize(
    ("arguments", "code", "sentence"),
    [
        (["builtin:nowhere"], 2, "there is no built-in scene 'nowhere'"),
        (["none.glb"], 3, "none.glb: "),
        ([*QUICK, "--export", "room.png"], 2, "room.png: name a file that ends in .html or .htm"),
        ([*QUICK, "--export", "no/room.html"], 2, "the folder no does not exist"),
        ([*QUICK, "--export", "room.html", "--port", 8000], 2, "leave out --port and --no-browser"),
        ([*QUICK, "--max-edge", 0.1], 2, "give only one of --max-edge, --patches and --as-is"),
        (["builtin:cornell-box", "--accuracy", 0], 2, "--accuracy must be a positive number"),
        (["builtin:cornell-box", "--light-unit", "candela"], 2, "'candela'"),
        ([*QUICK, "--max-patches", 10, "--as-is"], 2, "give only one"),
        (["builtin:cornell-box", "--as-is", "--max-patches", 10], 5, "more than --max-patches 10"),
    ],
)
def test_what_is_wrong_is_said(run: Runner, tmp_path: Path, arguments: list[object], code: int, sentence: str) -> None:
    done = run("view", *arguments)
    assert (done.returncode, done.stdout) == (code, "")
    assert sentence in done.stderr
    assert list(tmp_path.iterdir()) == []


def test_a_file_that_is_no_scene_is_refused(run: Runner, tmp_path: Path) -> None:
    (tmp_path / "bad.glb").write_bytes(b"glTF")
    assert run("view", "bad.glb").returncode == 3


def test_a_page_of_too_rough_light_is_written_all_the_same(run: Runner, tmp_path: Path) -> None:
    done = run("view", "builtin:cornell-box", "--accuracy", 0.02, "--max-patches", 400, "--export", "room.html")
    assert done.returncode == 4
    assert "raise --max-patches" in done.stderr
    assert (tmp_path / "room.html").is_file()


def test_without_a_page_nothing_is_begun(call: Call, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from radiosity.cli.failure import Stop

    monkeypatch.setattr(page, "BUNDLE", tmp_path / "none.html")
    with pytest.raises(Stop, match="installed without its viewer") as stopped:
        call("view", "builtin:cornell-box", "--export", "room.html")
    assert stopped.value.code == 2


@pytest.mark.parametrize("extra", [[], ["--json"], ["--quiet"]])
def test_it_serves_until_ctrl_c(start: Callable[..., subprocess.Popen[str]], extra: list[str]) -> None:
    process = start("view", "builtin:cornell-box", "--no-browser", *extra)
    assert process.stdout is not None
    try:
        if extra == ["--json"]:
            lines = [process.stdout.readline() for _ in range(4)]
            address = json.loads("".join(lines))["address"]
        else:
            address = process.stdout.readline().split()[-1]
        scheme, _, host, token, _ = address.split("/")
        assert scheme == "http:"
        connection = http.client.HTTPConnection(host, timeout=60)
        connection.request("GET", f"/{token}/")
        assert connection.getresponse().status == 200
        # In the middle of a solve.
        process.send_signal(signal.SIGINT)
        _, errors = process.communicate(timeout=10)
        assert (process.returncode, errors) == (130, "radiosity: interrupted\n")
    finally:
        process.kill()


def test_a_port_that_is_taken_is_said(start: Callable[..., subprocess.Popen[str]], run: Runner) -> None:
    process = start("view", *QUICK, "--no-browser", "--quiet")
    try:
        assert process.stdout is not None
        port = process.stdout.readline().split("/")[2].partition(":")[2]
        done = run("view", *QUICK, "--no-browser", "--port", port)
        assert (done.returncode, done.stdout) == (2, "")
        assert f"port {port}: Address already in use; choose another" in done.stderr
    finally:
        process.kill()


@pytest.mark.parametrize("is_found", [True, False])
def test_a_browser_is_opened_if_there_is_one(
    call: Call, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], is_found: bool
) -> None:
    opened: list[str] = []

    class Browser(webbrowser.BaseBrowser):
        def open(self, url: str, new: int = 0, autoraise: bool = True) -> bool:
            opened.append(url)
            return True

    def find() -> webbrowser.BaseBrowser:
        if not is_found:
            raise webbrowser.Error
        return Browser()

    said: list[str] = []
    monkeypatch.setattr(webbrowser, "get", find)
    monkeypatch.setattr(Server, "wait", lambda _: said.extend(capsys.readouterr()))
    call("view", *QUICK)
    out, errors = said
    assert errors == ("" if is_found else "radiosity: no browser was found: open the address in one on this machine\n")
    assert opened == ([out.split()[3]] if is_found else [])
