"""The netlist as text: values, names, refusals. What ngspice makes of it is tested in tests/reference."""

import math
import os
import re
import subprocess
import sys
from importlib.metadata import version
from typing import ClassVar

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import electrovib as ev
import electrovib.exports.save  # it binds the package to the name of the function
from electrovib.apps.cli import main
from electrovib.core.constants import eps0
from electrovib.core.errors import InputError, NotCausalError
from electrovib.core.model import read_model
from electrovib.exports.spice.netlist import netlist
from electrovib.exports.spice.section import Formula, MeterReading, Names, continued, number, remark, written
from electrovib.physics.conduction import FieldConduction, PolarityConduction
from electrovib.physics.force import MaxwellStressInGap
from electrovib.scenario import Scenario

AREA, FIG6 = 1e-4, "vezzoli_2014/fig6"
TERMS = [{"strength": 900, "relaxation_time": 2e-3}, {"strength": 300, "relaxation_time": 2e-5}]
PRONY = {"model": "Prony", "permittivity_high": 50, "terms": TERMS, "conductivity": 1e-6}
FILM = {"thickness": 90e-6, "material": {"model": "Constant", "permittivity": 3.35}}
SKIN = {"thickness": 200e-6, "material": PRONY}
SQUARE = {"model": "Square", "high": 100, "low": -50, "frequency": 50}
SINE = {"model": "Sine", "amplitude": 100, "frequency": 125}
MODULATED = {"amplitude": 100, "carrier": 3000, "modulation": 100}
CHIRP = {"model": "Chirp", "amplitude": 100, "first": 10, "last": 1000, "length": 0.2}


def stack(film=None, skin=None):
    return {"insulator": FILM | (film or {}), "stratum_corneum": SKIN | (skin or {})}


CONTENT = {
    "drive": {"model": "Step", "level": 100},
    "force": {"model": "MaxwellStressInGap"},
    "friction": {"model": "Coulomb", "coefficient": 0.5},
    "contact": {"model": "FixedArea", "area": AREA},
    "load": {"normal_force": 0.5},
    "circuit": {"return_path": {"model": "Grounded", "resistance": 1000}},
    "stack": stack(),
}


def scenario(**changes):
    return read_model(Scenario, CONTENT | changes)


def behind(**path):
    return {"circuit": {"return_path": path}}


def circuit(**changes):
    return netlist(scenario(**changes), name="c")


def element(text, name):
    """Words after the name of the one element of this name."""
    (found,) = re.findall(rf"^{name} (.*)$", text.replace("\n+ ", " "), flags=re.MULTILINE)
    return found.split()


def value(text, name):
    return float(element(text, name)[2])


def initial(text, *names):
    return [float(element(text, name)[3].removeprefix("IC=")) for name in names]


def pwl(text, name):
    inside = re.search(r"PWL\((.*)\)", " ".join(element(text, name)))[1]
    return np.array(inside.split(), dtype=float).reshape(-1, 2)


def evaluated(text, **known):
    functions = {name: getattr(math, name) for name in ("sin", "exp", "sqrt")} | {"ln": math.log}
    functions |= {"abs": abs, "pow": pow, "max": max, "min": min}
    return eval(text, {"__builtins__": {}}, functions | known)


C_FILM, C_SKIN = "C_insulator_high", "C_stratum_corneum_high"


def test_layers_have_the_values_of_their_materials_and_a_second_contact_is_the_stack_the_other_way():
    text = circuit()
    assert element(text, C_FILM)[:2] == ["plate", "after_insulator"]
    assert element(text, C_SKIN)[:2] == ["after_insulator", "finger"]
    per = eps0 * AREA / 200e-6
    for name, expected in {
        C_FILM: eps0 * 3.35 * AREA / 90e-6,
        C_SKIN: 50 * per,
        "C_stratum_corneum_1": 900 * per,
        "R_stratum_corneum_1": 2e-3 / (900 * per),
        "C_stratum_corneum_2": 300 * per,
        "R_stratum_corneum_2": 2e-5 / (300 * per),
        "R_stratum_corneum_conduction": 200e-6 / (1e-6 * AREA),
        "R_return": 1000,
    }.items():
        assert value(text, name) == pytest.approx(expected, rel=1e-14), name
    assert "R_insulator_conduction" not in text
    assert "IC=" not in text
    text = circuit(**behind(model="SecondElectrode", area=AREA / 2))
    assert element(text, "C_second_insulator_high")[0] == "0"
    assert element(text, "C_second_stratum_corneum_high")[1] == "back"
    for part in ("insulator_high", "stratum_corneum_1"):
        twice = 2 * value(text, f"C_second_{part}")
        assert value(text, f"C_{part}") == pytest.approx(twice, rel=1e-14)


