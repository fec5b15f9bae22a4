"""What ``electrovib run`` says is felt, as a person uses it, mistakes included."""

from __future__ import annotations

import sys

import pytest

import electrovib as ev
from electrovib.apps.cli import main
from electrovib.core.budget import BudgetError, allowed


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


ANSWER = "felt, Pacinian channel: +35.4 dB (+15.3 to +55.5 dB) relative to published detection thresholds"


def test_a_run_says_whether_it_is_felt_and_all_that_this_assumes_on_request(cli):
    code, out, err = cli("run", "vardar_2017/square")
    assert (code, err) == (0, "")
    title, attraction, friction, felt = out.splitlines()[:4]
    assert title == "Vardar 2017: square, 30 Hz"
    assert (attraction.split(":")[0], friction.split(":")[0]) == ("electrostatic force", "lateral force")
    assert felt == f"{ANSWER} (--all lists assumptions)"
    assert out.count("across 'stratum_corneum' reaches 109 V") == 1
    assert len(out.splitlines()) - out.count("\nwarning: ") - out.count("\nnot judged: ") == 7
    everything = cli("run", "vardar_2017/square", "--all")[1]
    assert everything.count("across 'stratum_corneum' reaches 109 V") == 1
    assert everything.count(title) == 1
    lines = everything.splitlines()
    assert ANSWER in lines
    assert (
        "strongest channel Pacinian: -14.3 dB relative to a sine of equal force at 250 Hz; -14.4 to -13.6 dB under other"
        " assumptions"
    ) in lines
    assert (
        "assumed from publications: a detection threshold and a compliance of the skin; perception.threshold of your own"
        " leaves +-12.1 dB, perception.compliance of your own leaves +-8.0 dB"
    ) in lines


def test_where_it_is_not_known_whether_a_run_is_felt_the_reason_is_stated(cli):
    code, out, err = cli("run", "shultz_2018/at_rest")
    assert (code, err) == (0, "")
    (line,) = [line for line in out.splitlines() if line.startswith("felt or not: ")]
    assert line.startswith("felt or not: not known: motion.speed: the finger rests, where its friction is")


def test_what_is_felt_takes_no_longer_than_its_own_time_unless_all_is_asked_for(cli, monkeypatch):
    asked = []

    def slow(_):
        asked.append(allowed().time)
        raise BudgetError("too long")

    monkeypatch.setattr("electrovib.study.perceive.perceive", slow)
    line = "felt or not: takes more than 30 s to compute (--all takes that time)"
    assert line in cli("run", "vardar_2017/sine")[1].splitlines()
    assert "felt or not: not known: too long" in cli("run", "vardar_2017/sine", "--all")[1].splitlines()
    assert asked == [30.0, 600.0]


def test_a_sweep_has_what_is_felt_as_a_quantity_alone(cli):
    out = cli("run", "vardar_2017/sine", "--over", "drive.frequency=30Hz:60Hz:2")[1]
    assert "felt" not in out


def test_every_level_and_assumption_is_printed_on_request(cli):
    code, out, err = cli("run", "vardar_2017/sine", "--set", "drive.frequency=125 Hz", "--all")
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
    code, out, _ = cli("run", "vardar_2017/sine", *arguments)
    assert code == 0
    assert out.splitlines()[3].startswith(answer)


def test_a_threshold_of_ones_own_leaves_the_compliance_to_be_measured(cli):
    options = ["--set", "perception.threshold=20 nm", "--set", "perception.threshold_uncertainty=6"]
    out = cli("run", "vardar_2017/sine", *options, "--all")[1]
    assert (
        "assumed from publications: a compliance of the skin; perception.compliance of your own leaves +-6.0 dB"
        in out
    )
    assert "published detection thresholds" not in out


def test_a_trace_is_felt_like_its_scenario(cli):
    assert cli("run", "vardar_2017/square", "-o", "a.nc")[0] == 0
    first, second = (cli("run", name)[1].splitlines() for name in ("a.nc", "vardar_2017/square"))
    (own,) = [line for line in second if line not in first]
    assert set(first) < set(second)
    assert own.startswith("values not from vardar_2017")  # a Trace is a file of one's own


def test_nothing_moves(cli):
    code, out, _ = cli("run", "vardar_2017/sine", "--set", 'drive={ model = "Step", level = 0 }')
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
    code, out, err = cli("run", *arguments)
    assert (code, out) == (2, "")
    assert sentence in err
    assert err.count("\n") == 1


def test_the_file_of_a_measurement_is_perceived(cli):
    import numpy as np

    from electrovib.core.trace import make_trace

    time = np.arange(1000) / 1000
    force = 0.3 + 0.1 * np.sin(2 * np.pi * 100 * time)
    ev.save(make_trace({"lateral_force": (("time",), force)}, {"time": time}, {"title": "measured"}), "m.csv")
    code, out, err = cli("run", "m.csv")
    assert (code, err) == (0, "")
    assert "--report: does not belong to a measured Trace" in cli("run", "m.csv", "--report", "m.html")[2]
    assert out.startswith("measured\nfelt, Pacinian channel: +")
    assert "evaluated: lateral force" in cli("run", "m.csv", "--all")[1]
