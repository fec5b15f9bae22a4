"""Finding things at the command line: help, completion, scenarios, models, citations."""

import inspect
import os
import re
import shlex
import subprocess
import sys

import pytest
import typer

import electrovib as ev
from electrovib.apps.cli import app
from electrovib.core.budget import ONE_THREAD
from electrovib.recordings.fit.contact import ContactFit

PROGRAM = typer.main.get_command(app)


def every(group, before=""):
    """Iterate over names and commands, those of a group after its name."""
    for name, each in group.commands.items():
        whole = f"{before}{name}"
        yield from every(each, f"{whole} ") if hasattr(each, "commands") else [(whole, each)]


DESIGNS = (
    "find-value",
    "value-for-share",
    "drive-for-force",
    "texture-drive",
    "plan-plate",
    "plan-experiment",
)


@pytest.fixture
def complete(here, capsys, monkeypatch):
    """Ask for the completion of a line, as the function that bash calls does."""

    def call(line):
        words = ["electrovib", *line.split(" ")]
        monkeypatch.setattr(sys, "argv", ["electrovib"])
        monkeypatch.setenv("_ELECTROVIB_COMPLETE", "complete_bash")
        monkeypatch.setenv("COMP_WORDS", " ".join(words))
        monkeypatch.setenv("COMP_CWORD", str(len(words) - 1))
        with pytest.raises(SystemExit) as stop:
            typer.main.get_command(app)(prog_name="electrovib")
        assert not stop.value.code
        return capsys.readouterr().out.split()

    return call


@pytest.mark.parametrize("command", ["", *sorted(name for name, _ in every(PROGRAM))])
def test_h_is_help_on_every_command(command, said):
    out = said(f"{command} -h")
    assert out == said(f"{command} --help")
    assert out.startswith("Usage: ")
    assert "-h, --help" in out


