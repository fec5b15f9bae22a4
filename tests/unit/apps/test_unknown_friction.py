"""A friction that is unknown is written, drawn and reported as unknown."""

from __future__ import annotations

import numpy as np
import pytest

import electrovib as ev
from electrovib.apps.cli import main
from electrovib.core.errors import InputError

SWIPE = {
    "speed": 0.03,
    "time_profile": {"model": "Swipe", "begin": 0.0, "rise": 0.01, "hold": 0.05, "fall": 0.01},
}


@pytest.fixture(scope="module")
def scenario():
    return ev.load("vezzoli_2014/fig6").replace({"motion": SWIPE})


@pytest.fixture(scope="module")
def trace(scenario):
    return ev.simulate(scenario, time=np.linspace(0, 0.14, 141))


@pytest.mark.parametrize(
    ("speed", "line"),
    [
        ("0.03", "lateral force: 250 mN to 251.3 mN"),
        ("0", "lateral force: not known (the finger rests)"),
    ],
)
def test_the_summary_says_so(speed, line, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(
        "sys.argv", ["electrovib", "run", "vezzoli_2014/fig6", "--set", f"motion.speed={speed}"]
    )
    with pytest.raises(SystemExit) as ended:
        main()
    assert not ended.value.code
    assert line in capsys.readouterr().out.splitlines()


def test_the_summary_says_at_how_many_times(trace):
    from electrovib.apps.cli.run import summary

    said = [line for line in summary(trace, None, None) if line.startswith("lateral force")]
    assert said[0].endswith("mN, not known at 50.4 % of the times (the finger rests)")


@pytest.mark.parametrize("suffix", ["nc", "csv", "mat"])
def test_files_give_it_back(trace, suffix, tmp_path):
    path = tmp_path / f"trace.{suffix}"
    ev.save(trace, path)
    again = ev.open_trace(path)
    assert np.isnan(again.lateral_force.values).sum() == 71
    np.testing.assert_array_equal(again.lateral_force.values, trace.lateral_force.values)


@pytest.mark.slow
def test_plot_and_report_explain_the_gap(trace, scenario, tmp_path):
    ax = ev.plot.lateral_force(trace)
    assert "not known where the finger rests" in [text.get_text() for text in ax.texts]
    assert not ev.plot.force(trace).texts
    still = ev.simulate(scenario.replace({"motion": {"speed": 0.0}}), time=np.linspace(0, 0.1, 11))
    pages = [
        ev.report(each, tmp_path / f"{name}.html").read_text() for name, each in (("a", trace), ("b", still))
    ]
    assert "not known at 50.4 % of the times (the finger rests)" in pages[0]
    assert "not known (the finger rests)" in pages[1]
    assert all("The finger rests" in page for page in pages)


def test_a_sweep_holds_it_beside_what_is_known(scenario):
    rests = scenario.replace({"motion": {"speed": 0.0}})
    swept = ev.sweep(rests, {"motion.speed": [0.0, 0.03]}, quantities=["mean lateral_force"], records=True)
    assert np.all(np.isnan(swept.lateral_force.values[0]))
    assert np.any(np.isfinite(swept.lateral_force.values[1]))
    assert np.isnan(swept["mean lateral_force"].values[0])
    assert np.isfinite(swept["mean lateral_force"].values[1])
    assert "friction at rest" in swept.attrs["validity"]


def test_what_is_not_known_is_not_felt(scenario):
    """Perception uses only windows in which the friction is known, and refuses a record without one."""
    with pytest.raises(InputError, match=r"motion\.speed: the finger rests.*nothing to feel"):
        ev.perceive(scenario.replace({"motion": {"speed": 0.0}}))
    with pytest.raises(InputError, match=r"motion\.time_profile.*every window"):
        ev.perceive(scenario)
    long = scenario.replace({"motion.time_profile.hold": 10.0})
    slides = scenario.replace({"motion": {"speed": 0.03}})
    assert ev.perceive(long).level == pytest.approx(ev.perceive(slides).level, abs=1e-9)
    sine = {"drive": {"model": "Sine", "amplitude": 500.0, "frequency": 5.0}}
    with pytest.raises(InputError, match="rests while"):
        ev.perceive(scenario.replace(sine))
