"""Commands as a person types them, run in this process in an empty folder."""

import csv
import shlex
import sys

import pytest

from electrovib.apps.cli import main


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
    """Return a function that runs a command that is refused: it returns the sentences, and nothing was written."""

    def call(line, *more):
        before = contents(here)
        code, out, err = cli(line, *more)
        assert (code, out) == (2, "")
        assert err
        assert all(each.startswith("electrovib: ") for each in err.splitlines()), err
        assert contents(here) == before
        return err

    return call


@pytest.fixture(scope="session")
def table():
    """Return a function that reads the rows of a table, without its comments: the mark and the warnings."""

    def rows(file):
        lines = file.read_text(encoding="utf-8").splitlines()
        return list(csv.DictReader(line for line in lines if not line.startswith("#")))

    return rows
