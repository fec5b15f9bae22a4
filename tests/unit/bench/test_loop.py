"""Drive, record and fit on the simulated bench: the parameters of its finger come back."""

import numpy as np
import pytest

import electrovib as ev

SCENARIO = "vezzoli_2014/fig6"
FRICTION, LEAK = "friction.coefficient", "stack.stratum_corneum.material.conductivity"
FILM = "stack.insulator.thickness"
START = {FRICTION: 0.4, LEAK: 3e-6, FILM: 60e-6}


OF = ev.load(SCENARIO)
TRUE = {
    FRICTION: OF.friction.coefficient,
    LEAK: OF.stack.stratum_corneum.material.conductivity,
    FILM: OF.stack.insulator.thickness,
}
"""The finger of the simulated bench."""


def fitted(seed, **options):
    trace = ev.run_bench(SCENARIO, simulate=True, seed=seed, **options)
    found = ev.fit(
        ev.load(SCENARIO, changes=START),
        ev.Recordings(traces=trace, quantity=["lateral_force"]),
        free=list(START),
    )
    return {row.name: row for row in found.rows}


def test_a_recording_of_the_bench_gives_its_finger_back(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    rows = fitted(1, output="t.nc")
    for name, value in TRUE.items():
        assert abs(rows[name].value - value) < 4 * rows[name].standard_error
        assert 0 < rows[name].standard_error < 0.2 * value
    again = ev.fit(SCENARIO, ev.Recordings(traces="t.nc", quantity=["lateral_force"]), free=[FRICTION])
    assert again.rows[0].value == pytest.approx(rows[FRICTION].value, rel=1e-3)


def test_another_finger_is_found_and_not_the_one_that_was_planned():
    finger = ev.load(SCENARIO, changes={FRICTION: 0.55, FILM: "70 um"})
    rows = fitted(2, finger=finger)
    assert abs(rows[FRICTION].value - 0.55) < 4 * rows[FRICTION].standard_error
    assert abs(rows[FILM].value - 70e-6) < 4 * rows[FILM].standard_error < 20e-6


@pytest.mark.slow
def test_intervals_hold_the_parameters_in_89_of_100_seeds():
    hits = dict.fromkeys(START, 0)
    for seed in range(100):
        rows = fitted(seed)
        for name, value in TRUE.items():
            hits[name] += rows[name].lower <= value <= rows[name].upper
    assert min(hits.values()) >= 89, hits


def test_the_same_seed_gives_the_same_recording_and_another_one_another():
    first, again, other = (ev.run_bench(SCENARIO, simulate=True, seed=seed) for seed in (1, 1, 2))
    assert np.array_equal(first.lateral_force, again.lateral_force)
    assert not np.array_equal(first.lateral_force, other.lateral_force)
