"""What the shell gets to see: exit codes, one sentence on stderr, whole files or none."""

from __future__ import annotations

import json
import resource
import signal
import subprocess
import time
from collections.abc import Callable
from pathlib import Path

import pytest
from known import Runner

QUICK = ["builtin:cornell-box", "--patches", 300, "--accuracy", 0.1]
ENDLESS = ["builtin:cornell-box", "--patches", 5000, "--accuracy", 1e-6]


def test_done(run: Runner) -> None:
    done = run("solve", *QUICK)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.startswith("estimated error")


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["solve"], "Missing argument"),
        (["sovle", *QUICK], "Did you mean 'solve'?"),
        (["solve", *QUICK, "--bright"], "No such option: --bright (see radiosity solve --help)"),
        (["solve", *QUICK, "--threads", 0], "'--threads'"),
        (["solve", *QUICK, "--as-is"], "give only one of --max-edge, --patches and --as-is"),
        (["solve", *QUICK, "--accuracy", 0], "accuracy must be a positive number such as 0.01, not 0"),
        (["solve", *QUICK, "--solver", "magic"], "there is no solver 'magic'; choose one of conjugate_gradient"),
        (["solve", *QUICK, "--memory", "lots"], "'lots' is no size of memory: write a number and a unit"),
        (["solve", *QUICK, "--seed", 2**64], "'--seed'"),
        (["solve", "builtin:furnace", "--patches", 2**64], "'--patches'"),
        (["solve", "builtin:cornell-box", "--for", "sofa"], "there is no surface 'sofa' to focus on; there are "),
        (["solve", *QUICK, "--for", "floor"], "max_patches and focus are for a mesh of the engine's own"),
        (["solve", *QUICK, "--unit", "mm"], "built-in scenes are in metres: leave out --unit"),
        (["solve", "builtin:attic"], "there is no built-in scene 'attic': choose one of cornell-box, "),
        (["solve", "builtin:furnace", "--max-edge", -1], "--max-edge must be a positive number of metres, not -1"),
        (["solve", *QUICK, "-o", "lit.pdf"], "lit.pdf: name a file that ends in .glb or .npz or .vtp"),
        (["solve", *QUICK, "-o", "no/lit.npz"], "no/lit.npz: the folder no does not exist; create it"),
        (["factors", *QUICK[:3], "-o", "F.npz", "--method", "guess"], "there is no method 'guess'; choose auto"),
        (["render", *QUICK, "-o", "a.png", "--show", "heat"], "'heat' is not one of 'radiosity', 'irradiance'"),
        (["render", *QUICK, "-o", "a.png", "--exposure", "dark"], "--exposure 'dark' is neither auto nor a number"),
        (["demo", "attic"], "there is no built-in scene 'attic'"),
    ],
)
def test_bad_arguments(run: Runner, tmp_path: Path, arguments: list[object], sentence: str) -> None:
    done = run(*arguments)
    assert done.returncode == 2
    assert done.stdout == ""
    assert done.stderr.startswith("radiosity: ")
    assert done.stderr.count("\n") == 1
    assert sentence in done.stderr
    assert list(tmp_path.iterdir()) == []


