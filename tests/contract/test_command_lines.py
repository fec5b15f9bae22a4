"""Every option of every command: a blank text, a name that no file can have, and a number that is no count of anything."""

import inspect
import shlex
import sys
import tomllib

import pytest
import typer

import electrovib as ev
from electrovib.apps.cli import app, main
from electrovib.apps.cli.import_ import _KEYS as KEYS
from electrovib.apps.cli.import_ import _OF_SIGNALS as TABLES
from electrovib.core.errors import InputError

SCENARIO = "vezzoli_2014/fig6"
WANTED, LAWS = (
    ["--want", "peak electrostatic_force = 1 mN", "--free", "drive.high"],
    "MaxwellStressInGap,Vezzoli2014Causal",
)
SPECTRUM = '{ hurst = 0.8, longest = "1 mm", roll_off = "0.5 mm", shortest = "0.25 mm" }'
TYPED = {
    "run": [SCENARIO],
    "compare": [SCENARIO],
    "study": [SCENARIO, "--space", "fingers", "-n", "4", "--seed", "1", "-o", "s.zarr"],
    "evidence": ["vezzoli"],
    "reproduce": [],
    "import": ["record.csv"],
    "times": ["record.csv"],
    **{
        name: [SCENARIO, "record.csv", "--free", "friction.coefficient"]
        for name in ("fit", "fit-laws", "fit-separately")
    },
    "fit-material": ["record.csv"],
    "fit-power-law": ["record.csv", "--x", "t", "--y", "a"],
    "fit-contact": [SCENARIO, "record.csv", "--load", "t", "--capacitance", "a", "--roughness", SPECTRUM],
    "bench run": [SCENARIO, "--simulate"],
    "bench init": [],
    "find-value": [SCENARIO, *WANTED],
    "value-for-share": [SCENARIO, *WANTED, "--space", "fingers", "--share", "0.9", "--seed", "1"],
    "drive-for-force": [SCENARIO, "--target", "sine 5 Hz 1 mN", "--method", "carrier"],
    "texture-drive": [SCENARIO, "--texture", "grating.toml", "--path", "30 mm/s"],
    "plan-plate": [SCENARIO, "--over", "drive.high=100V:1kV:3"],
    "plan-experiment": [SCENARIO, "--models", LAWS, "--over", "drive.high=100V:1kV:3", "--space", "fingers"],
    "check": [SCENARIO],
    "export": [SCENARIO, "-o", "drive.csv"],
    "explore": [SCENARIO, "--no-browser"],
    "report": [SCENARIO],
    "list": [],
    "init": [SCENARIO],
}
"""What is typed behind the name of a command; an option that is tried takes the place of the one with its name."""


def commands(group, before=""):
    for name, each in group.commands.items():
        found = (
            commands(each, f"{before}{name} ") if hasattr(each, "commands") else [(f"{before}{name}", each)]
        )
        yield from found


def options(*words):
    """Every option and argument with a value, of every command; only those with one of these words for it, if there are any."""
    for name, command in commands(typer.main.get_command(app)):
        for each in command.params:
            word = str(each.metavar or each.name)
            has_value = each.param_type_name == "argument" or not getattr(each, "is_flag", False)
            if has_value and each.name != "help" and (not words or any(one in word for one in words)):
                yield pytest.param(name, each, id=f"{name} {each.opts[0]}")


FIRST = ("scenario", "first", "record", "file", "files", "traces", "paper", "measured", "query")
"""Arguments that stand before all others."""


def typed(name, option, value):
    """Write the command line in which an option, or an argument, is `value`."""
    words = list(TYPED[name])
    if option.param_type_name == "argument":
        words = [value, *words[1:]] if option.name in FIRST else [*words[:1], value, *words[1:]]
    else:
        for flag in set(option.opts) & set(words):
            at = words.index(flag)
            del words[at : at + 2]
        words += [option.opts[0], value]
    return [*name.split(), *words]


