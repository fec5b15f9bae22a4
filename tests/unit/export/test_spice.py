"""The netlist as text: values, names, refusals. What ngspice makes of it is tested in tests/reference."""

from __future__ import annotations

import json
import math
import re
import subprocess
import sys
from importlib.metadata import version
from pathlib import Path
from typing import ClassVar

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import electrovib as ev
from electrovib.apps.cli import main
from electrovib.core.constants import eps0
from electrovib.core.errors import InputError, NotCausalError
from electrovib.core.model import read_model
from electrovib.export.spice.equation import written
from electrovib.export.spice.formula import Formula
from electrovib.export.spice.netlist import netlist
from electrovib.export.spice.reading import MeterReading
from electrovib.export.spice.text import Names, continued, number, remark
from electrovib.physics.conduction import FieldConduction, PolarityConduction
from electrovib.physics.force import MaxwellStressInGap
from electrovib.scenario import Scenario

AREA = 1e-4
PRONY = {
    "model": "Prony",
    "permittivity_high": 50,
    "terms": [{"strength": 900, "relaxation_time": 2e-3}, {"strength": 300, "relaxation_time": 2e-5}],
    "conductivity": 1e-6,
}
FILM = {"thickness": 90e-6, "material": {"model": "Constant", "permittivity": 3.35}}
SKIN = {"thickness": 200e-6, "material": PRONY}
SQUARE = {"model": "Square", "high": 100, "low": -50, "frequency": 50}


def scenario(**changes):
    content = {
        "drive": {"model": "Step", "level": 100},
        "force": {"model": "MaxwellStressInGap"},
        "friction": {"model": "Coulomb", "coefficient": 0.5},
        "contact": {"model": "FixedArea", "area": AREA},
        "load": {"normal_force": 0.5},
        "circuit": {"return_path": {"model": "Grounded", "resistance": 1000}},
        "stack": {"insulator": FILM, "stratum_corneum": SKIN},
    }
    return read_model(Scenario, content | changes)


def element(text, name):
    """Words after the name of the one element of this name."""
    joined = text.replace("\n+ ", " ")
    found = re.findall(rf"^{name} (.*)$", joined, flags=re.MULTILINE)
    assert len(found) == 1, name
    return found[0].split()


def value(text, name):
    return float(element(text, name)[2])


def pwl(text, name):
    inside = re.search(r"PWL\((.*)\)", " ".join(element(text, name)))[1]
    return np.array(inside.split(), dtype=float).reshape(-1, 2)


# values


def test_layers_have_the_values_of_their_materials():
    text = netlist(scenario(), name="circuit")
    assert element(text, "C_insulator_high")[:2] == ["plate", "after_insulator"]
    assert element(text, "C_stratum_corneum_high")[:2] == ["after_insulator", "finger"]
    per = eps0 * AREA / 200e-6
    for name, expected in {
        "C_insulator_high": eps0 * 3.35 * AREA / 90e-6,
        "C_stratum_corneum_high": 50 * per,
        "C_stratum_corneum_1": 900 * per,
        "R_stratum_corneum_1": 2e-3 / (900 * per),
        "C_stratum_corneum_2": 300 * per,
        "R_stratum_corneum_2": 2e-5 / (300 * per),
        "R_stratum_corneum_conduction": 200e-6 / (1e-6 * AREA),
        "R_return": 1000,
    }.items():
        assert value(text, name) == pytest.approx(expected, rel=1e-14), name
    assert "R_insulator_conduction" not in text


def test_the_header_says_where_it_comes_from():
    made = scenario(title="a finger\non a plate")
    lines = netlist(made, name="my circuit").splitlines()
    assert lines[0] == "* a finger on a plate"
    assert lines[1] == f"* electrovib {version('electrovib')}, scenario {made.digest()}"
    assert "my_circuit.time.txt" in lines[2]
    assert "steps of at most 5e-05 s; a step of the drive takes 1e-08 s" in lines[3]
    assert lines[-1] == ".end"


def test_a_layer_says_thickness_permittivity_and_reduction():
    skin = {"thickness": 200e-6, "material": {"model": "ConstantPhase", "permittivity": 1560, "reference_frequency": 50,
            "exponent": 0.75, "conductivity": 1e-6}}  # fmt: skip
    text = " ".join(netlist(scenario(stack={"insulator": FILM, "stratum_corneum": skin}), name="c").split())
    assert "* insulator: 90 um of Constant on 1 cm2; relative permittivity 3.35; conductivity 0 S/m" in text
    assert re.search(
        r"stratum_corneum: 200 um of ConstantPhase on 1 cm2; .* a sum of 2\d Debye terms, within \S+e-0[56] of",
        text,
    )


