"""Mistakes of a person at the command line: told in one sentence each, all at once, and nothing is written."""

import numpy as np
import pytest

import electrovib as ev
from electrovib.core.signals import without

pytestmark = pytest.mark.usefixtures("blank_pictures")

TRAPEZIUM = 'model = "Trapezium", high = "1 kV", rise = "36 ms", hold = "100 ms", fall = "36 ms"'
GOOD = f"""
schema = 1
drive = {{ {TRAPEZIUM} }}
force = {{ model = "Vezzoli2014Causal" }}
friction = {{ model = "Coulomb", coefficient = 0.5 }}
contact = {{ model = "FixedArea", area = "1 cm2" }}
[load]
normal_force = "0.5 N"
[circuit]
return_path = {{ model = "Grounded", resistance = "1 kohm" }}
[stack.insulator]
thickness = "90 um"
material = {{ model = "Constant", permittivity = 3.35 }}
[stack.stratum_corneum]
thickness = "200 um"
material = {{ model = "Constant", permittivity = 1560, conductivity = "1.79 uS/m" }}
"""
MEASURED = GOOD.replace(TRAPEZIUM, 'model = "Sampled", file = "drive.csv"')
NO_LAYER = GOOD[: GOOD.index("[stack.insulator]")] + "[stack]\n"


@pytest.fixture(scope="module")
def scope():
    """A recording of a force sensor in V and of the drive, over ten times."""
    return "time [s],CH1 [V]\n" + "".join(f"{at / 1000},{at}\n" for at in range(10))


@pytest.fixture
def folder(here, scope):
    """A folder with two scenarios, the second a sine, and what instruments have written."""
    (here / "my.toml").write_text(GOOD)
    sine = 'model = "Sine", amplitude = "100 V", frequency = "120 Hz"'
    plain = GOOD.replace(TRAPEZIUM, sine).replace("Vezzoli2014Causal", "MaxwellStressInGap")
    (here / "sine.toml").write_text(plain.replace("90 um", "1 um"))
    (here / "grey.png").write_bytes(b"")
    (here / "scope.csv").write_text(scope)
    (here / "drive.csv").write_text("time,voltage\n0,0\n0.01,100\n0.02,0\n")
    (here / "a.csv").write_text("t,u\n" + "".join(f"{at / 1000},{1 + at / 1000:.6f}\n" for at in range(20)))
    return here


IN_FILES = [
    ('thickness = "90 um"', 'thicknes = "90 um"', ["stack.insulator.thicknes", "'thickness'"]),
    ("Trapezium", "Trapezum", ["drive", "'Trapezum'", "Did you mean 'Trapezium' ("]),
    ("90 um", "2 V", ["stack.insulator.thickness = '2 V': expected a length, for instance '90 um'"]),
    ("90 um", "9**9**9", ["stack.insulator.thickness = '9**9**9': expected a length"]),
    ("90 um", "-90 um", ["stack.insulator.thickness", "between 100 pm and 100 mm"]),
    ('"0.5 N"', "nan", ["load.normal_force = nan", "finite"]),
    (GOOD, "", ["empty", "electrovib init"]),
    (GOOD, f"{GOOD}\n[stack", ["not valid TOML"]),
    ("schema = 1", "", ["schema = 1"]),
    ('"90 um"', "{}", ["stack.insulator.thickness", "expected a length"]),
    (GOOD, NO_LAYER, ["stack", "layer"]),
    ("[stack.insulator]", "[stack.insulater]", ["stack.insulater.role", "Did you mean 'insulator'?"]),
    (TRAPEZIUM, 'model = "Sampled", file = "none.csv"', ["drive", "none.csv"]),
    (GOOD, f"{GOOD}[limits]\nvoltage = 600 V\n", ['a text in quotes: voltage = "600 V"\n']),
]


@pytest.mark.parametrize(("good", "bad", "words"), IN_FILES, ids=[each[1][-40:] for each in IN_FILES])
def test_a_mistake_in_a_file_is_told_in_one_line(good, bad, words, here, refused):
    (here / "bad.toml").write_text(GOOD.replace(good, bad))
    err = refused("run bad.toml -o out.nc --report out.html")
    assert all(word in err for word in words), err


