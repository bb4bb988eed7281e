"""The stub of the extension module says what is in it."""

import ast
import inspect
from pathlib import Path

import pytest

import radiosity
from radiosity import _native

STUB = ast.parse((Path(radiosity.__file__).parent / "_native.pyi").read_text())
CLASSES = {node.name: node for node in STUB.body if isinstance(node, ast.ClassDef)}
FUNCTIONS = {node.name: node for node in STUB.body if isinstance(node, ast.FunctionDef)}
VALUES = {node.target.id for node in STUB.body if isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name)}
MODULE_FIXTURES = {"__doc__", "__file__", "__loader__", "__name__", "__package__", "__spec__", "__all__"}


def members(node: ast.ClassDef) -> dict[str, ast.FunctionDef]:
    return {f.name: f for f in node.body if isinstance(f, ast.FunctionDef) and not f.name.startswith("_")}


def parameters(node: ast.FunctionDef) -> list[str]:
    return [a.arg for a in [*node.args.posonlyargs, *node.args.args, *node.args.kwonlyargs]]


def test_names_of_the_module() -> None:
    assert set(dir(_native)) - MODULE_FIXTURES == set(CLASSES) | set(FUNCTIONS) | VALUES


@pytest.mark.parametrize("name", CLASSES)
def test_names_of_a_class(name: str) -> None:
    if issubclass(cls := getattr(_native, name), Exception):
        assert name.endswith("Error")
        return
    assert {n for n in vars(cls) if not n.startswith("_")} == set(members(CLASSES[name]))


@pytest.mark.parametrize("name", FUNCTIONS)
def test_parameters_of_a_function(name: str) -> None:
    assert list(inspect.signature(getattr(_native, name)).parameters) == parameters(FUNCTIONS[name])


@pytest.mark.parametrize(
    ("owner", "name"),
    [
        (owner, name)
        for owner, node in CLASSES.items()
        for name, method in members(node).items()
        if not method.decorator_list
    ],
)
def test_parameters_of_a_method(owner: str, name: str) -> None:
    real = inspect.signature(getattr(getattr(_native, owner), name))
    assert list(real.parameters) == parameters(members(CLASSES[owner])[name])
