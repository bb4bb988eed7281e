"""Form factors in files that are mapped, and measured onto."""

from __future__ import annotations

import fcntl
import json
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from known import Runner

import radiosity
from radiosity import FormFactors, Patches, ResourceError, Scene, Surface, form_factors, scenes, solve

TOLERANCE = 1e-3
Start = Callable[..., subprocess.Popen[str]]


@pytest.fixture(scope="module")
def patches() -> Patches:
    return scenes.cornell_box().patches(count=300)


@pytest.fixture(scope="module")
def measured(patches: Patches) -> FormFactors:
    return form_factors(patches, tolerance=TOLERANCE)


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory, patches: Patches) -> Path:
    path = tmp_path_factory.mktemp("whole") / "F.exchange"
    form_factors(patches, tolerance=TOLERANCE, checkpoint=path)
    return path


def partial(path: Path) -> Path:
    return path.with_name(path.name + ".partial")


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


def is_same(a: FormFactors, b: FormFactors) -> bool:
    x = np.random.default_rng(1).random((a.shape[0], 3))
    rows = all(np.array_equal(a.row(i), b.row(i)) for i in (0, 2, -1))
    return rows and np.array_equal(a @ x, b @ x) and np.array_equal(a.toarray(), b.toarray())


def told(report: Any) -> dict[str, Any]:
    return {name: value for name, value in report.to_dict().items() if name != "seconds"}


@pytest.mark.parametrize(
    "options",
    [
        {"tolerance": TOLERANCE},
        {"method": "analytic", "tolerance": 0.01},
        {"method": "nusselt", "points": 2},
        {"method": "hemicube", "hemicubes": 1, "resolution": 64},
        {"rays": 256},
    ],
    ids=lambda o: str(o.get("method", next(iter(o)))),
)
def test_what_was_measured_onto_a_file_is_what_was_measured(tmp_path: Path, options: dict[str, Any]) -> None:
    patches = scenes.cornell_box().patches(count=100)
    path = tmp_path / "F.exchange"
    in_memory, onto = form_factors(patches, **options), form_factors(patches, **options, checkpoint=path)
    assert names(tmp_path) == ["F.exchange"]
    in_memory.save(tmp_path / "saved.exchange")
    for other in (onto, form_factors(patches, **options, checkpoint=path), FormFactors.load(path, patches, verify=True),
                  FormFactors.load(tmp_path / "saved.exchange", patches, verify=True)):  # fmt: skip
        assert is_same(in_memory, other)
        assert told(other.report) == told(in_memory.report)
        assert other.count() == in_memory.to_scipy_sparse().nnz
    if "rays" in options:
        assert (onto.standard_error() != in_memory.standard_error()).nnz == 0


def test_bytes_do_not_depend_on_threads(tmp_path: Path, patches: Patches, whole: Path) -> None:
    form_factors(patches, tolerance=TOLERANCE, threads=1, checkpoint=tmp_path / "F.exchange")
    assert (tmp_path / "F.exchange").read_bytes() == whole.read_bytes()


def test_a_file_opens_alone(patches: Patches, measured: FormFactors, whole: Path) -> None:
    alone = FormFactors.load(whole)
    assert is_same(alone, measured)
    for name in ("polygons", "surface", "face", "two_sided", "reflectance", "emission"):
        np.testing.assert_array_equal(getattr(alone.patches, name), getattr(patches, name))
    assert [s.name for s in alone.patches.scene.surfaces] == [s.name for s in patches.scene.surfaces]
    np.testing.assert_array_equal(
        solve(alone.patches, transport=alone).irradiance, solve(patches, transport=measured).irradiance
    )
    # It is what these patches would be measured onto.
    assert form_factors(alone.patches, tolerance=TOLERANCE, checkpoint=whole).report.seconds < 1


def test_obstructions_backs_and_combined_surfaces_are_kept(tmp_path: Path) -> None:
    square = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
    lift = np.array([0, 0, 1])
    surfaces = [Surface(square, [[0, 1, 2, 3]], name="a", two_sided=True), Surface(square + 2 * lift, [[3, 2, 1, 0]])]
    blocker = Surface(0.5 * np.array(square) + lift, [[0, 1, 2]], name="blocker")
    patches = Scene(surfaces, obstructions=[blocker], combined={1: 0}).patches(as_is=True)
    F = form_factors(patches, checkpoint=tmp_path / "F.exchange")
    alone = FormFactors.load(tmp_path / "F.exchange")
    assert alone.shape == (3, 3)
    assert is_same(alone, F)
    assert alone.patches.scene.combined == {1: 0}
    np.testing.assert_array_equal(alone.patches.obstructions, patches.obstructions)
    with pytest.raises(ValueError, match=r"F\.exchange: these form factors are between other patches"):
        FormFactors.load(tmp_path / "F.exchange", Scene(surfaces).patches(as_is=True))