@pytest.fixture
def said(monkeypatch, capsys, tmp_path):
    """Return what a command line ends with, and what it says; an exception that is none of a user is a traceback."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "record.csv").write_text(
        "time [s],a [V]\n0,0\n1e-3,1\n2e-3,1\n3e-3,0\n4e-3,0\n", encoding="utf-8"
    )

    def call(words):
        monkeypatch.setattr(sys, "argv", ["electrovib", *words])
        with pytest.raises(SystemExit) as end:
            main()
        return end.value.code, capsys.readouterr().err

    return call


BLANK = [each for each in options() if each.values[1].name not in ("query", "measured")]


def test_every_command_is_tried():
    assert TYPED.keys() == {name for name, _ in commands(typer.main.get_command(app))}
    assert len(BLANK) > 100


@pytest.mark.parametrize(("name", "option"), BLANK)
def test_a_blank_value_is_refused_before_anything_is_done(said, tmp_path, name, option):
    before = sorted(tmp_path.iterdir())
    for value in ("", "  "):
        code, words = said(typed(name, option, value))
        assert code == 2, words
        assert "is blank, as a variable is that is not set" in words or "Invalid value for" in words
        assert sorted(tmp_path.iterdir()) == before


NAMED = list(
    options("FILE", "DIR", "SPACE", "PLACE", "OUTPUT", "SCENARIO", "DRIVE", "TEXTURE", "SPEED", *FIRST)
)


@pytest.mark.parametrize(
    "suffix",
    [
        "",
        ".nc",
        *(pytest.param(each, marks=pytest.mark.slow) for each in (".toml", ".csv", ".html", ".py", ".zarr")),
    ],
)
@pytest.mark.parametrize(("name", "option"), NAMED)
def test_a_name_longer_than_any_file_has_is_answered_in_a_sentence(said, name, option, suffix):
    name_of = "x" * 300 + suffix
    code, words = said(typed(name, option, f"{name_of}=1" if "=" in str(option.metavar) else name_of))
    found = option.name in ("query", "measured", "columns")
    assert code in ((0, 2) if found else (2,)), words
    assert found or words.startswith("electrovib: ")


def written():
    """Every public function that writes, as a call with the name of its output."""
    check, trace = ev.check(SCENARIO), ev.simulate(SCENARIO, signals=["electrostatic_force"])
    study = {"space": "fingers", "n": 4, "seed": 1}
    return {
        "run": lambda name: ev.run(SCENARIO, output=name),
        "run report": lambda name: ev.run(SCENARIO, report=name),
        "save": lambda name: ev.save(trace, name),
        "save check": lambda name: ev.save(check, name),
        "report": lambda name: ev.report(trace, name),
        "init": lambda name: ev.init(SCENARIO, output=name),
        "export": lambda name: ev.export(SCENARIO, name),
        "export_waveform": lambda name: ev.export_waveform(SCENARIO, name, limits="limits.toml"),
        "study": lambda name: ev.study(SCENARIO, output=name, **study),
        "fit": lambda name: ev.fit(SCENARIO, trace, free="friction.coefficient", output=name),
        "fit_laws": lambda name: ev.fit_laws(SCENARIO, trace, free="friction.coefficient", output=name),
        "fit_separately": lambda name: ev.fit_separately(SCENARIO, [trace], free=[PATH], output=name),
        "fit_material": lambda name: ev.fit_material("record.csv", output=name),
        "reproduce": lambda name: ev.reproduce("vezzoli_2014", name),
        "run_bench": lambda name: ev.run_bench(SCENARIO, simulate=True, output=name),
    }


PATH = "friction.coefficient"


def test_the_functions_that_write_are_those_with_an_output():
    functions = {name: each for name in dir(ev) if inspect.isfunction(each := getattr(ev, name))}
    found = {name for name, each in functions.items() if "output" in inspect.signature(each).parameters}
    assert found <= {name.partition(" ")[0] for name in written()}
    assert len(found) > 6


@pytest.mark.parametrize(
    "name", ["", " ", "x" * 300, "x" * 300 + ".nc", "x" * 300 + ".csv", "record.csv/sub"]
)
def test_a_function_refuses_an_output_that_no_file_can_be(said, tmp_path, name):
    del said
    before = sorted(tmp_path.iterdir())
    for call in written().values():
        with pytest.raises(InputError) as found:
            call(name)
        assert name.strip() or any("blank" in each or "record.csv" in each for each in found.value.problems)
    assert sorted(tmp_path.iterdir()) == before


WRONG = {
    "whole": "7", "number": "2.5", "truth": "true", "list": '["a", 3]', "table": "{ a = [1] }", "date": "1979-05-27",
    "nested": "[[1]]",
}  # fmt: skip
RECIPES = {"trace": 'drive_voltage = "a"', "material": 'modulus = "a"', "measurement": 'value = "a"'}


@pytest.mark.parametrize("wrong", WRONG)
@pytest.mark.parametrize("key", [*KEYS, *(f"{table}.drive_voltage" for table in TABLES)])
def test_an_entry_of_a_recipe_of_another_type_is_answered_in_a_sentence(said, tmp_path, key, wrong):
    own = key.rpartition(".")[0] == "columns"
    for kind, columns in RECIPES.items():
        text = f"{key} = {WRONG[wrong]}\n" + ("" if own or key == "columns" else f"[columns]\n{columns}\n")
        (tmp_path / "lab.toml").write_text(text, encoding="utf-8")
        code, words = said(["import", "record.csv", "--recipe", "lab.toml", "--as", kind])
        is_right = wrong in ("whole", "number") and key.partition(".")[0] in ("step", "scale", "offset")
        assert (code == 2 and words.startswith("electrovib: ")) or is_right, (kind, text)


@pytest.mark.parametrize(
    ("entry", "words"),
    [
        ("part = 7", "part = 7: expected a text in quotes"),
        ("time = 3", "time = 3: expected a text in quotes"),
        ("crop = 5", "crop = 5: expected a span of time, such as '0.1 s..0.5 s'"),
        ("crop = [1, 2, 3]", "crop = [1, 2, 3]: expected a span of time"),
        ('crop = ["1 V", 2]', "crop = 1 V: expected a time"),
        ("step = true", "step = True: expected a number in SI, or a text with a unit"),
        ("detrend = [3]", "detrend = 3: expected the name of a signal"),
        ('decimal_comma = "maybe"', "decimal_comma = maybe: expected true or false"),
    ],
)
def test_what_an_entry_has_to_be_is_said(said, tmp_path, entry, words):
    (tmp_path / "lab.toml").write_text(f'{entry}\n[columns]\ndrive_voltage = "a"\n', encoding="utf-8")
    assert words in said(["import", "record.csv", "--recipe", "lab.toml"])[1]


@pytest.mark.parametrize("crop", ['"1 ms..3 ms"', "[0.001, 0.003]", '["1 ms", 0.003]'])
def test_a_span_of_time_is_a_text_or_two_ends(said, tmp_path, crop):
    del said
    recipe = {"crop": tomllib.loads(f"crop = {crop}")["crop"]}
    times = ev.import_file("record.csv", {"drive_voltage": "a"}, **recipe).time
    assert times.size == 3


PLAN = f"plan-experiment {SCENARIO} --models {LAWS} --over drive.high=100V:1kV:3 --space fingers --seed 1"
SHARE = f"value-for-share {SCENARIO} {shlex.join(WANTED)} --space fingers --share 0.9 --seed 1"
COUNTED = {
    "evidence": ("evidence vezzoli -n", ["0", "1", "-1"]),
    "plan": (f"{PLAN} -n", ["0", "1", "-1"]),
    "share": (f"{SHARE} -n", ["0", "1", "-1"]),
    "study": (f"study {SCENARIO} --space fingers --seed 1 -o s.zarr -n", ["0", "-1"]),
    "sensitivity": (
        f"study {SCENARIO} --space fingers --seed 1 --sensitivity --quantity MEAN -n",
        ["0", "1", "-1"],
    ),
    "workers": (f"study {SCENARIO} --space fingers --seed 1 -n 4 -o s.zarr --workers", ["0", "-1"]),
    "posterior": (f"fit {SCENARIO} trace.nc --free {PATH} --posterior --seed 1 -n", ["0", "1", "-1"]),
    "exponentials": ("times record.csv --exponentials", ["0", "-1"]),
    "port": (f"explore {SCENARIO} --no-browser --port", ["0", "-1"]),
    "evidence seed": ("evidence vezzoli --seed", ["-1"]),
    "plan seed": (f"{PLAN[:-1]}", ["-1"]),
}
"""Command lines that end with a count, and the counts below the smallest."""
HUGE = ["99999999", "1" + "0" * 24]


@pytest.mark.parametrize(
    ("line", "count"),
    [
        pytest.param(line, each, id=f"{name} {each}")
        for name, (line, few) in COUNTED.items()
        for each in [*few, *HUGE]
    ],
)
def test_no_count_is_beyond_a_sentence(said, line, count):
    if "trace.nc" in line:
        ev.save(ev.simulate(SCENARIO, signals=["lateral_force"]), "trace.nc")
    words = line.replace("MEAN", "'mean electrostatic_force'")
    if "seed" in words[-6:] and count == HUGE[0]:
        return  # a seed like any other
    code, told = said([*shlex.split(words), count])
    assert code == 2
    assert told.startswith("electrovib: "), told
