"""The options of a command: what it is given, what its help says, and what is refused."""

from typing import Annotated

import pytest
import typer
from typer.testing import CliRunner

from electrovib.apps.cli import app as program
from electrovib.apps.cli import options
from electrovib.apps.cli.grouped import Command
from electrovib.core.errors import InputError

GIVEN = {}


def command(
    context: typer.Context,
    *,
    scenario: options.Scenario = "a/b",
    files: Annotated[list[str] | None, typer.Argument()] = None,
    draws: Annotated[int, options.number("-n", int)],
    name: options.Names = None,
    rate: Annotated[float, options.number("--rate")] = 0.5,
    varying: Annotated[list[str] | None, typer.Option("--vary")] = None,
    ring: options.Flag = False,
    force: options.Flag = False,
) -> None:
    """Do something.

    At length.

    Parameters
    ----------
    files : FILE
        Files.
    draws : N
        Number of draws.
    name : A,B,...
        Names, split at commas.
    rate : SHARE
        A number.
    varying : PATH
        Paths, which are
        told in two lines; repeatable.
    ring
        A flag.

    Examples
    --------
    command -n 3
    """
    GIVEN.clear()
    GIVEN.update(locals())
    if ring and varying:
        options.only(context, "draws varying ring", "this")


@pytest.fixture
def call():
    """Return a function that reads a command line, and returns what was given."""
    app = typer.Typer(rich_markup_mode=None, add_completion=False)
    app.command(cls=Command)(command)

    def call(line):
        done = CliRunner().invoke(app, line.split())
        if done.exception:
            raise done.exception
        return {name: value for name, value in GIVEN.items() if name != "context"}

    return call


def test_a_parameter_that_is_a_class_of_options_stands_for_them():
    """They stand in its place, with their defaults; the command is given an instance of the class."""
    given = []

    def several(*, experiment: options.LimitOptions, n: options.Count, saved: options.AnswerOptions) -> None:
        """Do something.

        Parameters
        ----------
        n : N
            A number.
        """
        given.append((experiment, n, saved))

    app = typer.Typer(rich_markup_mode=None, add_completion=False)
    app.command(cls=Command)(options.spread_out(several))
    line = "a/b --set drive.high=3V -n 2 -o x.pdf --all --limits l.toml"
    assert CliRunner().invoke(app, line.split()).exit_code == 0
    ((experiment, n, saved),) = given
    assert (n, saved) == (2, options.AnswerOptions(output="x.pdf", all=True))
    assert experiment.asked == {"scenario": "a/b", "set": {"drive.high": "3V"}, "limits": ["l.toml"]}
    names = [each.name for each in typer.main.get_command(app).params]
    assert names == ["scenario", "set", "limits", "n", "output", "force", "style", "all"]
    shown = CliRunner().invoke(app, ["--help"]).output
    own, _, shared = shown.partition(f"\n{options.ANSWER}:\n")
    assert all(flag in shared and flag not in own for flag in ("--output", "--force", "--style", "--all"))


ABSENT = {"files": None, "name": None, "varying": None, "ring": False, "force": False}


def test_a_command_is_given_what_was_typed_and_what_has_a_default(call):
    assert call("-n 3") == ABSENT | {"scenario": "a/b", "draws": 3, "rate": 0.5}
    said = call("c/d e.nc f.nc -n 0 --name x,y --vary p --vary r --rate 2 --force")
    assert said == ABSENT | {
        "scenario": "c/d", "files": ["e.nc", "f.nc"], "draws": 0, "name": ["x", "y"], "rate": 2.0,
        "varying": ["p", "r"], "force": True,
    }  # fmt: skip


def test_what_does_not_belong_is_named_by_its_flag(call):
    call("-n 1 --vary p --ring --force")
    with pytest.raises(InputError) as refused:
        call("-n 1 --vary p --ring --rate 3 --name x")
    assert refused.value.problems == (
        "--name: does not belong to this; omit it",
        "--rate: does not belong to this; omit it",
    )


def test_what_is_absent_is_not_passed_on():
    assert options.given(a=None, b=0, c=False, d=[]) == {"b": 0, "c": False, "d": []}


def test_the_help_is_the_numpydoc_of_the_command_or_that_of_what_several_have():
    app = typer.Typer(rich_markup_mode=None, add_completion=False)
    app.command(cls=Command)(command)
    shown = " ".join(CliRunner().invoke(app, ["--help"]).output.split())
    for words in (
        "Example: command -n 3 Do something. At length. Arguments:",
        "-n N Number of draws. [required]",
        "--vary PATH Paths, which are told in two lines; repeatable.",
        "--rate SHARE A number. [default: 0.5]",
        "--ring A flag. --force",
        "A TOML file, a paper's scenario such as vezzoli_2014/fig6, or a Trace. [default: a/b]",
        "--force Replace a file that electrovib did not write, or that was changed.",
    ):
        assert words in shown


def test_a_flag_has_no_opposite(call):
    with pytest.raises(InputError, match="'--no-ring'"):
        call("-n 1 --no-ring")


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


def test_names_of_an_option_that_is_repeated_are_added_up_and_a_flag_may_be_repeated(call):
    assert call("-n 1 --name x,y --name z --ring --ring")["name"] == ["x", "y", "z"]


def test_every_parameter_of_every_command_is_described():
    waiting = [((), typer.main.get_command(program))]
    while waiting:
        path, command = waiting.pop()
        waiting += [((*path, name), each) for name, each in getattr(command, "commands", {}).items()]
        for each in command.params:
            assert each.help or getattr(each, "hidden", False), (path, each.name)
            takes_value = each.param_type_name == "option" and not each.is_flag
            assert each.metavar or not takes_value, (path, each.name)