def test_relighting_on_a_mapped_file(patches: Patches, measured: FormFactors, whole: Path) -> None:
    lit = solve(patches, transport=FormFactors.load(whole, patches))
    half = lit.relight(emission=lit.emission / 2, reflectance=lit.reflectance / 2)
    expected = solve(patches, transport=measured).relight(emission=lit.emission / 2, reflectance=lit.reflectance / 2)
    np.testing.assert_array_equal(half.irradiance, expected.irradiance)


def test_other_factors_can_be_made_of_a_mapped_file(tmp_path: Path, patches: Patches, whole: Path) -> None:
    sums = 0.5 * FormFactors.load(whole, patches).closure()
    enforced = FormFactors.load(whole, patches).enforce(sums=sums)
    np.testing.assert_allclose(enforced.closure(), sums, rtol=1e-5)
    enforced.save(tmp_path / "other.exchange")
    assert is_same(FormFactors.load(tmp_path / "other.exchange"), enforced)
    with pytest.raises(ValueError, match='method is "given" there and "auto" here'):
        form_factors(patches, tolerance=TOLERANCE, checkpoint=tmp_path / "other.exchange")


def test_damage_is_told(tmp_path: Path, whole: Path) -> None:
    path, content = tmp_path / "F.exchange", whole.read_bytes()
    rng = np.random.default_rng(2)
    for at in [0, 10, 40, 63, 64, len(content) - 1, *rng.integers(0, len(content), 40)]:
        damaged = bytearray(content)
        damaged[at] ^= 0x10
        path.write_bytes(damaged)
        with pytest.raises(ValueError, match=r"F\.exchange: "):
            FormFactors.load(path, verify=True)
    for end in [0, 1, 63, 64, 1000, len(content) - 1, *rng.integers(0, len(content), 40)]:
        path.write_bytes(content[:end])
        with pytest.raises(ValueError, match=r"F\.exchange: "):
            FormFactors.load(path)
    path.write_bytes(b"PK" + 1000 * b"x")
    with pytest.raises(ValueError, match=r"F\.exchange: this is no file of an exchange"):
        FormFactors.load(path)
    with pytest.raises(FileNotFoundError, match=r"none\.exchange"):
        FormFactors.load(tmp_path / "none.exchange")


def test_damaged_numbers_do_no_harm_where_they_are_not_verified(tmp_path: Path) -> None:
    # Plates see nothing of themselves, so that their rows are sparse: they have indices.
    path = tmp_path / "F.exchange"
    form_factors(scenes.two_plates().patches(count=60), checkpoint=path)
    content, refused = path.read_bytes(), 0
    for at in np.random.default_rng(3).integers(0, len(content), 200):
        damaged = bytearray(content)
        damaged[at] ^= 0x40
        path.write_bytes(damaged)
        try:
            F = FormFactors.load(path)
            F.closure()
            F.row(3)
            F.to_scipy_sparse()
        except ValueError as error:
            assert str(path) in str(error)
            refused += 1
    assert refused > 10


def test_a_checkpoint_of_something_else_is_refused(tmp_path: Path, patches: Patches, whole: Path) -> None:
    path = tmp_path / "F.exchange"
    path.write_bytes(whole.read_bytes())
    with pytest.raises(ValueError, match=r"F\.exchange: .*tolerance is 0\.001 there and 0\.01 here; delete it"):
        form_factors(patches, tolerance=0.01, checkpoint=path)
    with pytest.raises(ValueError, match=r"geometry is .* patches is"):
        form_factors(scenes.cornell_box().patches(count=200), tolerance=TOLERANCE, checkpoint=path)
    partial(path).write_bytes(path.read_bytes()[:-100])
    path.unlink()
    with pytest.raises(ValueError, match=r"F\.exchange\.partial: it was begun with other settings: seed is 0 there"):
        form_factors(patches, tolerance=TOLERANCE, seed=1, checkpoint=path)
    with pytest.raises(ValueError, match=r"ends in \.exchange"):
        form_factors(patches, checkpoint=tmp_path / "F.npz")


