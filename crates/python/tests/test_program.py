"""What the installed program does for Python: the explorer, sweeps in shares."""

import concurrent.futures
import json
import pathlib
import pickle
import subprocess
import sys
import urllib.error
import urllib.request

import pytest

import vibrochain as vc
from vibrochain._program import _program


@pytest.fixture
def small():
    scene = vc.read_scene("scenes/conservative-n20.toml")
    scene["sweep"]["x"]["points"], scene["sweep"]["y"]["points"] = 300, 250
    return scene


@pytest.fixture
def undivided(small, mapgen, tmp_path):
    """The table of one run."""
    scene, table = tmp_path / "scene.json", tmp_path / "whole.csv"
    scene.write_text(json.dumps(small))
    subprocess.run([mapgen, "sweep", scene, "--out", table, "--quiet"], check=True)
    return table.read_bytes()


def test_the_explorer_serves_until_it_is_closed(small, mapgen, monkeypatch):
    opened = []
    monkeypatch.setattr("webbrowser.open", opened.append)
    for scene in (small, "scenes/conservative-n5.toml", None):
        with vc.explore(scene, mapgen=mapgen) as explorer:
            assert opened.pop() == explorer.address and repr(explorer) == f"<Explorer at {explorer.address}>"
            page = urllib.request.urlopen(explorer.address, timeout=30).read()
            assert b"<html" in page.lower() and explorer.address in explorer._repr_html_()
            with pytest.raises(TypeError, match="a process at work"):
                pickle.dumps(explorer)
            folder = pathlib.Path(explorer._folder.name)
        assert repr(explorer) == "<Explorer, ended>" and not folder.exists()
        explorer.close()
        with pytest.raises(urllib.error.URLError):
            urllib.request.urlopen(explorer.address, timeout=5)
    assert not opened


def test_what_cannot_be_explored_is_told(mapgen, small, monkeypatch):
    with pytest.raises(vc.RequestError, match="--port 80 is that of HTTP itself"):
        vc.explore(small, port=80, browser=False, mapgen=mapgen)
    with pytest.raises(FileNotFoundError):
        vc.explore("scenes/none.toml", browser=False, mapgen=mapgen)
    monkeypatch.setenv("MAPGEN", "no-such-program")
    with pytest.raises(FileNotFoundError, match="the program no-such-program is not installed: a wheel brings it"):
        vc.explore(small, browser=False)


def test_the_program_of_a_wheel_needs_no_path(mapgen, tmp_path, monkeypatch):
    """In an environment that is not activated, and before another one on the path."""
    monkeypatch.delenv("MAPGEN", raising=False)
    for folder in ("environment", "elsewhere"):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / "mapgen").symlink_to(mapgen.resolve())
    monkeypatch.setattr("sysconfig.get_path", lambda name: str(tmp_path / "environment"))
    for path in (str(tmp_path / "none"), str(tmp_path / "elsewhere")):
        monkeypatch.setenv("PATH", path)
        assert _program() == str(tmp_path / "environment" / "mapgen")
    (tmp_path / "environment" / "mapgen").unlink()
    assert _program() == str(tmp_path / "elsewhere" / "mapgen")
    (tmp_path / "elsewhere" / "mapgen").unlink()
    with pytest.raises(FileNotFoundError, match="the program mapgen is not installed"):
        _program()


def test_shares_make_the_table_of_an_undivided_run(small, undivided, mapgen, tmp_path):
    with concurrent.futures.ThreadPoolExecutor(3) as pool:
        table = vc.sweep_shares(small, tmp_path / "map.csv", pool, shares=5, threads=1, mapgen=mapgen)
        assert pathlib.Path(table).read_bytes() == undivided
        # Once more, with what there is.
        again = vc.sweep_shares(small, tmp_path / "map.csv", pool, shares=2, threads=1, mapgen=mapgen)
        assert pathlib.Path(again).read_bytes() == undivided
        wrong = {**small, "compute": {"families": ["both"]}}
        with pytest.raises(vc.RequestError, match="both"):
            vc.sweep_shares(wrong, tmp_path / "wrong.csv", pool, shares=2, mapgen=mapgen)
        with pytest.raises(vc.RequestError, match="shares = 0 is out of range"):
            vc.sweep_shares(small, tmp_path / "map.csv", pool, shares=0, mapgen=mapgen)


def test_a_dask_cluster_takes_shares(small, undivided, mapgen, tmp_path):
    try:
        from dask.distributed import Client, LocalCluster
    except ImportError:
        sys.__stderr__.write("\nsweep_shares over Dask is NOT tested: dask[distributed] is not installed\n")
        pytest.skip("sweep_shares over Dask is not tested: dask[distributed] is not installed")
    # Workers are processes of their own.
    options = {"n_workers": 2, "threads_per_worker": 1, "processes": True, "dashboard_address": None}
    with LocalCluster(**options) as cluster, Client(cluster) as client:
        table = vc.sweep_shares(small, tmp_path / "map.csv", client, shares=4, threads=1, mapgen=mapgen)
        assert pathlib.Path(table).read_bytes() == undivided
        # An error of a worker comes back as itself.
        with pytest.raises(vc.RequestError, match="both"):
            vc.sweep_shares({**small, "compute": {"families": ["both"]}}, tmp_path / "wrong.csv", client, shares=2, mapgen=mapgen)
        # Values go to workers as they are.
        orbits = vc.Model(vc.Chain(21, 0.2, 0.1), 1.5, 0.4, amplitude=0.1, restitution=0.9).breathers("double-sided").orbits
        radii = [verdict.spectral_radius for verdict in client.gather(client.map(vc.Orbit.stability, orbits))]
        assert radii == [orbit.stability().spectral_radius for orbit in orbits]


def test_words_are_those_of_the_program(mapgen):
    model = vc.Model(vc.Chain(12, 0.2, 0.05), omega=1.5, asymmetry=0.2)
    flags = "--sites 12 --gamma1 .2 --gamma2 .05 --omega 1.5 --asymmetry .2 --sites-used 2 --reach 3 --families double-sided --all --json"
    told = json.loads(subprocess.run([mapgen, "words", *flags.split()], capture_output=True, check=True).stdout)
    words = vc.words(model, 2, 3, ["double-sided"])
    assert len(words) == told["words"] >= 6 and {row["word"] for row in told["solutions"]} <= set(words)
    assert len(vc.words(model)) == 2
    for arguments, told in [((0,), "sites_used = 0 is out of range"), ((3, 1), "has room for 1 to 2"), ((1, 0, ["word"]), 'families = "word" is unknown')]:
        with pytest.raises(vc.RequestError, match=told):
            vc.words(model, *arguments)
    with pytest.raises(vc.TooLargeError, match="a million words"):
        vc.words(model.replace(), 9, 11)
