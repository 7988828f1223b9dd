#!/usr/bin/env python3
"""Gathers the pages of the manual for MkDocs: those of docs, and the reference, which the program and the package are asked for.

    python3 scripts/manual.py MAPGEN PAGES          where the package vibrochain is installed
"""

import ast
import html
import inspect
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys

from latex2mathml.converter import convert

ROOT = pathlib.Path(__file__).resolve().parent.parent
PROJECT = ["README.md", "CHANGELOG.md", "ARCHITECTURE.md", "CONTRIBUTING.md"]
STYLE = """\
.md-typeset figure { max-width: 100%; }
.md-typeset figure img { background: white; }
.md-typeset table:not([class]) { font-size: .7rem; }
.highlight .gp, .highlight .go { user-select: none; }
[data-md-copying] .gp, [data-md-copying] .go { display: none; }
.md-typeset math { font-size: 1.05em; overflow-x: auto; }
"""
LANGUAGES = {".rs": "rust", ".py": "python", ".jl": "julia", ".pyi": "python", ".toml": "toml", ".sh": "bash", ".json": "json", ".sbatch": "bash"}


def mathml(formula, display="inline"):
    """A formula as MathML, which browsers draw by themselves."""
    text = convert(" ".join(formula.split()), display=display)
    # What is not understood is taken over as it stands.
    if left := re.search(r"<m\w+>(\\|&#x00026;|&amp;).*", text):
        sys.exit(f"a formula that cannot be drawn: {formula}: {left[0][:80]}")
    # Within a span, as a line that begins with the element would be taken for a block of its own.
    return f"<span>{text}</span>" if display == "inline" else text


def title(path):
    """The heading of a page."""
    return re.search(r"^# (.*)$", path.read_text(), re.M)[1]


class Pages:
    """The folder of pages, and what in the project they point at."""

    def __init__(self, folder):
        self.folder = folder
        self.sources = set()

    def write(self, name, text):
        path = self.folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)

    def place(self, path):
        """Where a file of the project stands in the manual."""
        inside = path.relative_to(ROOT)
        if inside.parts[:1] == ("docs",):
            return pathlib.Path(*inside.parts[1:])
        if str(inside) in PROJECT:
            return pathlib.Path("project") / inside
        self.sources.add(path)
        return pathlib.Path("source") / inside / "index.md" if path.is_dir() else pathlib.Path("source") / f"{inside}.md"

    def page(self, path):
        """A page of the project: links lead into the manual, formulas are MathML, pictures have their words below them."""
        here = self.place(path)

        def link(match):
            words, (target, mark, anchor) = match[1], match[2].partition("#")
            if "://" in target or not target:
                return match[0]
            file = (path.parent / target).resolve()
            # A page that is named by its file has its heading there.
            words = f"[{title(file)}" if words else ""
            return f"{words}]({os.path.relpath(self.place(file), here.parent)}{mark}{anchor})"

        # What stands between backquotes is no link.
        parts = re.split(r"(^```.*?^```$|`[^`\n]*`)", path.read_text(), flags=re.M | re.S)
        parts[::2] = [re.sub(r"(\[[\w/.-]+\.md)?\]\(([^)\s]+)\)", link, part) for part in parts[::2]]
        parts[::2] = [re.sub(r"\$([^$]+)\$", lambda match: mathml(match[1]), part) for part in parts[::2]]
        text = "".join(parts)
        text = re.sub(r"^```math\n(.*?)^```$", lambda match: mathml(match[1], "block"), text, flags=re.M | re.S)
        text = re.sub(r"^```(\w+) [a-z]+$", r"```\1", text, flags=re.M)
        text = re.sub(
            r"^(!\[([^\]]+)\]\([^)]+\))$",
            lambda match: f"<figure markdown>\n{match[1]}\n<figcaption>{html.escape(match[2])}</figcaption>\n</figure>",
            text,
            flags=re.M,
        )
        self.write(here, tabs(text))

    def source(self, path):
        """A file of the project as a page, which the search leaves out."""
        head = f"---\nsearch: {{exclude: true}}\n---\n# {path.relative_to(ROOT)}\n\n"
        if path.is_dir():
            names = sorted(entry.name + "/" * entry.is_dir() for entry in path.iterdir() if not entry.name.startswith("."))
            self.write(self.place(path), head + "\n".join(f"- {name}" for name in names) + "\n")
        else:
            language = LANGUAGES.get(path.suffix, "text")
            self.write(self.place(path), f"{head}~~~~{language}\n{path.read_text()}\n~~~~\n")


