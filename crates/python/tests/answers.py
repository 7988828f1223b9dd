"""JSON of the program, held against the schema that it names where the package jsonschema is there."""

import functools
import json
import subprocess

try:
    import jsonschema
except ImportError:
    jsonschema = None


@functools.lru_cache(maxsize=None)
def validator(mapgen, name):
    schema = json.loads(subprocess.run([mapgen, "schema", name], capture_output=True, check=True).stdout)
    jsonschema.Draft202012Validator.check_schema(schema)
    return jsonschema.Draft202012Validator(schema)


def written(mapgen, text):
    """The value of what the program has written."""
    value = json.loads(text)
    identity = next(iter(value.items()))
    assert identity[0] == "schema", identity
    _, project, name, _ = identity[1].split(":")
    assert project == "vibrochain"
    if jsonschema:
        validator(mapgen, name).validate(value)
    return value