def test_header_remarks_and_analyses_say_where_it_comes_from():
    time, frequency = {"duration": 0.02, "samples": 4001}, {"low": 10, "high": 1e5, "samples": 81}
    cole = {"model": "ConstantPhase", "permittivity": 1560, "reference_frequency": 50, "exponent": 0.75}
    skin = {"material": cole | {"conductivity": 1e-6}}
    made = scenario(title="a finger\non a plate", time=time, frequency=frequency, stack=stack(skin=skin))
    text = netlist(made, name="my circuit")
    lines = text.splitlines()
    assert lines[0] == "* a finger on a plate"
    assert lines[1] == f"* electrovib {version('electrovib')}, scenario {made.digest()}"
    assert "my_circuit.time.txt" in lines[2]
    assert "steps of at most 5e-06 s; a step of the drive takes 1e-09 s" in lines[3]
    assert lines[-1] == ".end"
    assert ".tran 5e-06 0.02 0 5e-06 uic" in text
    assert ".ac dec 20 10 100000" in text
    said = " ".join(text.split())
    assert "* insulator: 90 um of Constant on 1 cm2; relative permittivity 3.35; conductivity 0 S/m" in said
    reduced = r"stratum_corneum: 200 um of ConstantPhase on 1 cm2; .* a sum of 2\d Debye terms, within \S+e-0[56] of"
    assert re.search(reduced, said)


def test_the_same_scenario_gives_the_same_text_in_every_process():
    code = (
        "from electrovib.exports.spice.netlist import netlist; from electrovib.scenario import paper_scenario;"
        "print(netlist(paper_scenario('vezzoli_2014/fig6_gap'), name='c'), end='')"
    )
    command = [sys.executable, "-c", code]
    one, other = (
        subprocess.run(command, capture_output=True, check=True, env=os.environ | {"PYTHONHASHSEED": seed})
        for seed in ("1", "2")
    )
    assert one.stdout == other.stdout
    assert len(one.stdout.splitlines()) > 40


def test_layers_alike_but_for_capitals_stay_apart():
    plate = {"role": "plate", "thickness": 1e-6, "material": {"model": "Constant", "permittivity": 1.0}}
    layers = dict.fromkeys(("Gap", "GAP", "größe", "in_gap_1", "body"), plate) | {"insulator": FILM}
    lines = circuit(stack=layers).splitlines()
    names = [line.split()[0].lower() for line in lines if re.match(r"[RCLVIB]", line)]
    assert len(names) == len(set(names)) > 10
    assert {"c_gap_high", "c_gap_2_high", "c_groe_high"} <= set(names)


@given(st.lists(st.text(min_size=1, max_size=8), max_size=8))
def test_every_name_is_new_and_plain(wanted):
    names = Names({"body"})
    given_names = [names.new(word) for word in wanted]
    assert len({*given_names, "body"}) == len(given_names) + 1
    assert all(re.fullmatch(r"[a-z0-9_]+", name) for name in given_names)


@given(st.floats(-1e300, 1e300))
def test_numbers_keep_15_digits(x):
    assert float(number(x)) == pytest.approx(x, rel=1e-14, abs=0.0)


# drive


def test_jumps_become_edges_measured_points_stay_and_a_burst_is_switched():
    corners, edge = pwl(circuit(drive=SQUARE), "V_drive_1"), 2e-4 * 0.1 / 2000
    assert corners[0].tolist() == [0, 100]
    np.testing.assert_allclose(corners[1:3], [[0.01 - edge / 2, 100], [0.01 + edge / 2, -50]], rtol=1e-13)
    assert corners[-1, 0] >= 0.1
    assert np.all(np.diff(corners[:, 0]) > 0)
    drive = {"model": "Sampled", "time_samples": [1.0, 1.5, 1.75], "voltage_samples": [3.0, -2.0, 5.0]}
    corners = pwl(circuit(drive=drive), "V_drive_1")
    np.testing.assert_array_equal(corners, [[0, 3], [0.5, -2], [0.75, 5]])
    drive = {"model": "Burst", "amplitude": 100, "frequency": 250, "cycles": 3, "delay": 2e-3}
    gate = pwl(circuit(drive=drive), "V_drive_1_gate")
    np.testing.assert_array_equal(gate[:, 1], [0, 0, 1, 1, 0])
    np.testing.assert_allclose(gate[[1, 3], 0], [2e-3, 14e-3], rtol=1e-3)