def test_analyses_follow_the_scenario():
    grids = {
        "time": {"duration": 0.02, "samples": 4001},
        "frequency": {"low": 10, "high": 1e5, "samples": 81},
    }
    text = netlist(scenario(**grids), name="c")
    assert ".tran 5e-06 0.02 0 5e-06 uic" in text
    assert ".ac dec 20 10 100000" in text


def test_the_same_scenario_gives_the_same_text_in_every_process():
    code = (
        "from electrovib.export.spice.netlist import netlist; from electrovib.scenario import paper_scenario;"
        "print(netlist(paper_scenario('vezzoli_2014/fig6_gap'), name='c'), end='')"
    )
    texts = {
        subprocess.run(
            [sys.executable, "-c", code],
            capture_output=True,
            text=True,
            check=True,
            env={"PYTHONHASHSEED": seed},
        ).stdout
        for seed in ("1", "2")
    }
    assert len(texts) == 1
    assert len(texts.pop().splitlines()) > 40


# names


def test_layers_alike_but_for_capitals_stay_apart():
    other = {"thickness": 1e-6}
    plate = {"role": "plate"} | other
    stack = {"Gap": plate, "GAP": plate, "größe": plate, "in_gap_1": plate, "body": plate, "insulator": FILM}
    text = netlist(scenario(stack=stack), name="c")
    names = [line.split()[0].lower() for line in text.splitlines() if re.match(r"[RCLVIB]", line)]
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


def test_long_lines_are_continued_and_read_back():
    line = "V_x a 0 PWL(" + "  ".join(f"{k} 1" for k in range(100)) + ")"
    broken = continued(line)
    assert max(map(len, broken.splitlines())) <= 112
    assert broken.replace("\n+ ", " ").split() == line.split()


def test_a_remark_cannot_become_an_element():
    assert all(
        line.startswith("*") for line in remark("one\nR1 a b 1\x07\n\ntwo " + 60 * "words ").splitlines()
    )


# drive


def test_a_jump_becomes_an_edge_around_it_but_not_at_time_0():
    text = netlist(scenario(drive=SQUARE), name="c")
    corners = pwl(text, "V_drive_1")
    edge = 2e-4 * 0.1 / 2000
    assert corners[0].tolist() == [0, 100]
    np.testing.assert_allclose(corners[1:3], [[0.01 - edge / 2, 100], [0.01 + edge / 2, -50]], rtol=1e-13)
    assert corners[-1, 0] >= 0.1
    assert np.all(np.diff(corners[:, 0]) > 0)


def test_measured_points_are_written_as_they_are():
    drive = {"model": "Sampled", "time_samples": [1.0, 1.5, 1.75], "voltage_samples": [3.0, -2.0, 5.0]}
    text = netlist(scenario(drive=drive), name="c")
    np.testing.assert_array_equal(pwl(text, "V_drive_1"), [[0, 3], [0.5, -2], [0.75, 5]])


@pytest.mark.parametrize(
    ("drive", "words"),
    [
        ({"model": "Sine", "amplitude": 100, "frequency": 125}, "SIN(0 100 125)"),
        (
            {"model": "Sine", "amplitude": 100, "frequency": 125, "phase": math.pi / 2},
            "SIN(0 100 125 0 0 90)",
        ),
        ({"model": "Step", "level": -3}, "PWL(0 -3)"),
    ],
)
def test_simple_drives_are_simple_sources(drive, words):
    assert " ".join(element(netlist(scenario(drive=drive), name="c"), "V_drive_1")).endswith(words)


DRIVES = {
    "modulated": {"model": "AmplitudeModulation", "amplitude": 100, "carrier": 3000, "modulation": 100, "depth": 0.8},
    "root": {"model": "SquareRootModulation", "amplitude": 100, "carrier": 3000, "modulation": 100, "depth": 0.5},
    "chirp": {"model": "Chirp", "amplitude": 100, "first": 10, "last": 1000, "length": 0.2},
    "command": {"model": "CurrentAmplifier", "command": {"model": "Chirp", "amplitude": 1, "first": 1, "last": 9,
                "length": 1}, "sense_resistance": 1e4},
}  # fmt: skip