def test_help_lists_every_command_by_what_it_is_for_in_a_whole_sentence_of_one_line(said, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    out = said("--help")
    groups = dict(re.findall(r"^(\w+):\n((?:  [a-z].*\n?)+)", out, re.MULTILINE))
    assert list(groups)[-4:] == ["Predict", "Measure", "Plan", "See"]
    lines = {title: groups[title].splitlines() for title in list(groups)[-4:]}
    listed = {title: [line.split()[0] for line in rows] for title, rows in lines.items()}
    assert listed["Plan"] == [*DESIGNS, "check", "export"]
    assert listed["Predict"][:3] == ["run", "compare", "study"]
    assert {name for names in listed.values() for name in names} == set(PROGRAM.commands)
    for line in [line for rows in lines.values() for line in rows]:
        assert re.fullmatch(r"  [a-z-]+ +[A-Z].*[^.]\.", line), line
    out = said("bench --help")
    assert "Print a bench file to start from." in out
    assert "..." not in out.partition("Commands:")[2]


@pytest.mark.parametrize("name", ["find-value", "drive-for-force", "check", "fit"])
def test_help_begins_with_an_example_that_runs(name, said, here):
    (here / "my.toml").write_text(ev.init("vezzoli_2014/fig6"), encoding="utf-8")
    (here / "drive.csv").write_text("time,voltage\n0,0\n0.01,100\n0.02,0\n")
    out = said(f"{name} -h")
    usage, _, first, *_ = out.splitlines()
    assert f"electrovib {name} [OPTIONS]" in usage
    example = first.removeprefix("  Example: electrovib ")
    assert example != first
    assert out.count(example) == 1
    if name != "fit":  # whose recordings are the reader's
        said(shlex.join(shlex.split(example)))


def test_lists_print_what_python_returns(said):
    assert said("list scenarios") == f"{ev.scenarios()}\n"
    found = said("list scenarios 3M")
    assert found == f"{ev.scenarios('3M')}\n"
    assert found.index("persson_2018/coating") < found.index("vardar_2017/sine")
    assert said("list") == f"{ev.models()}\n"
    assert said("list --all") == f"{ev.models(complete=True)}\n"
    for name in ("Constant", "touchscreen", "HavriliakNegami"):
        assert said(f"list {name}") == f"{ev.models(name)}\n"
    for word in ("stack.LAYER.material", "Vezzoli2014Causal", "Unverified", "vezzoli_2014"):
        assert word in str(ev.models())
    assert "broadness" in str(ev.models("HavriliakNegami"))


def test_search_for_a_kind_begins_with_all_of_that_kind(said):
    kinds = re.findall(r"^[A-Z]\w+  +([a-z]+(?: [a-z]+)*)  ", said("list drives"), re.MULTILINE)
    count = kinds.count("drive")  # models that other tests declare are among them, or too long for the table
    assert count >= 12
    assert kinds[:count] == ["drive"] * count
    words = " ".join(said("list Sine").split())  # wrapped at the width of the terminal
    assert "own model a subclass of Drive: from electrovib.physics.drive.base import Drive" in words


def test_citations_are_printed_as_bibtex(said):
    out = said("list Vezzoli2014Causal --bibtex")
    assert out.startswith(
        "@inproceedings{vezzoli_2014,\n  author = {E. Vezzoli and M. Amberg and F. Giraud and"
    )
    assert "title = {Electrovibration modeling analysis}" in out
    out = said("list --bibtex")
    assert out.count("\n@") >= 21
    assert "@article{vardar_2017," in out
    assert "@inproceedings{vardar_2016," in out


FIG6 = "vezzoli_2014/fig6 vezzoli_2014/fig6_static vezzoli_2014/fig6_gap"
KANG = "kang_2017/sine kang_2017/modulated kang_2017/offset kang_2017/both"
LAWS = "MaxwellStressInGap MaxwellStressInInsulator MaxwellStressInStratumCorneum"


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        ("", " ".join(PROGRAM.commands)),
        ("li", "list"),
        ("list vezzoli_2014/fig6", FIG6),
        ("init shultz", "shultz_2015/ shultz_2018/"),
        ("init kan", KANG),
        ("init my_own", ""),
        ("init nobody_2014/f", ""),
        ("reproduce v", "vardar_2017 veijgen_2013 vezzoli_2014"),
        ("list Max", LAWS),
        ("find-value nobody/none --free drive.a", ""),
        ("value-for-share bau_2010/sine --space f", "fingers"),
        *((f"{name} bau_2010/", "bau_2010/sine") for name in ("run", "compare", "study", "find-value")),
        *((f"{name} bau_2010/", "bau_2010/sine") for name in ("export", "init", "bench run")),
    ],
)
def test_names_are_completed(line, expected, complete):
    assert sorted(complete(line)) == sorted(expected.split())


def test_long_lists_are_completed_too(complete):
    assert "gabriel_1996/wet" in complete("list gabriel")
    assert "drive.amplitude" in complete("find-value bau_2010/sine --free drive.a")
    assert "mean" in complete("find-value bau_2010/sine --want mean")


def test_every_argument_that_is_a_scenario_or_a_paper_is_completed():
    for command in PROGRAM.commands.values():
        for parameter in command.params:
            if parameter.name in {"scenario", "paper", "query"}:
                assert parameter.shell_complete(typer.Context(command), "vezzoli"), command.name


def python(code, environment=None):
    """Return what a process of its own prints."""
    command = [sys.executable, "-c", code]
    return subprocess.run(command, env=environment, capture_output=True, text=True, check=True).stdout


def test_only_the_paper_that_is_written_is_imported_for_a_completion():
    code = (
        "import sys; from electrovib.apps.cli.options import scenario_names;"
        " print(*scenario_names('bau_2010/'), any('kaczmarek' in name for name in sys.modules))"
    )
    assert python(code) == "bau_2010/sine False\n"