def test_all_mistakes_of_file_options_and_outputs_are_told_at_once(here, refused):
    bad = GOOD.replace("90 um", "2 V").replace("Trapezium", "Trapezum").replace("1 cm2", "-1 cm2")
    (here / "bad.toml").write_text(bad.replace("0.5 N", "x"))
    lines = refused("run bad.toml").splitlines()
    assert len(lines) == 4
    for path in ("drive", "contact.area", "load.normal_force", "stack.insulator.thickness"):
        assert sum(line.startswith(f"electrovib: {path} =") for line in lines) == 1
    (here / "bad.toml").write_text(GOOD.replace("90 um", "2 V"))
    err = refused("run bad.toml --set drive.high -o nowhere/out.nc --report out.xyz")
    words = ("--set drive.high: expected PATH=VALUE", "stack.insulator.thickness", "'nowhere'", ".html")
    assert [word in line for word, line in zip(words, err.splitlines(), strict=True)] == [True] * 4


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ("time,voltage\n0,0\n1e-3,ten\n2e-3,0\n", ["ten"]),
        ("time,voltage\n0,0\n", ["row"]),
        ("time,voltage\n0,0\n1e-3,1\n1e-3,2\n2e-3,0\n", ["repeats", "KeepIncreasing"]),
        ("t,voltage\n0,0\n1,1\n", ["time"]),
        ("0 0\n1 5\n", ["by its number, 0 first", "time_column = 0, voltage_column = 1."]),
    ],
)
def test_a_faulty_drive_file_is_told_with_its_place(content, words, here, refused):
    (here / "drive.csv").write_text(content)
    (here / "bad.toml").write_text(MEASURED)
    err = refused("run bad.toml -o out.nc")
    assert err.startswith("electrovib: drive = ")
    assert err.count("\n") == 1
    assert all(word in err for word in words), err