def tabs(text):
    """What stands for the shell and right after it for Python becomes two tabs."""
    block = r"```(?:{})\n(?:(?!^```).)*^```$"
    pair = re.compile(f"^({block.format('console|sh')})\n\n({block.format('python')})", re.M | re.S)

    def indented(block):
        return "\n".join("    " + line if line else "" for line in block.splitlines())

    return pair.sub(lambda match: f'=== "Shell"\n\n{indented(match[1])}\n\n=== "Python"\n\n{indented(match[2])}\n', text)


def asked(mapgen, *words):
    environment = {**os.environ, "COLUMNS": "100"}
    return subprocess.run([mapgen, *words], capture_output=True, text=True, check=True, env=environment).stdout


def commands(mapgen):
    """The help of every command."""
    first = asked(mapgen, "--help")
    listed = first.split("Commands:\n")[1].split("\n\n")[0]
    names = [name for name in re.findall(r"^  (\w+)  ", listed, re.M) if name != "help"]
    assert len(names) > 10, names
    text = f"# Every command\n\nAs `mapgen COMMAND --help` prints it. `mapgen man DIR` writes the same as manual pages.\n\n## mapgen\n\n```text\n{first}```\n"
    for name in names:
        text += f"\n## {name}\n\n```text\n{asked(mapgen, name, '--help')}```\n"
    return text


def kind(rule):
    """A rule of a schema in words."""
    if rule is True or rule == {}:
        return "anything"
    if rule is False:
        return "never there"
    if "$ref" in rule:
        name = rule["$ref"].rsplit("/", 1)[1]
        return f"[{name}](#{name})"
    if "const" in rule:
        return f"`{json.dumps(rule['const'])}`"
    if "enum" in rule:
        return ", ".join(f"`{json.dumps(value)}`" for value in rule["enum"])
    for key in ("oneOf", "anyOf"):
        if key in rule and "properties" not in rule:
            return " or ".join(kind(each) for each in rule[key])
    types = rule.get("type", "object")
    types = [types] if isinstance(types, str) else types
    words = ["list of " + kind(rule["items"]) if each == "array" and isinstance(rule.get("items"), dict) else each for each in types]
    limits = [f"{sign} {rule[key]:g}" for key, sign in (("minimum", "≥"), ("exclusiveMinimum", ">"), ("maximum", "≤"), ("exclusiveMaximum", "<")) if key in rule]
    return " or ".join(words) + (", " + ", ".join(limits) if limits else "")


def keys(rule, path=""):
    """Rows of a table: each key, those of inner objects by their path."""
    for name, inner in rule.get("properties", {}).items():
        inner = inner if isinstance(inner, dict) else {}
        needed = "" if name in rule.get("required", []) else "may be absent"
        told = inner.get("description", "").replace("|", "\\|")
        yield f"| `{path}{name}` | {kind(inner)} | {'; '.join(filter(None, [told, needed]))} |"
        yield from keys(inner, f"{path}{name}.")
        if isinstance(inner.get("items"), dict):
            yield from keys(inner["items"], f"{path}{name}[].")


def table(rule):
    rows = list(keys(rule))
    return "| key | value | meaning |\n|---|---|---|\n" + "\n".join(rows) + "\n" if rows else kind(rule) + "\n"


def forms(mapgen):
    """Every key of every JSON."""
    text = "# JSON\n\nEvery key of what `mapgen` writes and reads, as `mapgen schema NAME` tells it. How to read it elsewhere: [Tables and JSON](../data.md#what-json-holds).\n"
    shared = {}
    for name in [line.split()[0] for line in asked(mapgen, "schema").splitlines()]:
        schema = json.loads(asked(mapgen, "schema", name))
        # Forms of one name that differ from schema to schema get names of their own, and so do those that contain them.
        while others := [each for each, rule in schema.get("$defs", {}).items() if shared.get(each, rule) != rule]:
            for each in others:
                schema["$defs"][f"{each}-of-{name}"] = schema["$defs"].pop(each)
                schema = json.loads(json.dumps(schema).replace(f'"#/$defs/{each}"', f'"#/$defs/{each}-of-{name}"'))
        shared.update(schema.get("$defs", {}))
        text += f"\n## Schema {name}\n\n{schema['title']}.\n\n{table(schema)}"
    for name, rule in sorted(shared.items()):
        text += f"\n### {name}\n\n{rule.get('description', '')}\n\n{table(rule)}"
    return text