def test_it_goes_on_from_wherever_it_was_cut_off(tmp_path: Path, patches: Patches, whole: Path) -> None:
    content, path = whole.read_bytes(), tmp_path / "F.exchange"
    for share in (0, 0.001, 0.1, 0.5, 0.9, 0.999, 1):
        partial(path).write_bytes(content[: int(share * len(content))])
        F = form_factors(patches, tolerance=TOLERANCE, checkpoint=path)
        assert path.read_bytes() == content
        assert told(F.report) == told(FormFactors.load(whole).report)
        path.unlink()


def test_two_do_not_measure_onto_one_file(tmp_path: Path, patches: Patches) -> None:
    path = tmp_path / "F.exchange"
    with partial(path).open("wb") as other:
        fcntl.flock(other, fcntl.LOCK_EX)
        with pytest.raises(BlockingIOError, match="another process") as error:
            form_factors(patches, tolerance=TOLERANCE, checkpoint=path)
    assert error.value.filename == str(partial(path))
    form_factors(patches, tolerance=TOLERANCE, checkpoint=path)


MEASURE = """
import json, sys, radiosity, radiosity.factors

def peak():
    with open("/proc/self/status") as status:
        return next(int(line.split()[1]) for line in status if line.startswith("VmHWM")) * 1024

limit, path = int(sys.argv[1]), sys.argv[2]
patches = radiosity.scenes.two_plates().patches(count=6000)
patches._enclosure, patches.polygons
before = peak()
F = radiosity.form_factors(patches, tolerance=1e-3, memory_limit=limit, checkpoint=path or None)
x = F.closure(), F.count(), F.row(10)
print(json.dumps({"grown": peak() - before, "bytes": F.report.memory_bytes}))
"""


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="asks the kernel for the peak of memory")
def test_memory_stays_within_the_limit(tmp_path: Path) -> None:
    # Each side takes 6 kB of points beside its pairs.
    limit = 40_000_000

    def grown(path: object) -> dict[str, int]:
        command = [sys.executable, "-c", MEASURE, str(limit if path else 2**62), str(path)]
        done = subprocess.run(command, capture_output=True, text=True, check=True, timeout=120)
        return dict(json.loads(done.stdout))

    onto, in_memory = grown(tmp_path / "F.exchange"), grown("")
    assert in_memory["grown"] > in_memory["bytes"] > limit
    assert onto["grown"] < limit


def test_what_does_not_fit_is_refused_with_advice(tmp_path: Path, patches: Patches) -> None:
    with pytest.raises(ResourceError, match="give checkpoint="):
        form_factors(patches, tolerance=TOLERANCE, memory_limit=100_000)
    with pytest.raises(ResourceError, match="fewer threads"):
        form_factors(patches, tolerance=TOLERANCE, memory_limit=100_000, checkpoint=tmp_path / "F.exchange")
    with pytest.raises(ResourceError, match="such as auto"):
        form_factors(patches, rays=4096, memory_limit=100_000, checkpoint=tmp_path / "F.exchange")
    assert not names(tmp_path)


def test_solving_within_a_limit(patches: Patches, measured: FormFactors) -> None:
    solve(patches, transport=measured, memory_limit=10_000_000)
    with pytest.raises(ResourceError, match="limit is"):
        solve(patches, transport=measured, memory_limit=1000)


FULL = """
import resource, sys, radiosity
patches = radiosity.scenes.cornell_box().patches(count=300)
resource.setrlimit(resource.RLIMIT_FSIZE, (int(sys.argv[2]), resource.RLIM_INFINITY))
try:
    radiosity.form_factors(patches, tolerance=1e-3, checkpoint=sys.argv[1])
except OSError as error:
    print(error.errno, error.filename)
F = radiosity.form_factors(patches, tolerance=1e-3)
try:
    F.save(sys.argv[1])
except OSError as error:
    print(error.errno, error.filename)
"""


def test_a_full_disk_leaves_what_was_there_and_can_be_gone_on_with(
    tmp_path: Path, patches: Patches, whole: Path
) -> None:
    # A limit on the size of files fails in the middle of a write, as a full disk does.
    path = tmp_path / "F.exchange"
    for limit in (40, 100_000, whole.stat().st_size - 10):
        done = subprocess.run(
            [sys.executable, "-c", FULL, str(path), str(limit)], capture_output=True, text=True, check=True
        )
        assert done.stdout.splitlines() == [f"27 {partial(path)}", f"27 {path}"]
        assert names(tmp_path) == [partial(path).name]
        assert partial(path).stat().st_size <= limit
    form_factors(patches, tolerance=TOLERANCE, checkpoint=path)
    assert path.read_bytes() == whole.read_bytes()
    subprocess.run([sys.executable, "-c", FULL, str(path), "100000"], capture_output=True, check=True)
    assert path.read_bytes() == whole.read_bytes()


