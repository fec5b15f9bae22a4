"""Options that commands take no more: each still counts, says on the error output what to use, and stands in no help."""

import numpy as np
import pytest
import typer.main

import electrovib as ev
from electrovib.apps.cli import app
from electrovib.apps.cli.gone import GONE, taken
from electrovib.core.errors import InputError

LIMITS = "--set limits.voltage=1kV --set limits.current=10mA"
WAVE = f"export bau_2010/sine {LIMITS} --edge line --ramp 1ms"
SLOW = (
    "export vezzoli_2014/fig6 --set limits.voltage=1kV --set limits.current=250uA --edge line --rate 10MHz --set drive.high=500V"
    " --set drive.rise=100ns --set drive.hold=5ms --set drive.fall=100ns --set circuit.amplifier.bandwidth=1Hz"
)
RIDGES = '\'{ model = "Grating", period = "2 mm", amplitude = "10 uN" }\''
TEXTURE = f"texture-drive vezzoli_2014/fig6 --texture {RIDGES} --path 0.5m/s {LIMITS}"
STUDY = "study bau_2010/sine --space fingers -n 4 --seed 1 -o s.zarr"
SPECTRUM = '\'{ hurst = 0.8, longest = "1 mm", roll_off = "0.5 mm", shortest = "0.25 mm" }\''
CONTACT = f"fit-contact bau_2010/sine c.csv --load N --capacitance C --roughness {SPECTRUM} --draws 1"
CASES = {
    "export --largest-error": (f"{WAVE} --rate 1500Hz -o w.csv --largest-error 50%", "at 1.5 kHz"),
    "export --amplifier-present": (f"{SLOW} --amplifier-present -o w.csv", "(declared to be present)"),
    "study --budget-memory": (f"{STUDY} --budget-memory 1MB", "written: s.zarr"),
    "study --report": (f"{STUDY} --report s.html", "written: s.html"),
    "texture-drive --frequency": (f"{TEXTURE} --frequency 1kHz -o t.json", "no carrier"),
    "times --exponentials": ("times r.nc --exponentials=1", "exponential"),
    "import --layer": ("import e.csv --as material -o e.toml --layer film", "written: e.toml"),
    "fit-material --recipe": ("fit-material z.csv --recipe film.toml --form constant", "permittivity"),
    "fit-power-law --recipe": ("fit-power-law c.csv --x N --y C --recipe comma.toml", "exponent"),
    "report --column": (
        "report a.csv --column 'normal_force=u [N]' --set 'time=t [s]' -o r.html",
        "written: r.html",
    ),
    "report --set": (
        "report a.csv --column 'normal_force=u [N]' --set 'time=t [s]' -o r.html",
        "written: r.html",
    ),
    "report --recipe": ("report a.csv --recipe lab.toml -o r.html", "written: r.html"),
}
"""What is typed, and what is printed."""


@pytest.fixture
def files(here):
    grid, time = np.geomspace(10, 1e4, 12), np.arange(0.0, 1.0, 1e-3)
    impedance = 1 / (1e-6 + 2j * np.pi * grid * 20e-12)
    tables = {
        "e.csv": ("f,permittivity", [grid, 80 + 0 * grid]),
        "z.csv": ("frequency [Hz],z' [ohm],z'' [ohm]", [grid, impedance.real, impedance.imag]),
        "a.csv": ("t,u", [time, time]),
        "c.csv": ("N,C", [[0.1, 0.2, 0.5, 1.0], [1e-10, 2e-10, 5e-10, 1e-9]]),
    }
    for name, (heading, columns) in tables.items():
        np.savetxt(here / name, np.column_stack(columns), delimiter=",", header=heading, comments="")
    (here / "film.toml").write_text('area = "1 cm2"\nthickness = "200 um"\n')
    (here / "comma.toml").write_text('delimiter = ","\n')
    (here / "lab.toml").write_text('time = "t [s]"\n[columns]\nnormal_force = "u [N]"\n')
    rise = 1 - np.exp(-np.maximum(time - 0.2, 0) / 0.02)
    ev.save(
        ev.import_file("a.csv", {"lateral_force": "u [N]"}, time="t [s]").assign(
            lateral_force=("time", rise)
        ),
        "r.nc",
    )
    return here


@pytest.mark.usefixtures("files", "blank_pictures")
@pytest.mark.parametrize("name", CASES)
def test_an_option_that_is_gone_counts_and_says_what_to_use(name, cli):
    command, _, flag = name.rpartition(" ")
    line, words = CASES[name]
    code, out, err = cli(line)
    assert code == 0, err
    assert words in out
    assert (
        f"{flag} is deprecated since electrovib 1.0.0 and goes in 2.0.0: use {GONE[command][flag].now}\n"
        in err
    )


def test_the_value_of_an_option_that_is_gone_counts(files, cli):
    assert cli(f"{WAVE} --rate 1500Hz -o b.csv")[0] == 2
    assert cli(f"{SLOW} -o b.csv")[0] == 2
    assert "they may take 0.016 MB" in cli(f"{STUDY} --budget-memory 16kB")[2]
    assert "exponentials = 9" in cli("times r.nc --exponentials 9")[2]
    assert cli("import e.csv --as material -o e.toml --layer film")[0] == 0
    assert "[stack.film.material]" in (files / "e.toml").read_text()
    assert cli("fit-material z.csv --form constant")[0] == 2
    assert "points = 3" in cli(f"{CONTACT} --points 3")[2]
    cli("report a.csv --column 'normal_force=u [N]' --set 'time=t [s]' -o r.html")
    assert "normal force" in (files / "r.html").read_text(encoding="utf-8")


def test_every_option_that_is_gone_is_tried_and_no_command_takes_it():
    names = {f"{command} {flag}" for command, flags in GONE.items() for flag in flags if flag != "--models"}
    assert names == CASES.keys() | {"fit-contact --points"}
    commands = dict(typer.main.get_command(app).commands)
    commands |= {f"bench {name}": each for name, each in commands.pop("bench").commands.items()}
    for command, flags in GONE.items():
        own = {flag for each in commands[command].params for flag in each.opts}
        assert not own & flags.keys()


def test_a_flag_that_is_gone_takes_no_value():
    with pytest.raises(InputError, match="--amplifier-present = no: takes no value"):
        taken(GONE["export"], ["a.toml", "--amplifier-present=no"])


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (["--frequency"], "--frequency: needs a value"),
        (["--frequency", " "], "--frequency: is blank"),
        (["--frequency", "1 Hz", "--frequency=2 Hz"], "--frequency: given twice"),
    ],
)
def test_an_option_that_is_gone_is_refused_as_any_other(words, sentence):
    with pytest.raises(InputError, match=sentence):
        taken(GONE["texture-drive"], words)


def test_other_words_are_left_as_they_are():
    words = ["my.toml", "--over", "drive.high=1:2:3", "--frequency", "1 Hz", "--force"]
    left, values = taken(GONE["texture-drive"], words)
    assert left == [*words[:3], "--force"]
    assert values == {"frequency": "1 Hz"}
    assert taken(GONE["run"], words) == (words, {})
