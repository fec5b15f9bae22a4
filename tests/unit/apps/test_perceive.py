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
    title, answer, level, *rest = out.splitlines()
    assert title == "Vardar 2017: square, 30 Hz"
    assert answer == (
        "felt or not: unknown without perception.threshold and perception.compliance; strongest in the Pacinian channel"
    )
    assert level == (
        "Pacinian: -14.3 dB relative to a sine of equal force at 250 Hz; -14.4 to -13.6 dB under other assumptions"
    )
    limits = "\n".join(rest)
    assert "channel weights: derived, not measured" in limits
    assert "not included: summation over time and area, masking, motion of the finger" in limits
    assert "numerical error" not in limits  # 0.004 dB
    assert len(out.split()) < 150


def test_every_level_and_assumption_is_printed_on_request(cli):
    code, out, err = cli("perceive", "vardar_2017/sine", "--set", "drive.frequency=125 Hz", "--all")
    assert (code, err) == (0, "")
    assert "NonPacinian: nothing" in out  # 250 Hz lies outside its band
    assert "+0.0 dB relative" in out or "-0.0 dB relative" in out
    assert "(cited from memory, unverified)" in out
    assert "threshold: relative only, calibrate with perception.threshold" in out
    assert "12 dB per octave: an assumption" in out
    assert "Sci. Rep. 8, 4555 (2018)" in out
    assert "numerical error" in out


@pytest.mark.parametrize(
    ("threshold", "answer"),
    [
        ("20 nm", "felt, Pacinian channel: +6.3 dB relative to the threshold, which is uncertain by 6 dB"),
        (
            "30 nm",
            "felt or not: undecided within the uncertainty, Pacinian channel: +2.8 dB relative to the threshold",
        ),
        ("200 nm", "not felt, Pacinian channel: -13.7 dB relative to the threshold"),
    ],
)
def test_a_calibrated_person(cli, threshold, answer):
    skin = 'perception.compliance={ model = "ElasticSkin", stiffness = "1 N/mm" }'
    options = [f"perception.threshold={threshold}", "perception.threshold_uncertainty=6", skin]
    arguments = [text for option in options for text in ("--set", option)]
    code, out, _ = cli("perceive", "vardar_2017/sine", *arguments)
    assert code == 0
    assert out.splitlines()[1].startswith(answer)


def test_a_threshold_needs_mechanics(cli):
    options = ["--set", "perception.threshold=20 nm", "--set", "perception.threshold_uncertainty=6"]
    assert "unknown without perception.compliance;" in cli("perceive", "vardar_2017/sine", *options)[1]
    found = ev.perceive(
        "vardar_2017/sine", set={"perception": {"threshold": 20e-9, "threshold_uncertainty": 6.0}}
    )
    assert found.sensation is None


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
    assert out.startswith("measured\nfelt or not: unknown")
    assert "evaluated: lateral force" in out