@pytest.mark.parametrize("name", DRIVES)
def test_a_formula_of_time_is_the_drive(name):
    """The text of the source, evaluated by Python, against the drive."""
    made = scenario(drive=DRIVES[name])
    words = element(netlist(made, name="c"), "B_drive_1")
    assert words[2:4] == (["I", "="] if made.drive.quantity == "current" else ["V", "="])
    body = "".join(words[4:]).replace("V(drive_1_gate)", "1")
    for time in (0.0, 1.234e-3, 17e-3):
        ours = float(made.drive.voltage(time))
        assert evaluated(body, time=time) == pytest.approx(ours, rel=1e-9, abs=1e-9 * abs(ours) + 1e-10)


def test_a_burst_is_switched_on_and_off():
    drive = {"model": "Burst", "amplitude": 100, "frequency": 250, "cycles": 3, "delay": 2e-3}
    gate = pwl(netlist(scenario(drive=drive), name="c"), "V_drive_1_gate")
    np.testing.assert_array_equal(gate[:, 1], [0, 0, 1, 1, 0])
    np.testing.assert_allclose(gate[[1, 3], 0], [2e-3, 14e-3], rtol=1e-3)


def test_a_current_is_a_current_source():
    drive = {"model": "CurrentSine", "amplitude": 1e-3, "frequency": 25e3}
    text = netlist(scenario(drive=drive), name="c")
    assert element(text, "I_drive_1")[:2] == ["0", "drive"]
    assert element(text, "I_response") == ["0", "drive", "DC", "0", "AC", "1"]


# start


def test_a_jump_at_time_0_divides_by_capacitance_where_nothing_resists():
    path = {"circuit": {"return_path": {"model": "Grounded", "resistance": 0}}}
    text = netlist(scenario(**path), name="c")
    film, skin = (
        float(element(text, f"C_{name}_high")[3].removeprefix("IC="))
        for name in ("insulator", "stratum_corneum")
    )
    capacities = value(text, "C_insulator_high"), value(text, "C_stratum_corneum_high")
    assert film + skin == pytest.approx(100, rel=1e-13)
    assert film * capacities[0] == pytest.approx(skin * capacities[1], rel=1e-13)
    assert "IC=" not in netlist(scenario(), name="c")


def test_initial_charge_is_an_initial_voltage():
    text = netlist(
        scenario(stack={"insulator": FILM | {"initial_charge": 2e-5}, "stratum_corneum": SKIN}), name="c"
    )
    film, skin = (
        float(element(text, f"C_{name}_high")[3].removeprefix("IC="))
        for name in ("insulator", "stratum_corneum")
    )
    assert film + skin == pytest.approx(0.0, abs=1e-12 * skin)  # the plate holds the image: 0 V in all
    charge = skin * value(text, "C_stratum_corneum_high") - film * value(text, "C_insulator_high")
    assert charge == pytest.approx(2e-5 * AREA, rel=1e-13)


def test_a_charged_body_begins_at_its_voltage():
    """Before time 0 the plate is at 0 V: the voltages of film, skin and body add up to nothing."""
    path = {"model": "Floating", "capacitance": 150e-12, "charge": -1e-9}
    stack = {"insulator": FILM | {"initial_charge": 2e-5}, "stratum_corneum": SKIN}
    text = netlist(scenario(stack=stack, circuit={"return_path": path}), name="c")
    film, skin, body = (
        float(element(text, name)[3].removeprefix("IC="))
        for name in ("C_insulator_high", "C_stratum_corneum_high", "C_body")
    )
    assert film + skin + body == pytest.approx(0.0, abs=1e-12 * abs(body))
    held = 150e-12 * body - skin * value(text, "C_stratum_corneum_high")
    assert held == pytest.approx(-1e-9, rel=1e-12)


def test_the_periodic_state_charges_every_capacitor():
    text = netlist(scenario(drive=SQUARE, time={"initial_state": {"model": "PeriodicState"}}), name="c")
    assert len(re.findall(r"^C_\S+ \S+ \S+ \S+ IC=", text, flags=re.MULTILINE)) == 4


def test_a_second_contact_is_the_same_stack_the_other_way():
    path = {"circuit": {"return_path": {"model": "SecondElectrode", "area": AREA / 2}}}
    text = netlist(scenario(**path), name="c")
    assert element(text, "C_second_insulator_high")[0] == "0"
    assert element(text, "C_second_stratum_corneum_high")[1] == "back"
    for part in ("C_{}insulator_high", "C_{}stratum_corneum_1"):
        assert value(text, part.format("")) == pytest.approx(
            2 * value(text, part.format("second_")), rel=1e-14
        )


