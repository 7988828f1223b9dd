"""What tests share: where the project is, and its program."""

import os
import pathlib
import sys

import pytest

import vibrochain as vc

ROOT = pathlib.Path(__file__).resolve().parents[3]


@pytest.fixture(autouse=True)
def at_root(monkeypatch):
    """Examples name files from the project's root."""
    monkeypatch.chdir(ROOT)


@pytest.fixture(autouse=True)
def without_figures():
    """Figures that a test leaves are closed."""
    yield
    if pyplot := sys.modules.get("matplotlib.pyplot"):
        pyplot.close("all")


@pytest.fixture(scope="session")
def mapgen():
    """The program: the environment says where, or the folder of builds has it."""
    target = pathlib.Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
    path = pathlib.Path(os.environ.get("MAPGEN", target / "debug" / "mapgen"))
    if not path.exists():
        pytest.fail(f"{path} is not there: build it (cargo build), or name it in the variable MAPGEN")
    return path


@pytest.fixture
def model():
    """A forced model with two double-sided breathers."""
    return vc.Model(vc.Chain(21, 0.2, 0.1), omega=1.5, asymmetry=0.4, amplitude=0.1, restitution=0.9)


@pytest.fixture
def orbit(model):
    """A physical one, unstable."""
    return model.breathers("double-sided").physical()