UNUSABLE = [
    ("none.glb", None, "radiosity: none.glb: the file does not exist; check the path\n"),
    ("text.glb", b"hello", "radiosity: text.glb: "),
    ("dark.obj", b"o floor\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "radiosity: dark.obj: nothing in the scene emits"),
    ("bad.obj", b"o floor\nv 0 0 0\nf 1 2 3\n", "radiosity: bad.obj: "),
]
FORM_FACTORS_NEED_NO_LIGHT = ("factors", "dark.obj")


@pytest.mark.parametrize(
    ("command", "name", "content", "sentence"),
    [
        (command, *file)
        for command in ("solve", "factors", "check")
        for file in UNUSABLE
        if (command, file[0]) != FORM_FACTORS_NEED_NO_LIGHT
    ],
)
def test_bad_input(run: Runner, tmp_path: Path, command: str, name: str, content: bytes | None, sentence: str) -> None:
    if content is not None:
        (tmp_path / name).write_bytes(content)
    before = sorted(tmp_path.iterdir())
    done = run(command, name, *([] if command == "check" else ["-o", "out.npz"]))
    assert done.returncode == 3
    if command != "check":
        assert done.stdout == ""
        assert done.stderr.startswith(sentence)
        assert done.stderr.count("\n") == 1
    assert sorted(tmp_path.iterdir()) == before


def test_the_accuracy_is_not_reached(run: Runner) -> None:
    done = run("solve", *QUICK[:3], "--max-rays", 16, "--json")
    assert done.returncode == 4
    assert json.loads(done.stdout)["report"]["limited_by"] == "max_rays"
    assert done.stderr.startswith("radiosity: builtin:cornell-box: the estimated error is ")
    assert done.stderr.endswith("raise --max-rays\n")


def test_too_little_memory(run: Runner) -> None:
    done = run("solve", *QUICK, "--memory", "10kB")
    assert done.returncode == 5
    assert done.stderr.startswith("radiosity: builtin:cornell-box: ")
    assert "raise the limit or use fewer patches" in done.stderr


def test_more_patches_than_allowed(run: Runner) -> None:
    done = run("solve", "builtin:furnace", "--max-edge", 0.1, "--max-patches", 50)
    assert done.returncode == 5
    assert "patches are more than --max-patches 50" in done.stderr


def test_a_full_disk(run: Runner, tmp_path: Path) -> None:
    def full() -> None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000))

    done = run("factors", "builtin:cornell-box", "--patches", 100, "--rays", 64, "-o", "F.npz", preexec_fn=full)
    assert done.returncode == 5
    assert done.stderr == "radiosity: F.npz: File too large: free some space or write elsewhere\n"
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("patches", [5000, 2_000_000])
def test_ctrl_c(start: Callable[..., subprocess.Popen[str]], tmp_path: Path, patches: int) -> None:
    # With 2,000,000 patches the ray hierarchy is being built, which does not listen.
    process = start("solve", "builtin:cornell-box", "--patches", patches, "--accuracy", 1e-6, "-o", "lit.npz")
    time.sleep(2.5)
    assert process.poll() is None
    interrupted = time.monotonic()
    process.send_signal(signal.SIGINT)
    stdout, stderr = process.communicate(timeout=20)
    # A second, and as much again for a busy machine.
    assert time.monotonic() - interrupted < 2
    assert (process.returncode, stdout, stderr) == (130, "", "radiosity: interrupted\n")
    assert list(tmp_path.iterdir()) == []


def test_a_traceback_only_on_demand(run: Runner, monkeypatch: pytest.MonkeyPatch) -> None:
    assert "Traceback" not in run("solve", "none.glb").stderr
    monkeypatch.setenv("RADIOSITY_DEBUG", "1")
    assert "Traceback" in run("solve", "none.glb").stderr


def test_a_reader_that_has_had_enough(start: Callable[..., subprocess.Popen[str]]) -> None:
    process = start("solve", *QUICK)
    assert process.stdout is not None
    assert process.stderr is not None
    process.stdout.close()
    assert process.stderr.read() == ""
    assert process.wait(20) == 1


@pytest.mark.parametrize(
    ("limit", "remedy"),
    [
        (["--max-patches", 600], "raise --max-patches"),
        (["--time", 0.5], "raise --time-limit"),
        (["--memory", "4MB"], "raise --memory"),
    ],
)
def test_a_mesh_within_limits_is_kept_and_says_how_far_it_got(
    run: Runner, tmp_path: Path, limit: list[object], remedy: str
) -> None:
    path = tmp_path / "lit.npz"
    done = run("solve", "builtin:cornell-box", "--accuracy", 1e-3, *limit, "-o", path)
    assert done.returncode == 4
    assert "the estimated error is " in done.stderr and remedy in done.stderr
    assert path.exists()
