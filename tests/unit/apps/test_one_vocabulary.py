"""One name for one thing: few commands and options, and whoever takes another word is told the right one."""

from __future__ import annotations

import tomllib

import numpy as np
import pytest
from typer.main import get_command

import electrovib as ev
from electrovib.apps.cli import app, main


@pytest.fixture
def cli(tmp_path, capsys, monkeypatch):
    """Return a function that runs a command in this process: exit code, output and error output."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "my.toml").write_text(ev.init("vezzoli_2014/fig6"), encoding="utf-8")

    def call(*arguments: str) -> tuple[int, str, str]:
        monkeypatch.setattr("sys.argv", ["electrovib", *arguments])
        with pytest.raises(SystemExit) as stop:
            main()
        out, err = capsys.readouterr()
        return int(stop.value.code or 0), out, err

    return call


def every(group, before=""):
    """Names of all commands with the commands, those of a group after its name."""
    for name, each in group.commands.items():
        yield from (
            every(each, f"{before}{name} ") if hasattr(each, "commands") else [(f"{before}{name}", each)]
        )


def options(command):
    return {
        each.opts[0]: each
        for each in command.params
        if each.param_type_name == "option" and "completion" not in each.name
    }


def test_commands_and_options_are_few():
    program = get_command(app)
    assert len(program.commands) <= 16
    found = set(options(program)).union(*(options(each) for _, each in every(program)))
    assert len(found) <= 80


def test_one_name_has_one_form_everywhere():
    """An option that several commands have is repeatable in all of them, or in none; the exceptions have a reason."""
    forms = {}
    for name, each in every(get_command(app)):
        for option, parameter in options(each).items():
            forms.setdefault(option, {})[name] = parameter.multiple
    mixed = {option for option, found in forms.items() if len(set(found.values())) > 1}
    # several files of a study; one parameter is sought by a design, several by a fit; one signal has edges
    assert mixed == {"--output", "--free", "--quantity"}


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ("run my.toml --want x", "'--want' belongs to 'design'; 'run' takes '--quantity'"),
        ("study my.toml --over a=1:2:3", "'--over' belongs to 'run', 'compare', 'design'; 'study' takes '--set'"),
        ("times a.nc --signal force", "no command has an option '--signal'; 'times' takes '--quantity'"),
        ("import a.csv --crop 1", "no command has an option '--crop'; 'import' takes '--set'"),
        ("check my.toml --seperately", "no command has an option '--seperately'; 'check' has no such option."),
        ("check my.toml --limit a", "'check' has no such option. Did you mean '--limits'?"),
        ("run my.toml --budget 1", "'--budget' stands before the command: electrovib --budget ... run"),
        ("bench run my.toml --over a=1:2:3", "'--over' belongs to 'run', 'compare', 'design'; 'run' takes '--set'"),
        ("perceive my.toml", "'perceive' is no command; this is done by 'electrovib run'"),
        ("fit-material a.csv", "'fit-material' is no command; this is done by 'electrovib fit'"),
        ("exprot my.toml", "'exprot' is no command. Did you mean 'export'?"),
        ("bench start", "'start' is no command."),
    ],
)  # fmt: skip
def test_another_word_is_answered_with_the_right_one(arguments, sentence, cli):
    code, out, err = cli(*arguments.split())
    assert (code, out) == (2, "")
    assert sentence in err
    assert err.count("\n") == 1


def test_every_word_that_is_merged_names_a_command_that_there_is(cli):
    from electrovib.apps.cli.grouped import _MERGED

    program = get_command(app)
    for word, meant in _MERGED.items():
        name, *rest = meant.split()
        assert word not in program.commands
        assert name in program.commands
        flags = options(program.commands[name])
        assert all(each in flags for each in rest if each.startswith("--"))


@pytest.mark.parametrize(
    ("arguments", "sentences"),
    [
        (["run", "my.toml", "--states", "--report", "a.html"], ["--report: does not belong to --states"]),
        (["run", "my.toml", "--voltage", "9 V"], ["--voltage: does not belong to a run without --states"]),
        (["times", "a.nc", "--swipes", "--by", "x"], ["--by: does not belong to --swipes"]),
        (["times", "a.nc", "--trim", "5"], ["--trim: does not belong to times, but to --swipes"]),
        (["fit", "my.toml", "a.nc"], ["--free: not given; for instance --free friction.coefficient, or --layer"]),
        (
            ["fit", "my.toml", "a.nc", "--free", "x", "--form", "debye", "--column", "x=y"],
            ["--form: does not belong to the fit of a scenario", "--column: does not belong"],
        ),
        (["fit", "a.csv", "--posterior"], ["--posterior: does not belong to the fit of a material; name --free"]),
        (["fit", "a.csv", "--column", "x=a", "--band", "1 Hz..2 Hz"], ["--band: does not belong to the fit of a power"]),
        (["fit", "a.csv", "--column", "x=a"], ["--column: a power law takes x=COLUMN and y=COLUMN"]),
        (["fit", "a.csv", "--set", "crop=1 s..2 s"], ["crop: does not belong to the fit of a material"]),
        (
            ["fit", "my.toml", "a.nc", "--free", "x", "--separately", "--vary", "x"],
            ["--vary: does not belong to --separately, but to a joint fit"],
        ),
        (["design", "my.toml", "--over", "a=1:2:3", "--seed", "0"], ["--seed: does not belong to the design of a plate"]),
        (["design", "my.toml", "--path", "1 m/s"], ["--path: does not belong to the design of a parameter or a drive"]),
        (["design", "my.toml", "--texture", "{}", "--want", "x = 1"], ["--want: does not belong to the drive of a texture"]),
        (["design", "my.toml", "--texture", "{}"], ["--path: not given, but a texture is rendered along a path"]),
        (["design", "my.toml", "--want", "a = 1", "--want", "b = 2"], ["--want: given several times"]),
        (["design", "my.toml", "--over", "a=1:2:3", "--want", "a = 1"], ["of a plate expected 'NAME = maximum'"]),
        (["study", "my.toml", "-n", "4", "--seed", "1"], ["--space: not given; for instance --space fingers"]),
        (["study", "my.toml", "-n", "4", "--seed", "1", "--space", "fingers"], ["--output: name one folder"]),
        (
            ["study", "my.toml", "-n", "4", "--seed", "1", "--space", "fingers", "--sensitivity", "--records"],
            ["--records: does not belong to --sensitivity"],
        ),
        (
            ["study", "my.toml", "-n", "4", "--seed", "1", "--space", "fingers", "--sensitivity"],
            ["--quantity: --sensitivity takes exactly one"],
        ),
        (
            ["study", "my.toml", "-n", "4", "--seed", "1", "--space", "fingers", "-o", "a", "--workers", "many"],
            ["--workers = many: expected a number, or the address"],
        ),
    ],
)  # fmt: skip
def test_an_option_of_something_else_is_refused(arguments, sentences, cli):
    code, out, err = cli(*arguments)
    assert (code, out) == (2, "")
    for sentence in sentences:
        assert sentence in err


def test_a_default_that_is_typed_counts_as_given(cli):
    """Whether an option was given is no question of its value."""
    assert "--seed" in cli("design", "my.toml", "--material", "pet", "--seed", "0")[2]


def test_a_parameter_is_sought_in_a_range_and_a_drive_by_its_force(cli):
    wanted = ["design", "my.toml", "--want", "peak electrostatic_force = 1 mN"]
    whole = cli(*wanted, "--free", "drive.high")[1]
    narrow = cli(*wanted, "--free", "drive.high = 100 V:700 V")[1]
    assert "Other solutions: -624.706 V." in whole
    assert narrow.startswith("drive.high = 624.706 V gives")
    assert "Other solutions" not in narrow
    code, _, err = cli("design", "my.toml", "--want", "electrostatic_force = sine 5 Hz", "--method", "dc")
    assert code == 2
    assert "target" in err


def test_what_is_largest_in_a_plate_is_a_wish(cli):
    grid = ["--over", "drive.amplitude=20V:40V:2", "--refine", "0"]
    wishes = ["--want", "mean electrostatic_force = minimum", "--want", "peak voltage = maximum"]
    said = cli("design", "bau_2010/sine", *grid, *wishes)[1]
    found = ev.design_plate(
        "bau_2010/sine", ["drive.amplitude=20V:40V:2"], maximise=["peak voltage"],
        minimise=["mean electrostatic_force"], refine=0,
    )  # fmt: skip
    assert said.splitlines()[0] == found.answer.splitlines()[0]


def record(folder):
    time = np.arange(20) / 1000
    rows = "\n".join(f"{t},{1 + t:.6f}" for t in time)
    (folder / "a.csv").write_text(f"t,u\n{rows}\n")
    return ["--column", "lateral_force_measured=u [V]", "--set", "time=t [s]"]


def test_a_recipe_is_written_and_read(cli, tmp_path):
    options = record(tmp_path)
    options += [
        "--set",
        "scale.lateral_force_measured=2 N/V",
        "--set",
        "crop=5 ms..15 ms",
        "--set",
        "detrend=lateral_force_measured",
    ]
    assert cli("import", "a.csv", *options, "-o", "lab.toml") == (0, "written: lab.toml\n", "")
    held = tomllib.loads((tmp_path / "lab.toml").read_text(encoding="utf-8"))
    assert held == {
        "time": "t [s]",
        "crop": "5 ms..15 ms",
        "detrend": ["lateral_force_measured"],
        "scale": {"lateral_force_measured": "2 N/V"},
        "columns": {"lateral_force_measured": "u [V]"},
    }
    assert cli("import", "a.csv", *options, "-o", "first.nc")[0] == 0
    assert cli("import", "a.csv", "--recipe", "lab.toml", "-o", "second.nc")[0] == 0
    first, second = ev.open_trace("first.nc"), ev.open_trace("second.nc")
    assert first.equals(second)
    assert first.attrs["history"] == second.attrs["history"]
    assert first.time.size == 11
    changed = cli("import", "a.csv", "--recipe", "lab.toml", "--set", "crop=5 ms..10 ms", "-o", "third.nc")
    assert changed[0] == 0
    assert ev.open_trace("third.nc").time.size == 6
    assert "exists already" in cli("import", "a.csv", *options, "-o", "lab.toml")[2]


@pytest.mark.parametrize(
    ("entry", "sentence"),
    [
        ("croop=1 s..2 s", "croop: no entry of a recipe. Did you mean 'crop'?"),
        ("scale=2 N/V", "scale: expected scale.SIGNAL=VALUE"),
        ("crop.drive_voltage=1 s", "crop: expected crop=VALUE"),
        ("area=1 cm2", "area: does not belong to a Trace"),
        ("edges=drive_voltage", "edges: belongs to with=TRACE, which is not given"),
    ],
)
def test_a_wrong_entry_of_a_recipe_is_named(entry, sentence, cli, tmp_path):
    code, out, err = cli("import", "a.csv", *record(tmp_path), "--set", entry, "-o", "a.nc")
    assert (code, out) == (2, "")
    assert sentence in err


def test_a_report_reads_a_recipe_too(cli, tmp_path):
    options = [*record(tmp_path), "--set", "scale.lateral_force_measured=2 N/V"]
    assert cli("import", "a.csv", *options, "-o", "lab.toml")[0] == 0
    assert cli("report", "a.csv", "--recipe", "lab.toml", "-o", "r.html")[0] == 0
    assert "time: belongs to --column" in cli("report", "a.csv", "--set", "time=t [s]", "-o", "s.html")[2]


def test_a_spectrum_becomes_the_material_of_a_layer(cli, tmp_path):
    grid = np.geomspace(10, 1e5, 12)
    table = np.column_stack([grid, 1000 + 0 * grid, 1e-6 + 0 * grid])
    np.savetxt(
        "s.csv", table, delimiter=",", header="frequency [Hz],permittivity,conductivity [S/m]", comments=""
    )
    assert cli("fit", "my.toml", "s.csv", "--layer", "stratum_corneum", "-o", "with.toml")[0] == 0
    fitted = ev.load("with.toml").stack.layers["stratum_corneum"].material
    assert fitted.permittivity == pytest.approx(1000, rel=1e-3)
    assert fitted.conductivity == pytest.approx(1e-6, rel=1e-3)
    assert "no such layer" in cli("fit", "my.toml", "s.csv", "--layer", "skn")[2]
    assert "--free: not given" in cli("fit", "my.toml", "s.csv")[2]


def test_a_truth_of_a_recipe_is_no_text(cli, tmp_path):
    (tmp_path / "comma.csv").write_text(
        "t;u\n" + "\n".join(f"{k / 1000:.3f};{k}".replace(".", ",") for k in range(20))
    )
    options = ["--column", "lateral_force_measured=u [N]", "--set", "time=t [s]", "--set", "delimiter=;"]
    assert cli("import", "comma.csv", *options, "--set", "decimal_comma=true", "-o", "a.nc")[0] == 0
    assert ev.open_trace("a.nc").time.values[-1] == pytest.approx(0.019)
    assert cli("import", "comma.csv", *options, "--set", "decimal_comma=false", "-o", "b.nc")[0] == 2


def test_workers_are_a_number_or_the_address_of_a_scheduler():
    from electrovib.apps.cli.study import _processes

    assert _processes(None) == {"scheduler": None}
    assert _processes("4") == {"workers": 4}
    assert _processes("tcp://10.0.0.1:8786") == {"scheduler": "tcp://10.0.0.1:8786"}


def test_a_recipe_of_channels_means_swipes(cli):
    assert "channels: belongs to" in cli("times", "a.csv", "--recipe", "gone.toml", "--speed", "1 m/s")[2]
    assert "--speed: does not belong" in cli("times", "a.csv", "--speed", "1 m/s")[2]
