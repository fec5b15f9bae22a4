"""Coverage and bias of fits of 1000 synthetic recordings of each kind, jointly, and over sessions that differ."""

import importlib.util
from pathlib import Path

import numpy as np
import pytest

from electrovib.recordings.fit import MeasuredTrace, fit_scenario

_place = Path(__file__).parents[1] / "unit" / "recordings" / "twins.py"
_spec = importlib.util.spec_from_file_location("twins", _place)
twins = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(twins)

pytestmark = pytest.mark.slow
COUNT = 1000
FREE = {"step": (twins.GAP, twins.LEAK)}  # 60 samples of one step determine these two well
PLATE = twins.plate()


def judge(estimates, inside, true):
    """95 % intervals hold the true value in 93 to 97 % of all cases; the mean misses it by less than 0.1 deviations."""
    covered = np.mean(inside, axis=0)
    assert ((covered > 0.93) & (covered < 0.97)).all(), covered
    found = np.array(estimates)
    bias = (found.mean(axis=0) - true) / found.std(axis=0, ddof=1)
    assert (np.abs(bias) < 0.1).all(), bias


@pytest.mark.parametrize("kinds", [("step",), ("sweep",), ("impedance",), ("step", "sweep", "impedance")])
def test_intervals_cover_and_estimates_are_unbiased(kinds):
    free, rng = FREE.get("".join(kinds), twins.FREE), np.random.default_rng(11)
    exact = {kind: twins.exact(PLATE, kind) for kind in kinds}
    true = [twins.truth(PLATE)[name] for name in free]
    estimates, inside = [], []
    for _ in range(COUNT):
        data = [MeasuredTrace(trace=twins.noisy(each, rng), name=kind) for kind, each in exact.items()]
        found = fit_scenario(PLATE, data, free=free)
        assert "not" not in found.states.values()
        estimates.append([found.estimate.values[name] for name in free])
        intervals = [found.interval(name) for name in free]
        inside.append([low <= value <= high for (low, high), value in zip(intervals, true, strict=True)])
    judge(estimates, inside, true)


@pytest.mark.parametrize("count", [2, 6])
def test_the_mean_over_sessions_is_covered(count):
    """A gap with 5 % of scatter between sessions and a shared insulator."""
    rng = np.random.default_rng(12)
    true = twins.truth(PLATE)
    estimates, inside = [], []
    for _ in range(COUNT):
        gaps = true[twins.GAP] * (1 + 0.05 * rng.normal(size=count))
        data = [
            MeasuredTrace(
                trace=twins.noisy(twins.exact(PLATE.replace({twins.GAP: gap}), "impedance"), rng),
                name=str(at),
                session=str(at),
            )
            for at, gap in enumerate(gaps)
        ]
        found = fit_scenario(PLATE, data, free=[twins.GAP, twins.FILM], varying=[twins.GAP])
        spread = found.sessions[twins.GAP]
        intervals = [spread.interval(), found.interval(twins.FILM)]
        estimates.append([spread.mean, found.estimate.values[twins.FILM]])
        inside.append(
            [
                low <= true[name] <= high
                for (low, high), name in zip(intervals, (twins.GAP, twins.FILM), strict=True)
            ]
        )
    judge(estimates, inside, [true[twins.GAP], true[twins.FILM]])


def test_profile_intervals_cover():
    """100 recordings that determine the leak weakly: its profile interval holds the true value in 89 to 99 of them."""
    rng = np.random.default_rng(13)
    exact, true = twins.exact(PLATE, "step"), twins.truth(PLATE)[twins.LEAK]
    inside = 0
    for _ in range(100):
        found = fit_scenario(PLATE, twins.noisy(exact, rng, noise=0.03), free=twins.FREE)
        interval = found.profile(twins.LEAK)
        inside += interval.lower <= true <= interval.upper
    assert 89 <= inside <= 99
