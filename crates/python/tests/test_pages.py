"""The blocks of Python in the manual's pages run, in their order, and show what the pages say: `expression   # its repr, cut at …`."""

import ast
import importlib.util
import os
import re
import warnings

import pytest

from conftest import ROOT

PAGES = [ROOT / "docs" / "start.md", *sorted((ROOT / "docs" / "how").glob("*.md"))]
DRAWS = re.compile(r"\.plot\(|savefig")


def is_shown(told, value):
    """Whether a value is as told, where each … stands for any text."""
    parts = [re.escape(part) for part in told.split("…")]
    return re.fullmatch(".*".join(parts), repr(value), re.DOTALL) is not None


def run(source, names):
    """Runs a block, statement by statement; returns how many values it shows."""
    lines, shown = source.splitlines(), 0
    for statement in ast.parse(source).body:
        code = ast.get_source_segment(source, statement)
        if DRAWS.search(code) and importlib.util.find_spec("matplotlib") is None:
            warnings.warn(f"not run, matplotlib is not installed: {code}", stacklevel=2)
            continue
        rest = lines[statement.end_lineno - 1][statement.end_col_offset :].strip()
        if isinstance(statement, ast.Expr) and rest.startswith("# "):
            value = eval(code, names)
            assert is_shown(rest[2:], value), f"{code}: {value!r} is not {rest[2:]}"
            shown += 1
        else:
            exec(code, names)
    return shown


def test_what_is_shown_is_compared():
    assert is_shown("1.0016…", 1.00162902) and is_shown("[1, …, 3]", [1, 2, 3])
    assert not is_shown("1.0017…", 1.00162902) and not is_shown("1.0016", 1.00162902)
    with pytest.raises(AssertionError):
        run("1 + 1   # 3", {})


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_page(page, tmp_path, monkeypatch):
    text = page.read_text()
    blocks = re.findall(r"^```python\n(.*?)^```$", text, re.DOTALL | re.MULTILINE)
    assert blocks, f"{page} has no example in Python"
    os.symlink(ROOT / "scenes", tmp_path / "scenes")
    # Scenes of the page's own.
    for name, scene in re.findall(r'^```toml title="(out/.*?)"\n(.*?)^```$', text, re.DOTALL | re.MULTILINE):
        path = tmp_path / name
        path.parent.mkdir(exist_ok=True)
        path.write_text(scene)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MPLBACKEND", "Agg")
    names = {}
    shown = sum(run(block, names) for block in blocks)
    assert shown or page.stem == "pictures", f"{page} shows no value"
