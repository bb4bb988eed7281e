"""The gallery's page says what makes its pictures, and that can be run."""

from __future__ import annotations

import importlib.util
import shlex
import sys
from pathlib import Path
from types import ModuleType

import pytest
import typer
from PIL import Image

from radiosity.cli.app import app

FOLDER = Path(__file__).parents[1] / "docs" / "gallery"


def script() -> ModuleType:
    """The script that makes the gallery, as a module."""
    spec = importlib.util.spec_from_file_location("gallery_make", FOLDER / "make.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


MAKE = script()


def test_the_page_is_that_of_the_script() -> None:
    assert (FOLDER / "README.md").read_text() == MAKE.readme()
    names = [picture.name for picture in MAKE.PICTURES]
    assert len(set(names)) == len(names)


@pytest.mark.parametrize("picture", MAKE.PICTURES, ids=lambda picture: picture.name)
def test_a_picture_is_there_and_its_command_is_one(picture: object) -> None:
    program, name, *arguments = shlex.split(picture.line)
    assert program == "radiosity"
    # Refuses what the command does not know.
    typer.main.get_command(app).commands[name].make_context(name, arguments)
    file = FOLDER / picture.file
    assert file.stat().st_size <= MAKE.LARGEST
    with Image.open(file) as image:
        assert max(image.size) <= 1024