SOURCES = [(SINE, "SIN(0 100 125)"), (SINE | {"phase": math.pi / 2}, "SIN(0 100 125 0 0 90)")]
SOURCES += [({"model": "Step", "level": -3}, "PWL(0 -3)")]


@pytest.mark.parametrize(("drive", "words"), SOURCES)
def test_simple_drives_are_simple_sources(drive, words):
    assert " ".join(element(circuit(drive=drive), "V_drive_1")).endswith(words)
    text = circuit(drive={"model": "CurrentSine", "amplitude": 1e-3, "frequency": 25e3})
    assert element(text, "I_drive_1")[:2] == ["0", "drive"]
    assert element(text, "I_response") == ["0", "drive", "DC", "0", "AC", "1"]


FORMULAS = [MODULATED | {"model": "AmplitudeModulation", "depth": 0.8}, CHIRP]
FORMULAS += [MODULATED | {"model": "SquareRootModulation", "depth": 0.5}]
FORMULAS += [{"model": "CurrentAmplifier", "command": CHIRP, "sense_resistance": 1e4}]


@pytest.mark.parametrize("drive", FORMULAS)
def test_a_formula_of_time_is_the_drive(drive):
    """The text of the source, evaluated by Python, against the drive."""
    made = scenario(drive=drive)
    words = element(netlist(made, name="c"), "B_drive_1")
    assert words[2:4] == (["I", "="] if made.drive.quantity == "current" else ["V", "="])
    body = "".join(words[4:]).replace("V(drive_1_gate)", "1")
    for time in (0.0, 1.234e-3, 17e-3):
        ours = float(made.drive.voltage(time))
        assert evaluated(body, time=time) == pytest.approx(ours, rel=1e-9, abs=1e-9 * abs(ours) + 1e-10)


# start


def test_charges_are_initial_voltages_and_a_jump_at_time_0_divides_by_capacitance():
    """Before time 0 the plate is at 0 V, as it holds the image: the voltages of film, skin and body add up to nothing."""
    charged = {"stack": stack(film={"initial_charge": 2e-5})}
    text = circuit(**charged)
    film, skin = initial(text, C_FILM, C_SKIN)
    assert film + skin == pytest.approx(0.0, abs=1e-12 * skin)
    charge = skin * value(text, C_SKIN) - film * value(text, C_FILM)
    assert charge == pytest.approx(2e-5 * AREA, rel=1e-13)
    text = circuit(**charged, **behind(model="Floating", capacitance=150e-12, charge=-1e-9))
    film, skin, body = initial(text, C_FILM, C_SKIN, "C_body")
    assert film + skin + body == pytest.approx(0.0, abs=1e-12 * abs(body))
    assert 150e-12 * body - skin * value(text, C_SKIN) == pytest.approx(-1e-9, rel=1e-12)
    text = circuit(drive=SQUARE, time={"initial_state": {"model": "PeriodicState"}})
    assert len(re.findall(r"^C_\S+ \S+ \S+ \S+ IC=", text, flags=re.MULTILINE)) == 4, "every capacitor"
    text = circuit(**behind(model="Grounded", resistance=0))
    film, skin = initial(text, C_FILM, C_SKIN)
    assert film + skin == pytest.approx(100, rel=1e-13)
    assert film * value(text, C_FILM) == pytest.approx(skin * value(text, C_SKIN), rel=1e-13)


# force


@given(st.floats(-3, 3), st.floats(-3, 3))
def test_a_formula_computes_what_it_was_written_from(x, y):
    def formula(x, y):
        square = np.square(x) - 2 * x**3 / (1 + y**2) + np.power(y, 7) / 3
        waves = np.exp(-(x**2)) * np.sin(3 - y) + np.maximum(x, -1.5)
        return -np.sqrt(1 + np.abs(x * y)) + waves - square + abs(y) ** 0.5

    text = formula(Formula("x"), Formula("y")).text
    assert evaluated(text, x=x, y=y) == pytest.approx(float(formula(x, y)), rel=1e-9, abs=1e-9)


