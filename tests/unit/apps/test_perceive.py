"""``electrovib perceive`` as a person uses it, mistakes included."""

from __future__ import annotations

import sys

import pytest

import electrovib as ev
from electrovib.apps.cli import main


@pytest.fixture
def cli(tmp_path, capsys, monkeypatch):
    """Return a function that runs a command in this process: exit code, output and error output."""
    monkeypatch.chdir(tmp_path)

    def call(*arguments: str) -> tuple[int, str, str]:
        monkeypatch.setattr(sys, "argv", ["electrovib", *arguments])
        with pytest.raises(SystemExit) as stop:
            main()
        out, err = capsys.readouterr()
        return int(stop.value.code or 0), out, err

    return call


def test_the_answer_comes_first_and_its_limits_after(cli):
    code, out, err = cli("perceive", "vardar_2017/square")
    assert (code, err) == (0, "")
    lines = out.splitlines()
    told = [line for line in lines if line.startswith(("warning: ", "not judged: "))]
    assert sum("across 'stratum_corneum' reaches 109 V" in line for line in told) == 1
    title, answer, measure, chosen = (line for line in lines if line not in told)
    assert title == "Vardar 2017: square, 30 Hz"
    assert answer == (
        "felt, Pacinian channel: +35.4 dB (+15.3 to +55.5 dB) relative to published detection thresholds"
    )
    assert measure.endswith(" (--all lists assumptions)")
    level = (
        "strongest channel Pacinian: -14.3 dB relative to a sine of equal force at 250 Hz; -14.4 to -13.6 dB under other"
        " assumptions"
    )
    assert level not in lines
    assert level in cli("perceive", "vardar_2017/square", "--all")[1].splitlines()
    assert measure.startswith(
        "assumed from publications: a detection threshold and a compliance of the skin; "
    )
    assert "perception.threshold of your own leaves +-12.1 dB" in measure
    assert chosen.startswith("values not from vardar_2017")
    assert len(out.split()) - len(" ".join(told).split()) < 150


def test_every_level_and_assumption_is_printed_on_request(cli):
    code, out, err = cli("perceive", "vardar_2017/sine", "--set", "drive.frequency=125 Hz", "--all")
    assert (code, err) == (0, "")
    assert "NonPacinian: nothing" in out  # 250 Hz lies outside its band
    assert "+0.0 dB relative" in out or "-0.0 dB relative" in out
    assert "(cited from memory, unverified)" in out
    assert (
        "assumed threshold, Pacinian: 30 nm at 150 Hz, grasped cylinder, tangential, whole hand (second-hand: "
        in out
    )
    assert "assumed compliance, softest: 323 N/m" in out
    assert "channel weights: derived, not measured" in out
    assert "left out: summation over time and area, masking" in out
    assert "12 dB per octave: an assumption" in out
    assert "Sci. Rep. 8, 4555 (2018)" in out
    assert "numerical error" in out


@pytest.mark.parametrize(
    ("threshold", "answer"),
    [
        ("20 nm", "felt, Pacinian channel: +6.3 dB (+0.3 to +12.3 dB) relative to the detection threshold"),
        (
            "30 nm",
            "felt or not: undecided within the spread, Pacinian channel: +2.8 dB (-3.2 to +8.8 dB) relative to",
        ),
        (
            "200 nm",
            "not felt, Pacinian channel: -13.7 dB (-19.7 to -7.7 dB) relative to the detection threshold",
        ),
    ],
)
def test_a_calibrated_person(cli, threshold, answer):
    skin = 'perception.compliance={ model = "ElasticSkin", stiffness = "1 N/mm" }'
    options = [f"perception.threshold={threshold}", "perception.threshold_uncertainty=6", skin]
    arguments = [text for option in options for text in ("--set", option)]
    code, out, _ = cli("perceive", "vardar_2017/sine", *arguments)
    assert code == 0
    assert out.splitlines()[1].startswith(answer)


def test_a_threshold_of_ones_own_leaves_the_compliance_to_be_measured(cli):
    options = ["--set", "perception.threshold=20 nm", "--set", "perception.threshold_uncertainty=6"]
    out = cli("perceive", "vardar_2017/sine", *options)[1]
    assert (
        "assumed from publications: a compliance of the skin; perception.compliance of your own leaves +-6.0 dB"
        in out
    )
    assert "published detection thresholds" not in out


def test_a_trace_is_perceived_like_its_scenario(cli):
    assert cli("run", "vardar_2017/square", "-o", "a.nc")[0] == 0
    first, second = cli("perceive", "a.nc")[1], cli("perceive", "vardar_2017/square")[1]
    assert second.startswith(first)
    rest = second.removeprefix(
        first
    )  # a Trace is a file of one's own, a paper's scenario says what it chooses
    assert rest.startswith("values not from vardar_2017")
    assert rest.count("\n") == 1


def test_nothing_moves(cli):
    code, out, _ = cli("perceive", "vardar_2017/sine", "--set", 'drive={ model = "Step", level = 0 }')
    assert code == 0
    assert "not felt: nothing moves the skin" in out


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["vardar_2017/sin"], "Did you mean 'vardar_2017/sine' ("),
        (["vardar_2017/sine", "--set", "perception.treshold=2"], "Did you mean 'threshold'?"),
        (["vardar_2017/sine", "--set", "perception.threshold=2 V"], "expected a length"),
        (["vardar_2017/sine", "--set", "drive.frequency"], "expected PATH=VALUE"),
        (["nothing.nc"], "nothing.nc"),
        (
            [
                "vezzoli_2014/fig6",
                "--set",
                "force.model=Vezzoli2014PerFrequency",
                "--set",
                'drive={ model = "Square", high = 9, low = 0, frequency = 9 }',
            ],
            "not causal",
        ),
    ],
)
def test_a_mistake_is_one_line_and_exit_code_2(cli, arguments, sentence):
    code, out, err = cli("perceive", *arguments)
    assert (code, out) == (2, "")
    assert sentence in err
    assert err.count("\n") == 1


def test_the_file_of_a_measurement_is_perceived(cli):
    import numpy as np

    from electrovib.core.trace import make_trace

    time = np.arange(1000) / 1000
    force = 0.3 + 0.1 * np.sin(2 * np.pi * 100 * time)
    ev.save(make_trace({"lateral_force": (("time",), force)}, {"time": time}, {"title": "measured"}), "m.csv")
    code, out, err = cli("perceive", "m.csv")
    assert (code, err) == (0, "")
    assert out.startswith("measured\nfelt, Pacinian channel: +")
    assert "evaluated: lateral force" in cli("perceive", "m.csv", "--all")[1]