FORCES_FIRST = "Did you mean 'mean electrostatic_force' or 'mean lateral_force' or 'mean normal_force'?"
PICTURE = '{ model = "GreyscalePicture", file = "grey.png", pixels_per_millimetre = 5 }'
FINGERS = "study my.toml -n 4 --seed 1 --space fingers"
GAP = "--over stack.insulator.thickness=1um:2um:2 --quantity"
LIMITED = "--set 'limits.voltage=1 kV' --set 'limits.current=250 uA'"
SIGNAL = "--column 'lateral_force_measured=u [V]' --set 'time=t [s]'"
COMMANDS = f"""
# names of scenarios, files and papers
run vezzoli_2014/fig5 => Did you mean 'vezzoli_2014/fig
run vezzoli_2013/fig6 => neither a file nor a paper && 'vezzoli_2014/fig6' (Vezzoli 2014, figure 6: 0 to
run touchscreen => neither a file nor a paper's scenario && 'bau_2010/sine' (
run vezzoli_2014 => is a paper; name one of its scenarios: vezzoli_2014/fig2,
run ayyildiz_2018 => 'ayyildiz_2018' has no scenario.
run my.tml => Did you mean 'my.toml'?
run quite_another.toml => quite_another.toml && for instance vezzoli_2014/fig6
reproduce {__file__} => is a file, not a paper
list Trapezum => Did you mean 'Trapezium' (
list scenarios vezoli_2014/fig6 => 'vezzoli_2014/fig6' (Vezzoli 2014, figure 6 && list scenarios'
list zzzz => no model, material, skin, paper or scenario && 'electrovib list' lists them
list Sin --bibtex => 'Sin' is neither a model nor a paper. Did you mean 'Sine' (
# parameters and their values
run --set 'drive.high=2 mm' => drive.high = '2 mm': expected a voltage
run --set drive.high => PATH=VALUE
run bau_2010/sine --set drive.frequency=0 => : drive.frequency = '0': must lie between 1 mHz and 100 MHz
run my.toml --set 'thickness=50 um' => Did you mean 'stack.insulator.thickness' (thickness of the layer) or
run sine.toml --over drive.rise=1ms:2ms:2 => Models with 'rise': Trapezium; to take one, set drive.model as well.
run --set force.model=Vezzoli2014PerFrequency => not causal && Vezzoli2014Causal
run --set 'drive.high=1 V' --set 'drive.high=2 V' => --set drive.high=2 V:  && twice
run --over drive.rise=1ms:2ms:2 --over drive.rise=1ms:3ms:2 => --over drive.rise=1ms:3ms:2:  && twice
run --set drive.high=5 --over drive.high=1V:10V:3 => : drive.high: is set, but swept with --over as well
run --over drive.rise=1ms:2ms => PATH=FROM:TO:N
run --over drive.rise=0:1ms:5log => above 0
run --over drive.rise=1V:2V:5 => expected a time
# quantities
run --quantity 'peak curent' => Did you mean 'current'?
run my.toml {GAP} mean_force => {FORCES_FIRST}
run my.toml {GAP} force => {FORCES_FIRST.replace("mean e", "peak e").replace("'mean ", "'peak ")}
run my.toml {GAP} mean_lateral_force => Did you mean 'mean lateral_force'?
# outputs
run -o nowhere/out.nc => nowhere
run -o out.xyz => .nc, .csv, .mat
run -o force.gif => .pdf, .svg, .png
run --over drive.rise=1ms:2ms:3 --records -o out.csv => .nc
run --records => --over
compare vezzoli_2014/fig6 -o page.gif => .html, .pdf, .svg, .png
# what is given to another command, or in another order
run my.toml --set stack.insulator=none => to leave a layer out, delete its table in the file && --set stack='{{
run gone.zarr => 'gone.zarr' is neither a file nor
report gone.zarr -o s.html => 'gone.zarr' is neither a file nor
--models . run my.toml => --models .: is a folder; expected a Python file
export my.toml {LIMITED} --edge lin -o w.csv => --edge = lin: expected a time, for instance '10 us' && or 'line'
run my.toml --states --report a.html => --report: does not belong to --states
run my.toml --voltage '9 V' => --voltage: does not belong to a run without --states
run sine.toml --states => contact.surface is not given && the stack has no gap either: add [stack.gap]
compare a.nc b.nc => 'electrovib report a.nc b.nc -o overlay.html' overlays several Traces
check my.toml drive.csv => the order is: electrovib check drive.csv my.toml
fit drive.csv my.toml --free contact.area => the order is: electrovib fit my.toml drive.csv
export drive.csv my.toml -o w.csv => electrovib:
# comparisons
compare my.toml --models MaxwellStressInGp => Did you mean 'MaxwellStressInGap' ( && 'MaxwellStressInInsulator' (
compare --models MaxwellStressInGap => --models: needs a scenario
compare --materials pet => --materials: needs a scenario
compare my.toml --over stack.gap.thickness=1um:9um:3 => --set stack.gap='{{
compare my.toml --models , => names no force law
compare my.toml --models Persson2018RoughGap => mean_gap: missing
compare my.toml --materials kaptn => no material 'kaptn'. Nearest: polyimide
compare my.toml --materials pet --models x => --models: does not belong to --materials
compare my.toml --materials pet --layer gap => layer 'gap': the stack has none
# times and swipes
times --swipes . => .: is a folder; give the name of a file in it.
times a.nc --swipes --by x => --by: does not belong to --swipes
times a.csv --recipe gone.toml --speed '1 m/s' => channels: belongs to
times a.csv --speed '1 m/s' => --speed: does not belong
# fits
fit-power-law a.csv a.csv --x x --y y => a.csv: is given twice; omit one
fit-power-law a.csv --x x --y x => both are the column 'x'
fit a b --free c --gain-error 'current=-2 %' => error of current = -0.02: expected
fit my.toml a.nc => --free: not given; for instance --free friction.coefficient
fit my.toml a.nc --free x --form debye => '--form' belongs to 'fit-material'
fit-material a.csv --posterior => '--posterior' belongs to 'fit'
fit-power-law a.csv --x a => Missing option '--y'
fit-material a.csv --set 'crop=1 s..2 s' => crop: does not belong to the fit of a material
fit-separately my.toml a.nc --free x --varying x => '--varying' belongs to 'fit', 'fit-laws'
fit my.toml a.nc --free x --posterior => --posterior: state --seed
fit my.toml a.nc --free x --session a.nc => expected FILE=NAME
fit my.toml a.nc --free x --noise impedance => expected SIGNAL=VALUE
fit my.toml a.nc --free x --noise 'electrostatic_force=3 V' => --noise electrostatic_force=3 V
fit my.toml a.nc --free x --gain-error impedance=x => expected a share
fit my.toml a.nc --free x --zero-error 'impedance=1 V' => --zero-error impedance=1 V
fit-material a.csv --scatter x => FILE=SHARE
fit-material a.csv --band x => LOW..HIGH
# designs
find-value sine.toml --want 'mean electrostatic_force = 1 mN' --free voltage => Did you mean 'drive.amplitude' (peak voltage
find-value my.toml --want 'a = 1' --want 'b = 2' --free c => --want: given 2 times; give it once
find-value my.toml --free drive.high => Missing option '--want'
find-value my.toml --want 'x = 1' --free y --seed 0 => '--seed' belongs to 'study', && 'find-value' has no such option
value-for-share my.toml --want 'x = 1' --free y --space fingers --share 0.9 => Missing option '--seed'
plan-plate my.toml --over a=1:2:3 --want 'a = 1' => no option '--want' of 'electrovib plan-plate'
plan-plate my.toml => over: name at least one parameter that is varied
plan-experiment my.toml --models a,b --space fingers => Missing option '--over'
drive-for-force my.toml --target 'sine 5 Hz' --method dc => target
texture-drive my.toml --texture {{}} => Missing option '--path'
texture-drive my.toml --texture grey.png --path '30 mm/s' {LIMITED} => {PICTURE}
texture-drive my.toml --texture '{PICTURE.replace("grey", "gone")}' --path 30mm/s => gone.png: there is no such file
# studies
study my.toml -n 4 --seed 1 => --space: not given; for instance --space fingers
{FINGERS} => --output: name one folder
{FINGERS} --sensitivity --records => --records: does not belong to --sensitivity
{FINGERS} --sensitivity => --quantity: --sensitivity takes exactly one
{FINGERS} -o a --workers many => workers = many: expected a number of processes, 1 or more, or the address
# imports
import a.csv --column 'drive_voltage=u' --column drive_voltage=t => is given twice
import a.csv --as picture => expected trace, material or measurement
import a.csv --set reader=txt => Did you mean 'text'
import a.csv --as material -o x.csv => written as .toml
import a.csv --set part=2 => the file does not consist of parts with names; omit it
import a.csv {SIGNAL} --set 'croop=1 s..2 s' -o a.nc => croop: no entry of a recipe. Did you mean 'crop'?
import a.csv {SIGNAL} --set 'scale=2 N/V' -o a.nc => scale: expected scale.SIGNAL=VALUE
import a.csv {SIGNAL} --set 'area=1 cm2' -o a.nc => area: does not belong to a Trace
import a.csv {SIGNAL} --set edges=drive_voltage -o a.nc => edges: belongs to with=TRACE, which is not given
report a.csv --set 'time=t [s]' -o s.html => time: belongs to --column
"""
"""What is typed, and the words that the answer holds."""
CASES = [each.split(" => ") for each in COMMANDS.splitlines() if " => " in each]