# The command line.

BOX = ["factors", "builtin:cornell-box", "--tolerance", "1e-4", "--patches", "1000"]


def test_solving_on_a_saved_exchange(run: Runner, tmp_path: Path) -> None:
    assert run("factors", "builtin:cornell-box", "--tolerance", "1e-3", "--patches", 200, "-o", "F.exchange",
               "-o", "F.csv", "--quiet").returncode == 0  # fmt: skip
    assert names(tmp_path) == ["F.csv", "F.exchange"]
    done = run("solve", "builtin:cornell-box", "--exchange", "F.exchange", "-o", "lit.npz", "--json")
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["report"]["patches"] == len(FormFactors.load(tmp_path / "F.exchange").patches)
    other = run("solve", "builtin:cornell-box", "--exchange", "F.exchange", "--patches", 100)
    assert (other.returncode, "F.exchange: these form factors are between other patches" in other.stderr) == (3, True)
    other = run("solve", "builtin:two-plates", "--exchange", "F.exchange")
    assert other.returncode == 3
    content = bytearray((tmp_path / "F.exchange").read_bytes())
    (tmp_path / "F.exchange").write_bytes(content[: len(content) // 2])
    damaged = run("solve", "builtin:cornell-box", "--exchange", "F.exchange")
    assert (damaged.returncode, "F.exchange: the file is truncated" in damaged.stderr) == (3, True)
    assert run("solve", "builtin:cornell-box", "--exchange", "none.exchange").returncode == 2


def test_the_limit_of_memory_on_the_command_line(run: Runner, tmp_path: Path) -> None:
    refused = run("factors", "builtin:cornell-box", "--memory", "500kB")
    assert (refused.returncode, "an output that ends in .exchange" in refused.stderr) == (5, True)
    small = ["factors", "builtin:two-plates", "--tolerance", "1e-3", "--patches", 2500, "--quiet"]
    assert run(*small, "--memory", "20MB").returncode == 5
    assert run(*small, "--memory", "20MB", "-o", "F.exchange").returncode == 0
    assert (tmp_path / "F.exchange").exists()


def blocks_arrive(path: Path, process: subprocess.Popen[str]) -> None:
    """Wait until a build has appended something."""
    begun = path.stat().st_size if path.exists() else 0
    while process.poll() is None and (not path.exists() or path.stat().st_size <= max(begun, 200_000)):
        time.sleep(0.01)


def test_ctrl_c_keeps_what_was_measured(start: Start, run: Runner, tmp_path: Path) -> None:
    process = start(*BOX, "-o", "F.exchange")
    blocks_arrive(tmp_path / "F.exchange.partial", process)
    process.send_signal(signal.SIGINT)
    _, said = process.communicate(timeout=10)
    assert process.returncode == 130
    assert "F.exchange.partial: the same command goes on from there" in said
    assert names(tmp_path) == ["F.exchange.partial"]
    again = run(*BOX, "-o", "F.exchange")
    assert (again.returncode, "going on from F.exchange.partial" in again.stderr) == (0, True)
    run(*BOX, "-o", "G.exchange", "--quiet")
    assert (tmp_path / "F.exchange").read_bytes() == (tmp_path / "G.exchange").read_bytes()


def test_kill_9_keeps_what_was_measured(start: Start, run: Runner, tmp_path: Path) -> None:
    kills = 0
    while not (tmp_path / "F.exchange").exists():
        process = start(*BOX, "-o", "F.exchange", "--quiet")
        if kills < 3:
            blocks_arrive(tmp_path / "F.exchange.partial", process)
            process.kill()
            kills += 1
        process.communicate(timeout=60)
    assert kills == 3
    run(*BOX, "-o", "G.exchange", "--quiet")
    assert (tmp_path / "F.exchange").read_bytes() == (tmp_path / "G.exchange").read_bytes()


def test_its_version_is_part_of_what_a_file_follows_from(whole: Path) -> None:
    assert f'"engine":"{radiosity.__version__}"'.encode() in whole.read_bytes()[:1000]
