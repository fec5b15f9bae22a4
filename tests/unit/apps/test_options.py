"""The table of the options of a command: what it declares, what was given, and what is refused."""

import pytest
import typer
from typer.testing import CliRunner

from electrovib.apps.cli import app as program
from electrovib.apps.cli.options import takes
from electrovib.core.errors import InputError

TABLE = """
scenario           [default: a/b]
[files]... FILE    Files.
-n N -> draws      Number of draws. [required]
--name A,B,...     Names, split at commas.
--rate SHARE       A number. [default: 0.5]
--vary PATH,... -> varying  Paths, which are
    told in two lines; repeatable.
--ring             A flag.
--force
"""


@pytest.fixture
def given():
    """Return a function that reads a command line, and returns what was given."""
    found = []
    app = typer.Typer(rich_markup_mode=None, add_completion=False)
    app.command()(takes(TABLE)(found.append))

    def call(line):
        done = CliRunner().invoke(app, line.split())
        assert done.exit_code == 0, done.output
        return found.pop()

    return call


def test_a_command_is_given_what_was_typed_and_what_has_a_default(given):
    assert given("-n 3") == {"scenario": "a/b", "draws": 3, "rate": 0.5}
    said = given("c/d e.nc f.nc -n 0 --name x,y --vary p,q --vary r --ring --rate 2 --force")
    assert said == {
        "scenario": "c/d", "files": ["e.nc", "f.nc"], "draws": 0, "name": ["x", "y"], "rate": 2.0,
        "varying": ["p", "q", "r"], "ring": True, "force": True,
    }  # fmt: skip


def test_an_option_that_is_absent_is_not_given(given):
    assert not {"name", "ring"} & given("-n 1").keys()


def test_what_does_not_belong_is_named_by_its_flag(given):
    said = given("-n 1 --vary p --ring --force")
    said.only("draws varying ring", "this")
    with pytest.raises(InputError) as refused:
        said.only("draws", "this")
    assert refused.value.problems == (
        "--vary: does not belong to this; omit it",
        "--ring: does not belong to this; omit it",
    )


def test_what_is_taken_is_no_longer_there(given):
    said = given("-n 1 --ring")
    assert said.take("draws name") == {"draws": 1}
    assert set(said) == {"scenario", "rate", "ring"}


def test_the_help_is_the_table():
    app = typer.Typer(rich_markup_mode=None, add_completion=False)
    app.command()(takes(TABLE)(print))
    shown = " ".join(CliRunner().invoke(app, ["--help"]).output.split())
    for words in (
        "-n N Number of draws. [required]",
        "--vary PATH,... Paths, which are told in two lines; repeatable.",
        "--rate SHARE A number. [default: 0.5]",
        "A TOML file, a paper's scenario such as vezzoli_2014/fig6, or a Trace. [default: a/b]",
        "--force Replace a file that electrovib did not write, or that was changed.",
    ):
        assert words in shown


def every_option():
    """Return each option of each command that takes a value, with the command."""
    waiting, found = [((), typer.main.get_command(program))], []
    while waiting:
        path, command = waiting.pop()
        if hasattr(command, "commands"):
            waiting += [((*path, name), each) for name, each in command.commands.items()]
            continue
        options = [each for each in command.params if each.param_type_name == "option" and not each.is_flag]
        found += [pytest.param(path, each, id=" ".join((*path, each.opts[0]))) for each in options]
    return found


@pytest.mark.parametrize(("path", "option"), every_option())
def test_an_option_given_twice_counts_twice_or_is_refused(path, option):
    assert option.multiple or ",..." not in str(option.metavar) or option.default
    if option.multiple:
        return
    for flags in ([option.opts[0]] * 2, [option.opts[0], option.opts[-1]]):
        done = CliRunner().invoke(program, [*path, flags[0], "7", flags[1], "8"])
        assert isinstance(done.exception, InputError), (done.output, done.exception)
        assert str(done.exception) == f"{option.opts[0]}: given 2 times; give it once"


def test_names_of_an_option_that_is_repeated_are_added_up_and_a_flag_may_be_repeated(given):
    assert given("-n 1 --name x,y --name z --ring --ring")["name"] == ["x", "y", "z"]