@pytest.mark.parametrize(("line", "words"), CASES, ids=[line for line, _ in CASES])
def test_a_mistake_in_a_command_is_told_with_what_is_allowed(line, words, folder, refused):
    err = refused(line)
    assert all(word in err for word in words.split(" && ")), err


def test_a_quantity_that_a_recording_lacks_is_named_with_those_that_it_has(folder, said, refused):
    said("run my.toml -o short.nc")
    err = refused("fit my.toml short.nc --free friction.coefficient --quantity lateral_forc")
    assert "short.nc: quantity = 'lateral_forc': the recording has no such signal" in err
    assert "Did you mean 'lateral_force'?" in err


def test_a_hint_helps_or_is_left_out(here, refused):
    (here / "rig.toml").touch()
    assert "Did you mean" not in refused("run nothing.toml")
    assert "Did you mean" not in refused("times nothing.toml")
    assert "Did you mean 'rig.toml'?" in refused("run rigg.toml")
    (line,) = refused("times rig.csv --recipe rig.toml").splitlines()
    assert line.startswith("electrovib: rig.toml: ")
    assert all(f"'{name}'" in line for name in ("normal", "lateral", "clock"))
    (here / "twice.toml").write_text(f"{GOOD}[load]\n")
    assert "quotes" not in refused("run twice.toml")
    assert "limits" not in refused("texture-drive my.toml --texture gone.png --path 30mm/s")
    gap = "--set 'stack.gap.thickness=1 um'"
    assert "no gap either" not in refused(f"run vezzoli_2014/fig6 --states {gap}")