@pytest.mark.parametrize(
    "wrong",
    [
        lambda x: x or 0,
        lambda x: np.where(np.asarray(x) > 0, 1, 0),
        lambda x: x ** Formula("y"),
        np.floor,
        float,
        lambda x: 2**x,
        lambda x: x + "1",
    ],
)
def test_what_is_no_formula_is_refused(wrong):
    with pytest.raises((TypeError, ValueError)):
        wrong(Formula("x"))


def test_laws_are_written_from_their_printed_equation_or_run_and_a_strange_one_is_refused():
    leak = PolarityConduction(conductivity_positive=5e-6, conductivity_negative=1e-6)
    for law in (leak, FieldConduction(conductivity=2e-6, onset_field=1e4)):
        text = written(law, "current_density", {"E": Formula("x")}, path="stack.gap.leak").text
        for field in (-3e4, 0.0, 2e4):
            ours = float(law.current_density(np.array(field)))
            assert evaluated(text, x=field) == pytest.approx(ours, rel=1e-12, abs=1e-30)

    class Printed:
        equation: ClassVar = {"pressure": "eps0*floor(E)"}

        def __iter__(self):
            return iter(())

    class Coded(Printed):
        equation: ClassVar = {}

        def pressure(self, E):
            return 3 * E**2

    assert written(Coded(), "pressure", {"E": Formula("x")}, path="force").text == "(3 * (x * x))"
    with pytest.raises(InputError, match="force = Printed: its pressure cannot be written as one formula"):
        written(Printed(), "pressure", {"E": Formula("x")}, path="force")


def test_readings_add_long_lines_are_continued_and_a_remark_cannot_become_an_element():
    one, other = MeterReading({"V(a)": 2.0}), MeterReading({"V(a)": 1.0, "I(V_x)": -3.0})
    assert (np.float64(2) * one - other / 2).weights == {"V(a)": 3.5, "I(V_x)": 1.5}
    assert (one + other).text == "3*V(a) - 3*I(V_x)"
    with pytest.raises(TypeError):
        one * other
    line = "V_x a 0 PWL(" + "  ".join(f"{k} 1" for k in range(100)) + ")"
    broken = continued(line)
    assert max(map(len, broken.splitlines())) <= 112
    assert broken.replace("\n+ ", " ").split() == line.split()
    remarks = remark("one\nR1 a b 1\x07\n\ntwo " + 60 * "words ")
    assert all(line.startswith("*") for line in remarks.splitlines())


def test_the_force_is_pressure_times_area_and_the_square_root_of_a_dispersive_skin_a_ladder():
    text = circuit()
    assert " ".join(element(text, "B_amplitude_e")[3:]).endswith("*V(plate,after_insulator)")
    body = "".join(element(text, "B_force")[4:]).replace("V(amplitude_e)", "field")
    expected = AREA * float(MaxwellStressInGap().pressure(np.array(1e7)))
    assert evaluated(body, field=1e7) == pytest.approx(expected, rel=1e-12)
    force = {"model": "Vezzoli2014Causal"}
    plain = {"material": {"model": "Constant", "permittivity": 1560, "conductivity": 1e-6}}
    assert "filter_1" not in circuit(force=force, stack=stack(skin=plain))
    text = circuit(force=force)
    sections = re.findall(r"^Rfilter_1_(\d+) filter_1 filter_1_\1 ", text, flags=re.MULTILINE)
    assert len(sections) == len(re.findall(r"^Cfilter_1_", text, flags=re.MULTILINE)) > 2


# refusals

