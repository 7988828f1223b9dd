"""The schemas are schemas, by a library that shares nothing with the program's own tests, and scenes of the package have their form."""

import copy
import json
import subprocess

import pytest

import vibrochain as vc

from answers import validator, written

jsonschema = pytest.importorskip("jsonschema")


def told(mapgen, *words):
    return subprocess.run([mapgen, *words], capture_output=True, text=True, check=True).stdout


def objects(value):
    """Every object of a value; entries of lists are of one kind, the first is enough."""
    if isinstance(value, dict):
        yield value
        for each in value.values():
            yield from objects(each)
    elif isinstance(value, list) and value:
        yield from objects(value[0])


def test_schemas_are_schemas(mapgen):
    names = [line.split()[0] for line in told(mapgen, "schema").splitlines()]
    assert len(names) >= 12
    for name in names:
        assert validator(mapgen, name).schema["$id"] == f"urn:vibrochain:{name}:1"


MODEL = "--sites 21 --gamma1 .2 --gamma2 .1 --omega 1.07 --asymmetry .8 --amplitude .165 --restitution .25 --family single-sided"
LINES = [
    "orbit",
    "locate --event period-doubling --free amplitude",
    "branch --free amplitude --from .155 --to .17 --switch",
    "curve --event period-doubling --free amplitude --and restitution --and-from .24 --and-to .26 --tolerance 1e-3",
    "simulate --periods 2",
]


@pytest.mark.parametrize("line", LINES)
def test_answers_have_their_form_and_with_a_key_more_or_less_have_not(line, mapgen):
    command = line.split()[0]
    value = written(mapgen, told(mapgen, *line.split(), "--json", *MODEL.split()))
    check = validator(mapgen, command)
    count = sum(1 for _ in objects(value))
    refused = 0
    for place in range(count):
        more = copy.deepcopy(value)
        list(objects(more))[place]["zzz"] = 1
        assert not check.is_valid(more)
        for key in list(objects(value))[place]:
            less = copy.deepcopy(value)
            del list(objects(less))[place][key]
            # How much work it was is told where there was some.
            if key not in ("intervals", "boxes", "starts"):
                assert not check.is_valid(less), key
                refused += 1
    assert count >= 3 and refused > 15


def test_scenes_of_the_package_have_their_form(mapgen):
    scenes = ["conservative-n20", "forced-n20", "layers-coupling", "three-parameters", "pair-in-phase"]
    for name in scenes:
        scene = vc.read_scene(f"scenes/{name}.toml")
        validator(mapgen, "scene").validate(scene)
        assert not validator(mapgen, "scene").is_valid({**scene, "zzz": 1})
        assert json.loads(json.dumps(scene)) == scene
