"""Commands as a person types them, run in this process in an empty folder."""

import csv
import shlex
import sys

import numpy as np
import pytest
from matplotlib.figure import Figure

import electrovib as ev
from electrovib.apps.cli import main
from electrovib.core.signals import make_trace
from electrovib.scenario.toml import to_toml


def contents(folder):
    """Return every file below a folder with what is in it."""
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


@pytest.fixture
def here(tmp_path, monkeypatch):
    """Return the working folder, which is empty."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def cli(here, capsys, monkeypatch):
    """Return a function that runs a command line: exit code, output and error output."""

    def call(line, *more):
        monkeypatch.setattr(sys, "argv", ["electrovib", *shlex.split(line), *map(str, more)])
        capsys.readouterr()
        with pytest.raises(SystemExit) as stop:
            main()
        out, err = capsys.readouterr()
        return int(stop.value.code or 0), out, err

    return call


@pytest.fixture
def said(cli):
    """Return a function that runs a command that succeeds, and returns what it prints."""

    def call(line, *more):
        code, out, err = cli(line, *more)
        assert (code, err) == (0, ""), (out, err)
        return out

    return call


@pytest.fixture
def refused(cli, here):
    """Return a function that runs a command that is refused: it returns the sentences, and nothing was written.

    Nothing is printed either, unless what was computed is in order and only its file is not.
    """

    def call(line, *more, silent=True):
        before = contents(here)
        code, out, err = cli(line, *more)
        assert code == 2
        assert out == "" or not silent
        assert err
        assert all(each.startswith("electrovib: ") for each in err.splitlines()), err
        assert contents(here) == before
        return err

    return call


@pytest.fixture
def blank_pictures(monkeypatch):
    """Draw nothing where a test is about words and files: tests/contract draws every figure of every answer."""

    def blank(_):
        figure = Figure((1, 1))
        figure.add_subplot().set_axis_off()
        return figure

    for module in ("documents", "files"):
        monkeypatch.setattr(f"electrovib.view.{module}.drawn", blank)


@pytest.fixture(scope="session")
def table():
    """Return a function that reads the rows of a table, without its comments: the mark and the warnings."""

    def rows(file):
        lines = file.read_text(encoding="utf-8").splitlines()
        return list(csv.DictReader(line for line in lines if not line.startswith("#")))

    return rows


GAP, LEAK = "stack.gap.thickness", "stack.gap.material.conductivity"


@pytest.fixture(scope="session")
def spectra(tmp_path_factory):
    """A folder with a scenario, the same with a film twice as thick, and spectra of three gaps with 1 % of noise."""
    place, rng = tmp_path_factory.mktemp("spectra"), np.random.default_rng(3)
    plate = ev.load("bau_2010/sine").replace({LEAK: "2e-9 S/m"})
    (place / "plate.toml").write_text(to_toml(plate))
    (place / "thick.toml").write_text(to_toml(plate.replace({"stack.insulator.thickness": "2 um"})))
    (place / "broken.nc").write_text("no Trace")
    grid = {"frequency.low": 1.0, "frequency.high": 1e5, "frequency.samples": 25}
    for name, gap in (("a", 3e-6), ("b", 3.3e-6), ("c", 3.6e-6)):
        exact = ev.simulate(plate.replace({GAP: gap, **grid}))
        clean = exact["impedance"].values
        noisy = clean + 0.01 * np.abs(clean) * (rng.normal(size=25) + 1j * rng.normal(size=25))
        recorded = {"impedance": (("frequency",), noisy)}
        ev.save(make_trace(recorded, {"frequency": exact["frequency"].values}, {}), place / f"{name}.nc")
    return place