SETTLED = {"time": {"initial_state": {"model": "PeriodicState"}}}
AREAS = {"contact": {"model": "GrowingArea", "area": 1e-4, "at_force": 0.5, "exponent": 0.5}}
GROWING = {"model": "FieldConduction", "conductivity": 1e-6, "onset_field": 1e4}
SALT = {"thickness": 1e-9, "material": {"model": "Constant", "permittivity": 80, "conductivity": 100}}
FULL = MODULATED | {"model": "SquareRootModulation", "depth": 0.99999}
CHARGED = stack(film={"initial_charge": 1e-5})
SWEAT = {"insulator": FILM, "sweat": SALT | {"role": "finger"}}
REFUSED = {
    "chirp": (SETTLED | {"drive": CHIRP}, "does not repeat"),
    "area": (AREAS, "contact = GrowingArea: its area follows load and attraction"),
    "charge": (SETTLED | {"stack": CHARGED}, r"stack\.insulator\.initial_charge.*use AtRest"),
    "leak": (SETTLED | {"stack": stack(skin={"leak": GROWING})}, r"stratum_corneum\.leak.*use AtRest"),
    "sines": ({"drive": FULL}, r"drive = SquareRootModulation: .* \d+ sines, more than the 500"),
    "stiff": ({"stack": SWEAT}, r"3\.3e-11 F in .* 1e\+07 S.*frequency\.low to .* Hz or more"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_has_no_exact_form_is_refused(case, tmp_path):
    changes, words = REFUSED[case]
    path = tmp_path / "circuit.cir"
    path.write_text("older")
    with pytest.raises(InputError, match=words):
        ev.export(scenario(**changes), path, force=True)
    assert path.read_text() == "older"
    assert list(tmp_path.iterdir()) == [path]


KNOWN = r": a scenario is exported as \.cir, and its drive as .*, not as"


REFUSED_FILES = {
    "vezzoli_2014/fig7 circuit.cir": r"not causal.*Use Vezzoli2014Causal",
    "persson_2018/coating circuit.cir": r"force = Persson2018RoughGap: .* another force\.model such as Max",
    f"{FIG6} circuit.sp": f"circuit.sp{KNOWN}",
    f"{FIG6} circuit": f"circuit{KNOWN}",
}


@pytest.mark.parametrize("case", REFUSED_FILES)
def test_laws_of_more_than_the_circuit_and_unknown_suffixes_are_refused(case, tmp_path):
    name, file = case.split()
    with pytest.raises(NotCausalError if name.endswith("fig7") else InputError, match=REFUSED_FILES[case]):
        ev.export(name, tmp_path / file)
    assert not list(tmp_path.iterdir())


# doors


def without_mark(path):
    """Leave out the checksum, which differs wherever anything else does, and the warnings that a file of it states."""
    text = re.sub(
        r"checksum [0-9a-f]{32}|^\* (warning|not judged): .*\n", "", path.read_text(), flags=re.MULTILINE
    )
    return text.replace(f"{path.stem}.time", "c.time").replace(f"{path.stem}.freq", "c.freq")


def test_the_function_keeps_its_name_and_takes_a_scenario_a_trace_or_its_tables_but_no_sweep(tmp_path):
    assert electrovib.exports.save.save is ev.save.__wrapped__
    path = ev.export(FIG6, tmp_path / "a.cir", set={"drive.high": "500 V"})
    np.testing.assert_array_equal(pwl(path.read_text(), "V_drive_1")[:, 1], [0, 500, 500, 0])
    ev.save(ev.simulate(scenario()), tmp_path / "one.nc")
    (tmp_path / "text.cir").write_text(netlist(scenario(), name="text"))
    tables = scenario().to_dict() | {"schema": 1}
    for place, given_ in enumerate((tmp_path / "one.nc", tables)):
        found = ev.export(given_, tmp_path / f"{place}.cir")
        assert without_mark(found) == without_mark(tmp_path / "text.cir")
    ev.save(ev.sweep(scenario(), {"drive.level": [1.0, 2.0]}), tmp_path / "many.nc")
    with pytest.raises(InputError, match="many scenarios"):
        ev.export(tmp_path / "many.nc", tmp_path / "d.cir")


@pytest.mark.parametrize(
    ("name", "shown"),
    [("circuit.cir", "circuit.cir"), ("my circuit.cir", "'my circuit.cir'"), ("circuit.txt", "")],
)
def test_command_line(name, shown, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    words = ["electrovib", "export", FIG6, name, "--set", "drive.high=500 V"]
    monkeypatch.setattr(sys, "argv", words)
    with pytest.raises(SystemExit) as stop:
        main()
    said = capsys.readouterr()
    if shown:
        assert not stop.value.code
        assert said.out.splitlines() == [f"written: {name}", f"run it:  ngspice -b {shown}"]
        assert (tmp_path / name).read_text().endswith("\n.end\n")
    else:
        assert stop.value.code == 2
        assert re.fullmatch(f"electrovib: circuit.txt{KNOWN} '.txt'.\n", said.err)
        assert not list(tmp_path.iterdir())
