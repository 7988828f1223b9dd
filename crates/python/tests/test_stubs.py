"""Type stubs have what there is: every name, every property, every argument with its default."""

import ast
import inspect
import pathlib
import sys

import pytest

import vibrochain as vc
from vibrochain import _vibrochain

STUB = pathlib.Path(vc.__file__).with_name("_vibrochain.pyi")
TREE = ast.parse(STUB.read_text())


def arguments(function):
    """Names, kinds and defaults of the arguments in a stub, without self."""
    given = function.args
    places = [*given.posonlyargs, *given.args]
    defaults = [inspect.Parameter.empty] * (len(places) - len(given.defaults)) + [ast.literal_eval(d) for d in given.defaults]
    listed = [(arg.arg, False, default) for arg, default in zip(places, defaults)]
    for arg, default in zip(given.kwonlyargs, given.kw_defaults):
        listed.append((arg.arg, True, inspect.Parameter.empty if default is None else ast.literal_eval(default)))
    if given.kwarg:
        listed.append((f"**{given.kwarg.arg}", True, inspect.Parameter.empty))
    return [each for each in listed if each[0] not in ("self", "cls")]


def signature(thing):
    """The same of what there is."""
    listed = []
    for parameter in inspect.signature(thing).parameters.values():
        stars = "**" if parameter.kind is parameter.VAR_KEYWORD else ""
        only = parameter.kind in (parameter.KEYWORD_ONLY, parameter.VAR_KEYWORD)
        listed.append((stars + parameter.name, only, parameter.default))
    return [each for each in listed if each[0] != "self"]


@pytest.mark.skipif(sys.version_info < (3, 10), reason="Python tells no signatures of such classes yet")
def test_every_name_is_in_the_stub_and_no_other():
    told = {node.name: node for node in TREE.body if isinstance(node, (ast.ClassDef, ast.FunctionDef))}
    assert set(told) == {name for name in vars(_vibrochain) if not name.startswith("__")}
    compared = 0
    for name, node in told.items():
        thing = getattr(_vibrochain, name)
        if isinstance(node, ast.FunctionDef):
            assert arguments(node) == signature(thing), name
            compared += 1
            continue
        assert [base.id for base in node.bases] == [base.__name__ for base in thing.__bases__ if base is not object]
        inner = {each.name: each for each in node.body}
        public = {key for key in vars(thing) if not key.startswith("_")}
        assert {key for key in inner if not key.startswith("_")} == public, name
        for key, each in inner.items():
            is_property = any(isinstance(mark, ast.Name) and mark.id == "property" for mark in each.decorator_list)
            value = vars(thing)[key]
            assert is_property == (inspect.isdatadescriptor(value) and not key.startswith("__")), f"{name}.{key}"
            if key == "__new__":
                assert arguments(each) == signature(thing), name
                compared += 1
            elif not is_property and not key.startswith("__"):
                assert arguments(each) == signature(getattr(thing, key)), f"{name}.{key}"
                compared += 1
    assert compared > 15
