"""The package as it is imported."""

import subprocess
import sys

import pytest

import radiosity


def test_every_public_name_is_there() -> None:
    assert all(getattr(radiosity, name) is not None for name in radiosity.__all__)
    assert set(radiosity.__all__) <= set(dir(radiosity))
    assert set(radiosity._HOME) | {"catalogue", "diagnosis", "scenes", "teaching", "viewer"} == set(radiosity.__all__)


def test_other_names_are_not() -> None:
    with pytest.raises(AttributeError, match="no attribute 'brightness'"):
        _ = radiosity.brightness


def test_the_command_line_imports_nothing_heavy_before_it_must() -> None:
    heavy = ["numpy", "scipy", "matplotlib", "rich.progress", "starlette", "uvicorn", "websockets"]
    script = f"import sys, radiosity.cli.app; print([m for m in {heavy} if m in sys.modules])"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert done.stdout == "[]\n"


def test_the_package_imports_no_server() -> None:
    script = (
        "import sys, radiosity; radiosity.solve; radiosity.viewer; print({'starlette', 'uvicorn'} & set(sys.modules))"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert done.stdout == "set()\n"