@pytest.mark.parametrize(("own", "expected"), [({}, "1"), ({"OPENBLAS_NUM_THREADS": "2"}, "2")])
def test_linear_algebra_has_one_thread_unless_the_user_wants_more(own, expected):
    environment = {name: value for name, value in os.environ.items() if name not in ONE_THREAD} | own
    code = (
        "import atexit, os, sys; from electrovib.apps.start import main; assert 'numpy' not in sys.modules\n"
        "sys.argv = ['electrovib', '--version']; atexit.register(lambda: print(os.environ['OPENBLAS_NUM_THREADS'])); main()"
    )
    assert python(code, environment).split()[-1] == expected


def test_the_script_for_bash_calls_the_program():
    environment = os.environ | {"_ELECTROVIB_COMPLETE": "source_bash"}
    code = "import sys; sys.argv = ['electrovib']; from electrovib.apps.start import main; main()"
    assert "complete -o default -F _electrovib_completion electrovib" in python(code, environment)


def options(command):
    return {
        each.opts[0]: each
        for each in command.params
        if each.param_type_name == "option" and "completion" not in each.name
    }


def test_commands_and_options_are_few_and_one_name_has_one_form_everywhere():
    """An option that several commands have is repeatable in all of them, or in none; the exceptions have a reason."""
    forms = {}
    for name, each in every(PROGRAM):
        for option, parameter in options(each).items():
            forms.setdefault(option, {})[name] = parameter.multiple
    assert len(PROGRAM.commands) <= 26
    assert len({*forms, *options(PROGRAM)}) <= 94
    mixed = {option for option, found in forms.items() if len(set(found.values())) > 1}
    # several files of a study; one parameter is sought by a design, several by a fit; one signal has edges; one voltage is held
    # where all states are found, several are predicted
    assert mixed == {"--output", "--free", "--quantity", "--voltage"}


@pytest.mark.parametrize("name", DESIGNS)
def test_a_design_has_the_name_and_the_arguments_of_its_function(name, said, monkeypatch):
    function = getattr(ev, name.replace("-", "_"))
    taken = set(inspect.signature(function).parameters)
    assert len(taken) <= 10
    own = {each.opts[0].strip("-").replace("-", "_") for each in PROGRAM.commands[name].params} - {"help"}
    assert taken - own == taken & {"progress", "refine"}
    further = {"output", "style", "edge", "all", "force", "models"}
    assert own - taken <= further
    monkeypatch.setenv("COLUMNS", "200")
    assert all(
        f"--{each.replace('_', '-')}" in said(f"{name} -h")
        for each in taken & {"want", "free", "target", "texture"}
    )


FITS = {
    "fit": (ev.fit, ev.Recordings, ev.Sampling),
    "fit-laws": (ev.fit_laws, ev.Recordings),
    "fit-separately": (ev.fit_separately, ev.Recordings),
    "fit-material": (ev.fit_material, ev.SpectrumRecipe, ev.SpectrumErrors),
    "fit-power-law": (ev.fit_power_law,),
    "fit-contact": (ev.fit_contact, ContactFit.predict),
}


@pytest.mark.parametrize("name", FITS)
def test_a_fit_has_the_names_of_its_function_and_of_what_this_is_given(name):
    taken = [inspect.signature(each).parameters for each in FITS[name]]
    assert all(len(each) <= 10 for each in taken)
    own = {each.name.strip("_") for each in PROGRAM.commands[name].params}
    further = {"output", "style", "all", "force", "models", "set", "recipe", "columns", "files"}
    assert own - set().union(*taken) <= further


def test_every_word_that_is_merged_names_a_command_that_there_is():
    from electrovib.apps.cli.meant import done_by

    for word, meant in done_by().items():
        name, *rest = meant.split()
        assert word not in PROGRAM.commands
        flags = options(PROGRAM.commands.get(name, PROGRAM))
        assert all(each in flags for each in (name, *rest) if each.startswith("--"))