# force


def evaluated(text, **known):
    functions = {"abs": abs, "ln": math.log, "sin": math.sin, "exp": math.exp, "sqrt": math.sqrt, "pow": pow, "max": max,
                 "min": min}  # fmt: skip
    return eval(text, {"__builtins__": {}}, functions | known)


@given(st.floats(-3, 3), st.floats(-3, 3))
def test_a_formula_computes_what_it_was_written_from(x, y):
    def formula(x, y):
        square = np.square(x) - 2 * x**3 / (1 + y**2) + np.power(y, 7) / 3
        return (
            -np.sqrt(1 + np.abs(x * y))
            + np.exp(-(x**2)) * np.sin(3 - y)
            + np.maximum(x, -1.5)
            - square
            + abs(y) ** 0.5
        )

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


def test_laws_are_written_from_their_printed_equation():
    leak = PolarityConduction(conductivity_positive=5e-6, conductivity_negative=1e-6)
    for law in (leak, FieldConduction(conductivity=2e-6, onset_field=1e4)):
        text = written(law, "current_density", {"E": Formula("x")}, path="stack.gap.leak").text
        for field in (-3e4, 0.0, 2e4):
            ours = float(law.current_density(np.array(field)))
            assert evaluated(text, x=field) == pytest.approx(ours, rel=1e-12, abs=1e-30)


def test_a_law_without_printed_equation_is_run_and_a_strange_one_refused():
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


def test_readings_add_and_scale():
    one, other = MeterReading({"V(a)": 2.0}), MeterReading({"V(a)": 1.0, "I(V_x)": -3.0})
    assert (np.float64(2) * one - other / 2).weights == {"V(a)": 3.5, "I(V_x)": 1.5}
    assert (one + other).text == "3*V(a) - 3*I(V_x)"
    with pytest.raises(TypeError):
        one * other


def test_the_force_is_the_pressure_of_the_amplitudes_times_the_area():
    text = netlist(scenario(), name="c")
    assert " ".join(element(text, "B_amplitude_e")[3:]).endswith("*V(plate,after_insulator)")
    body = "".join(element(text, "B_force")[4:]).replace("V(amplitude_e)", "field")
    assert evaluated(body, field=1e7) == pytest.approx(
        AREA * float(MaxwellStressInGap().pressure(np.array(1e7))), rel=1e-12
    )


def test_the_square_root_of_a_dispersive_skin_is_a_ladder_of_its_own():
    plain = {
        "thickness": 200e-6,
        "material": {"model": "Constant", "permittivity": 1560, "conductivity": 1e-6},
    }
    force = {"model": "Vezzoli2014Causal"}
    assert "filter_1" not in netlist(
        scenario(force=force, stack={"insulator": FILM, "stratum_corneum": plain}), name="c"
    )
    text = netlist(scenario(force=force), name="c")
    sections = re.findall(r"^Rfilter_1_(\d+) filter_1 filter_1_\1 ", text, flags=re.MULTILINE)
    assert len(sections) == len(re.findall(r"^Cfilter_1_", text, flags=re.MULTILINE)) > 2


# refusals

SETTLED = {"time": {"initial_state": {"model": "PeriodicState"}}}
GROWING = {"model": "FieldConduction", "conductivity": 1e-6, "onset_field": 1e4}
SALT = {"thickness": 1e-9, "material": {"model": "Constant", "permittivity": 80, "conductivity": 100}}


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        (SETTLED | {"drive": DRIVES["chirp"]}, "does not repeat"),
        (
            {"contact": {"model": "GrowingArea", "area": 1e-4, "at_force": 0.5, "exponent": 0.5}},
            "contact = GrowingArea: its area follows load and attraction",
        ),
        (
            SETTLED | {"stack": {"insulator": FILM | {"initial_charge": 1e-5}, "stratum_corneum": SKIN}},
            r"stack\.insulator\.initial_charge.*use AtRest",
        ),
        (
            SETTLED | {"stack": {"insulator": FILM, "stratum_corneum": SKIN | {"leak": GROWING}}},
            r"stack\.stratum_corneum\.leak.*use AtRest",
        ),
        (
            {"drive": DRIVES["root"] | {"depth": 0.99999}},
            r"drive = SquareRootModulation: it is a sum of \d+ sines, more than the 500",
        ),
        (
            {"stack": {"insulator": FILM, "sweat": SALT | {"role": "finger"}}},
            r"stack\.insulator: 3\.3e-11 F in series with a conductance of 1e\+07 S.*frequency\.low to .* Hz or more",
        ),
    ],
)
def test_what_has_no_exact_form_is_refused(changes, words, tmp_path):
    path = tmp_path / "circuit.cir"
    path.write_text("older")
    with pytest.raises(InputError, match=words):
        ev.export(scenario(**changes), path, force=True)
    assert path.read_text() == "older"
    assert list(tmp_path.iterdir()) == [path]