@pytest.mark.parametrize("wrong", ["vezzoli_2014/fig66", "vezzoli_2013/fig6", "vezoli_2014/fig6"])
def test_the_nearest_three_are_named(wrong, refused):
    assert refused(f"run {wrong}").count("'vezzoli_2014/fig") == 3 + ("fig66" in wrong)
    assert refused("run --set drive.model=Trapezum").count(" (") == 3


def test_columns_with_other_headings_are_named_by_their_parameter(folder, said, refused):
    err = refused('run my.toml --set \'drive={ model = "Sampled", file = "scope.csv" }\'')
    assert 'Name another by voltage_column = "..."' in err
    assert "'electrovib import scope.csv' reads what an instrument writes above them." in err
    named = '{ model = "Sampled", file = "scope.csv", voltage_column = "CH1" }'
    said("run my.toml --set", f"drive={named}")


def test_a_column_that_only_its_unit_tells_may_be_a_sensor(here, scope, said):
    (here / "a.csv").write_text(scope)
    assert "if 'CH1' is the output of a sensor" in said("import a.csv")
    (here / "a.csv").write_text(scope.replace("CH1", "voltage"))
    assert "is the output of a sensor" not in said("import a.csv")


@pytest.mark.parametrize("signal", ["plate_voltage", "amplifier_current"])
def test_a_signal_behind_an_amplifier_is_named_as_such(signal):
    assert "declare circuit.amplifier, or name the signals to fit" in without(signal, ["current"])


def test_a_recording_of_a_force_sensor_is_imported_as_its_listing_proposes_and_fitted(folder, said, refused):
    times = np.arange(0, 0.03, 2e-4)
    sliding = ev.simulate(ev.load("sine.toml").replace({"friction.coefficient": 0.6}), time=times)
    noise = 1e-3 * np.random.default_rng(1).standard_normal(times.size)
    reading = sliding["lateral_force"].values / 1.5 + noise  # volts of a sensor of 1.5 N/V
    columns = np.c_[times, sliding["drive_voltage"].values, reading]
    np.savetxt("cell.csv", columns, delimiter=",", comments="", header="Time (s),CH1 (V),Load cell (V)")
    assert '--column lateral_force="Load cell" --set scale.lateral_force="1.5 N/V"' in said("import cell.csv")
    measured = "lateral_force_measured"
    said(f"import cell.csv --column {measured}='Load cell' --set scale.{measured}='1.5 N/V' -o measured.nc")
    err = refused("fit sine.toml measured.nc --free friction.coefficient -o fit")
    assert err.endswith("declare [rig], or import the recording as 'lateral_force'\n")
    plain = measured.removesuffix("_measured")
    said(f"import cell.csv --column {plain}='Load cell' --set scale.{plain}='1.5 N/V' -o plain.nc")
    said("fit sine.toml plain.nc --free friction.coefficient -o fit")
    assert ev.load("fit/parameters.toml").friction.coefficient == pytest.approx(0.6, rel=1e-4)
