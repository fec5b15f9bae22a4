"""Finding things at the command line: help, completion, scenarios, models, citations."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest
import typer

import electrovib as ev
from electrovib.apps.cli import app, main
from electrovib.core.budget import ONE_THREAD

COMMANDS = sorted(
    [command.name for command in app.registered_commands]
    + [
        f"{group.name} {each.name}"
        for group in app.registered_groups
        for each in group.typer_instance.registered_commands
    ]
)


@pytest.fixture
def cli(tmp_path, capsys, monkeypatch):
    """Run a command in this process; gives exit code, output and error output."""
    monkeypatch.chdir(tmp_path)

    def call(*arguments):
        monkeypatch.setattr(sys, "argv", ["electrovib", *arguments])
        with pytest.raises(SystemExit) as stop:
            main()
        out, err = capsys.readouterr()
        return int(stop.value.code or 0), out, err

    return call


@pytest.fixture
def complete(tmp_path, capsys, monkeypatch):
    """Ask for the completion of a line, as the function that bash calls does."""
    monkeypatch.chdir(tmp_path)

    def call(*words):
        monkeypatch.setattr(sys, "argv", ["electrovib"])
        monkeypatch.setenv("_ELECTROVIB_COMPLETE", "complete_bash")
        monkeypatch.setenv("COMP_WORDS", " ".join(["electrovib", *words]))
        monkeypatch.setenv("COMP_CWORD", str(len(words)))
        with pytest.raises(SystemExit) as stop:
            typer.main.get_command(app)(prog_name="electrovib")
        assert not stop.value.code
        return capsys.readouterr().out.split()

    return call


def printed(records):
    return f"{records}\n"


@pytest.mark.parametrize("command", ["", *COMMANDS])
def test_h_is_help_on_every_command(cli, command):
    said = cli(*command.split(), "-h")
    assert said == cli(*command.split(), "--help")
    code, out, _ = said
    assert code == 0
    assert out.startswith("Usage: ")
    assert "-h, --help" in out


def test_the_help_of_a_command_of_ours_is_not_cut_off(cli):
    _, out, _ = cli("-h")
    for command in ("list", "init"):
        (line,) = [line for line in out.splitlines() if line.startswith(f"  {command} ")]
        assert not line.endswith("...")


def test_scenarios_print_what_python_returns(cli):
    assert cli("list", "scenarios") == (0, printed(ev.scenarios()), "")
    code, out, _ = cli("list", "scenarios", "3M")
    assert (code, out) == (0, printed(ev.scenarios("3M")))
    assert out.index("persson_2018/coating") < out.index("vardar_2017/sine")


def test_models_print_what_python_returns(cli):
    assert cli("list") == (0, printed(ev.models()), "")
    assert cli("list", "Constant") == (0, printed(ev.models("Constant")), "")
    assert cli("list", "--all") == (0, printed(ev.models(complete=True)), "")
    assert cli("list", "touchscreen") == (0, printed(ev.models("touchscreen")), "")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["list", "Trapezum"], ["Did you mean 'Trapezium' ("]),
        (
            ["list", "scenarios", "vezoli_2014/fig6"],
            ["'vezzoli_2014/fig6' (Vezzoli 2014, figure 6", "'electrovib list scenarios'"],
        ),
        (
            ["list", "zzzz"],
            ["no model, material, skin, paper or scenario", "'electrovib list' lists them"],
        ),
        (["list", "Sine", "--bibtex"], ["'Sine' belongs to no paper"]),
        (["list", "Sin", "--bibtex"], ["'Sin' is neither a model nor a paper. Did you mean 'Sine' ("]),
        (["run", "touchscreen"], ["neither a file nor a paper's scenario", "'bau_2010/sine' ("]),
        (["run", "vezzoli_2014"], ["is a paper; name one of its scenarios: vezzoli_2014/fig2,"]),
        (["run", "ayyildiz_2018"], ["'ayyildiz_2018' has no scenario."]),
    ],
)
def test_a_wrong_name_is_answered_in_one_line(arguments, words, cli):
    code, out, err = cli(*arguments)
    assert (code, out) == (2, "")
    assert len(err.splitlines()) == 1
    for word in words:
        assert word in err


@pytest.mark.parametrize("wrong", ["vezzoli_2014/fig66", "vezzoli_2013/fig6", "vezoli_2014/fig6"])
def test_a_wrong_preset_is_answered_with_the_nearest_three(wrong, cli):
    _, _, err = cli("run", wrong)
    assert err.count("'vezzoli_2014/fig") == 3 + ("fig66" in wrong)
    assert (
        "'vezzoli_2014/fig6' (Vezzoli 2014, figure 6: 0 to 1000 V trapezoidal pulse on a plastic film)" in err
    )


def test_a_wrong_model_in_a_scenario_is_answered_with_the_nearest_three(cli):
    _, _, err = cli("run", "--set", "drive.model=Trapezum")
    assert "Did you mean 'Trapezium' (" in err
    assert err.count(" (") == 3


def test_citations_are_printed_as_bibtex(cli):
    code, out, _ = cli("list", "Vezzoli2014Causal", "--bibtex")
    assert code == 0
    assert out.startswith(
        "@inproceedings{vezzoli_2014,\n  author = {E. Vezzoli and M. Amberg and F. Giraud and"
    )
    assert "title = {Electrovibration modeling analysis}" in out
    code, out, _ = cli("list", "--bibtex")
    assert out.count("\n@") >= 21
    assert "@article{vardar_2017," in out
    assert "@inproceedings{vardar_2016," in out


def test_commands_are_completed(complete):
    assert complete("") == [each.name for each in (*app.registered_commands, *app.registered_groups)]
    assert complete("li") == ["list"]


def test_names_of_scenarios_are_completed(complete):
    assert complete("list", "vezzoli_2014/fig6") == [
        "vezzoli_2014/fig6",
        "vezzoli_2014/fig6_static",
        "vezzoli_2014/fig6_gap",
    ]
    assert complete("init", "shultz") == ["shultz_2015/", "shultz_2018/"]
    assert complete("init", "kan") == [
        "kang_2017/sine",
        "kang_2017/modulated",
        "kang_2017/offset",
        "kang_2017/both",
    ]
    assert complete("init", "my_own") == []
    assert complete("init", "nobody_2014/f") == []


@pytest.mark.parametrize("command", ["run", "compare", "study", "design", "export", "init", "bench run"])
def test_every_command_that_takes_a_scenario_completes_its_name(command, complete):
    assert complete(*command.split(), "bau_2010/") == ["bau_2010/sine"]


def test_every_argument_that_is_a_scenario_or_a_paper_is_completed():
    for command in typer.main.get_command(app).commands.values():
        for parameter in command.params:
            if parameter.name in {"scenario", "paper", "query"}:
                assert parameter.shell_complete(typer.Context(command), "vezzoli"), command.name


def test_options_of_a_design_are_completed(complete):
    assert "drive.amplitude" in complete("design", "bau_2010/sine", "--free", "drive.a")
    assert complete("design", "nobody/none", "--free", "drive.a") == []
    assert "mean" in complete("design", "bau_2010/sine", "--want", "mean")
    assert complete("design", "bau_2010/sine", "--space", "f") == ["fingers"]


def test_names_of_papers_are_completed(complete):
    assert complete("reproduce", "v") == ["vardar_2017", "vezzoli_2014"]


def test_only_the_paper_that_is_written_is_imported_for_a_completion():
    code = (
        "import sys; from electrovib.apps.cli.completion import scenario_names;"
        " print(*scenario_names('bau_2010/'), any('kaczmarek' in name for name in sys.modules))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "bau_2010/sine False\n"


def test_names_of_models_are_completed(complete):
    assert complete("list", "Max") == [
        "MaxwellStressInGap",
        "MaxwellStressInInsulator",
        "MaxwellStressInStratumCorneum",
    ]
    assert "gabriel_1996/wet" in complete("list", "gabriel")


@pytest.mark.parametrize(("own", "expected"), [({}, "1"), ({"OPENBLAS_NUM_THREADS": "2"}, "2")])
def test_linear_algebra_has_one_thread_unless_the_user_wants_more(own, expected):
    environment = {name: value for name, value in os.environ.items() if name not in ONE_THREAD} | own
    code = (
        "import atexit, os, sys; from electrovib.apps.start import main; assert 'numpy' not in sys.modules\n"
        "sys.argv = ['electrovib', '--version']; atexit.register(lambda: print(os.environ['OPENBLAS_NUM_THREADS'])); main()"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True
    )
    assert done.stdout.split()[-1] == expected


def test_the_script_for_bash_calls_the_program():
    environment = os.environ | {"_ELECTROVIB_COMPLETE": "source_bash"}
    code = "import sys; sys.argv = ['electrovib']; from electrovib.apps.start import main; main()"
    done = subprocess.run(
        [sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=False
    )
    assert "complete -o default -F _electrovib_completion electrovib" in done.stdout