def test_a_law_that_is_not_causal_is_refused_and_another_named(tmp_path):
    with pytest.raises(NotCausalError, match=r"not causal.*Use Vezzoli2014Causal"):
        ev.export("vezzoli_2014/fig7", tmp_path / "circuit.cir")
    assert not list(tmp_path.iterdir())


def test_a_law_of_more_than_the_circuit_is_refused(tmp_path):
    with pytest.raises(
        InputError, match=r"force = Persson2018RoughGap: .* another force\.model such as MaxwellStressInGap"
    ):
        ev.export("persson_2018/coating", tmp_path / "circuit.cir")


@pytest.mark.parametrize("name", ["circuit.sp", "circuit", "circuit.net"])
def test_only_known_suffixes(name, tmp_path):
    with pytest.raises(
        InputError, match=rf"{name}: a scenario is exported as \.cir, and its drive as .*, not as"
    ):
        ev.export("vezzoli_2014/fig6", tmp_path / name)


# doors


def without_mark(text: str) -> str:
    """Leave out the checksum, which differs wherever anything else does, and the warnings that a file of it states."""
    return re.sub(r"checksum [0-9a-f]{32}|^\* (warning|not judged): .*\n", "", text, flags=re.MULTILINE)


def test_the_function_keeps_its_name_whatever_is_imported(tmp_path):
    path = ev.export("vezzoli_2014/fig6", tmp_path / "a.cir", set={"drive.high": "500 V"})
    import electrovib.export.save  # binds the package to the name

    assert electrovib.export.save.save is ev.save
    again = ev.export("vezzoli_2014/fig6", tmp_path / "b.cir", set={"drive.high": "500 V"})
    renamed = path.read_text().replace("a.time", "b.time").replace("a.freq", "b.freq")
    assert without_mark(renamed) == without_mark(again.read_text())
    np.testing.assert_array_equal(pwl(path.read_text(), "V_drive_1")[:, 1], [0, 500, 500, 0])


def test_a_trace_is_exported_but_no_sweep(tmp_path):
    trace = ev.simulate(scenario())
    ev.save(trace, tmp_path / "one.nc")
    written_from_trace = ev.export(tmp_path / "one.nc", tmp_path / "c.cir").read_text()
    assert without_mark(written_from_trace) == without_mark(netlist(scenario(), name="c"))
    ev.save(ev.sweep(scenario(), {"drive.level": [1.0, 2.0]}), tmp_path / "many.nc")
    with pytest.raises(InputError, match="many scenarios"):
        ev.export(tmp_path / "many.nc", tmp_path / "d.cir")
    tables = scenario().to_dict() | {"schema": 1}
    assert ev.export(json.loads(json.dumps(tables)), tmp_path / "c.cir").read_text() == written_from_trace


def test_command_line(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(
        sys, "argv", ["electrovib", "export", "vezzoli_2014/fig6", "circuit.cir", "--set", "drive.high=500 V"]
    )
    with pytest.raises(SystemExit) as stop:
        main()
    assert not stop.value.code
    assert capsys.readouterr().out.splitlines() == ["written: circuit.cir", "run it:  ngspice -b circuit.cir"]
    assert Path("circuit.cir").read_text().endswith("\n.end\n")


def test_a_name_with_a_blank_is_quoted_for_the_shell(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "argv", ["electrovib", "export", "vezzoli_2014/fig6", "my circuit.cir"])
    with pytest.raises(SystemExit):
        main()
    assert capsys.readouterr().out.splitlines()[-1] == "run it:  ngspice -b 'my circuit.cir'"


def test_command_line_tells_a_mistake_in_one_line(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "argv", ["electrovib", "export", "vezzoli_2014/fig6", "circuit.txt"])
    with pytest.raises(SystemExit) as stop:
        main()
    assert stop.value.code == 2
    assert (
        capsys.readouterr().err
        == "electrovib: circuit.txt: a scenario is exported as .cir, and its drive as .csv, .npy,"
        " .mat, .wav, .pwl, not as '.txt'.\n"
    )
    assert not list(tmp_path.iterdir())
