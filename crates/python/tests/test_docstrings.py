"""Every public name has a docstring with an example, and every example does what it says."""

import doctest
import importlib.util
import inspect
import re

import pytest

import vibrochain as vc

# Packages, and the program, which the tests have.
NEEDS = {doctest.register_optionflag(name.upper()): name for name in ["pandas", "xarray", "matplotlib"]}
doctest.register_optionflag("MAPGEN")


def public():
    """All public functions, classes and methods by name."""
    for name in vc.__all__:
        thing = getattr(vc, name)
        yield name, thing
        if inspect.isclass(thing) and not issubclass(thing, Exception):
            for inner in vars(thing):
                method = getattr(thing, inner)
                if not inner.startswith("_") and callable(method):
                    yield f"{name}.{inner}", method


ALL = dict(public())


def test_all_is_all():
    assert len(ALL) > 40
    shown = {name for name, value in vars(vc).items() if not name.startswith("_") and not inspect.ismodule(value)}
    assert shown == set(vc.__all__)


@pytest.mark.parametrize("name", ALL)
def test_example(name, monkeypatch, mapgen):
    thing = ALL[name]
    monkeypatch.setenv("MAPGEN", str(mapgen))
    text = inspect.getdoc(thing)
    assert text, f"{name} has no docstring"
    if inspect.isclass(thing) and issubclass(thing, Exception):
        return
    if importlib.util.find_spec("matplotlib"):
        monkeypatch.setenv("MPLBACKEND", "Agg")
    around, known = ALL[name.split(".")[0]], {}
    if around is not thing and "import vibrochain" not in text:
        # It goes on from that of its class.
        before = doctest.DocTestParser().get_doctest(inspect.getdoc(around), known, name, None, None)
        doctest.DocTestRunner(optionflags=doctest.NORMALIZE_WHITESPACE).run(before, clear_globs=False)
        known = before.globs
    test = doctest.DocTestParser().get_doctest(text, known, name, None, None)
    assert test.examples, f"{name} has no example"
    missing = {need for flag, need in NEEDS.items() if not importlib.util.find_spec(need)}
    kept = [each for each in test.examples if not any(NEEDS.get(flag) in missing for flag in each.options)]
    if kept != test.examples:
        print(f"{name}: part of its example is left out, {', '.join(sorted(missing))} not installed")
    test.examples = kept
    said = []
    results = doctest.DocTestRunner(optionflags=doctest.NORMALIZE_WHITESPACE).run(test, out=said.append)
    assert results.attempted == len(kept) and not results.failed, "".join(said)


def takes(thing):
    """Names of the arguments of a function or method, or of what makes a class that users make."""
    if inspect.isclass(thing) and (thing.__name__ not in MADE or issubclass(thing, Exception)):
        return []
    try:
        parameters = inspect.signature(thing).parameters.values()
    except ValueError:
        return []
    return [each.name for each in parameters if each.name not in ("self", "cls")]


# Classes that users make themselves; all others come from functions.
MADE = ["Chain", "Contact", "Force", "Model", "Structure"]


@pytest.mark.parametrize("name", ALL)
def test_arguments_and_returns_are_described(name):
    """Each argument stands in the docstring with its type, and what comes back with its own."""
    thing = ALL[name]
    text = inspect.getdoc(thing)
    listed = re.findall(r"^([\w*, ]+) : ", text, re.MULTILINE)
    told = {each.strip("* ") for names in listed for each in names.split(",")}
    missing = [each for each in takes(thing) if each not in told]
    assert not missing, f"{name}: {missing}"
    if not inspect.isclass(thing) and name not in ("Explorer.close",):
        assert "Returns\n-------\n" in text, f"{name} does not say what it returns"


@pytest.mark.parametrize("name", [name for name, thing in ALL.items() if inspect.isclass(thing)])
def test_attributes_are_described(name):
    """Properties say their type before a colon."""
    thing = ALL[name]
    properties = {key: value for key, value in vars(thing).items() if inspect.isdatadescriptor(value)}
    for key, value in properties.items():
        if not key.startswith("__"):
            assert value.__doc__ and " : " in value.__doc__, f"{name}.{key}: {value.__doc__}"