def prose(text):
    """A docstring in NumPy's form as Markdown."""
    parts = re.split(r"^([A-Z]\w+)\n-+\n", text, flags=re.M)
    out = [parts[0].strip().replace("``", "`")]
    for heading, body in zip(parts[1::2], parts[2::2]):
        out.append(f"**{heading}**")
        if heading == "Examples":
            out.append(f"```pycon\n{body.strip()}\n```")
            continue
        listed = []
        for line in body.replace("``", "`").strip("\n").splitlines():
            if line and not line.startswith(" "):
                name, colon, rest = line.partition(" : ")
                listed.append(f"- `{name}`" + (f" ({rest}): " if colon else ": "))
            elif listed:
                listed.append("  " + line.strip())
        # Nothing may follow a name.
        out.append(re.sub(r": $(?!\n  )", "", "\n".join(listed), flags=re.M))
    return "\n\n".join(out) + "\n"


def call(function):
    """How a function of a stub is called; a long list of arguments has a line for each."""
    given = function.args
    places = [*given.posonlyargs, *given.args]
    defaults = [None] * (len(places) - len(given.defaults)) + given.defaults
    keywords = list(zip(given.kwonlyargs, given.kw_defaults))
    listed = [(each, default) for each, default in zip(places, defaults) if each.arg not in ("self", "cls")]
    words = [ast.unparse(each) + (f" = {ast.unparse(default)}" if default else "") for each, default in [*listed, *keywords]]
    if keywords:
        words.insert(len(listed), "*")
    if given.kwarg:
        words.append(f"**{ast.unparse(given.kwarg)}")
    returns = f" -> {ast.unparse(function.returns)}" if function.returns else ""
    line = f"({', '.join(words)}){returns}"
    return line if len(line) < 75 else "(\n    " + ",\n    ".join(words) + f",\n){returns}"


def signatures():
    """Calls as the type stubs have them, which tests hold against the package."""
    import vibrochain

    folder = pathlib.Path(vibrochain.__file__).parent
    told = {}
    for path in [*folder.glob("*.py"), *folder.glob("*.pyi")]:
        # Names of types that a reader does not have, as what they stand for.
        text = path.read_text()
        for name, words in re.findall(r"^(_\w+) = (Literal\[.*\])$", text, re.M):
            text = re.sub(rf"\b{name}\b(?! = )", words, text)
        for node in ast.parse(text).body:
            inner = node.body if isinstance(node, ast.ClassDef) else []
            for each, prefix in [(node, ""), *[(each, f"{node.name}.") for each in inner]]:
                if isinstance(each, ast.FunctionDef):
                    told[prefix + each.name] = call(each)
    return told


def package():
    """Every public name of the Python package."""
    import vibrochain

    told = signatures()
    text = "# Every Python name\n\nMade from the docstrings. Numbers are dimensionless, but for structures, whose units are yours.\n"
    for name in sorted(vibrochain.__all__, key=lambda name: (not name[0].islower(), name.endswith("Error"), name)):
        thing = getattr(vibrochain, name)
        call = told.get(f"{name}.__new__", told.get(f"{name}.__init__", "")).split(" ->")[0] if inspect.isclass(thing) else told[name]
        # What users do not make has no call.
        if inspect.isclass(thing) and "\nParameters\n" not in (inspect.getdoc(thing) or "") and not issubclass(thing, Exception):
            call = ""
        text += f"\n## {name}\n\n" + (f"```python\n{name}{call}\n```\n\n" if call else "") + prose(inspect.getdoc(thing) or "")
        if not inspect.isclass(thing) or issubclass(thing, Exception):
            continue
        rows = []
        for key, value in vars(thing).items():
            if not key.startswith("_") and inspect.isdatadescriptor(value) and value.__doc__:
                rows.append(f"| `{key}` | {' '.join(value.__doc__.split()).replace('``', '`').replace('|', chr(92) + '|')} |")
        if rows:
            text += "\n| attribute | |\n|---|---|\n" + "\n".join(rows) + "\n"
        for key, value in vars(thing).items():
            if not key.startswith("_") and callable(value):
                text += f"\n### {name}.{key}\n\n```python\n{key}{told.get(f'{name}.{key}', '()')}\n```\n\n" + prose(inspect.getdoc(value) or "")
    return text


def main(mapgen, folder):
    shutil.rmtree(folder, ignore_errors=True)
    pages = Pages(folder)
    docs = ROOT / "docs"
    for path in sorted(docs.rglob("*")):
        if path.suffix == ".md":
            pages.page(path)
        elif path.is_file():
            there = folder / path.relative_to(docs)
            there.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(path, there)
    for name in PROJECT:
        pages.page(ROOT / name)
    for path in sorted(pages.sources):
        pages.source(path)
    pages.write("reference/commands.md", commands(mapgen))
    pages.write("reference/json.md", forms(mapgen))
    pages.write("reference/python.md", package())
    pages.write("manual.css", STYLE)


if __name__ == "__main__":
    main(sys.argv[1], pathlib.Path(sys.argv[2]))
