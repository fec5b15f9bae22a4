"""Modes of many cases under straight pieces: the numbers of a plain loop, digits, and cases that do not depend on each other."""

import numpy as np
import pytest
from plain_recursion import march_loop

from electrovib.physics.drive.parts import Linear
from electrovib.solve.electrics.rows import NOTHING, Rows, in_rows
from electrovib.solve.electrics.straight import SharedModes

SAME = 1e-12
END = 7e-3
TIMES = {
    "even": np.linspace(0.0, END, 701),
    "from later on": np.linspace(3e-3, END, 300),
    "uneven": np.cumsum(np.random.default_rng(1).exponential(1e-5, 500)),
    "one": np.array([2e-3]),
    "at 0": np.array([0.0]),
}
BREAKS = {
    "few": np.array([0.0, 1e-3, 1.00000003e-3, 4.2e-3]),
    "some at outputs": np.linspace(0.0, END, 8),
    "many": np.linspace(0.0, END, 40) + np.append(0.0, np.random.default_rng(2).uniform(0, 1e-4, 39)),
    "a step": np.zeros(1),
}


def modes(cases, count, *, lag=False, seed=3):
    """Rates over nine decades, gains of both signs."""
    random = np.random.default_rng(seed)
    rates = 10 ** random.uniform(-2, 7, (cases, count))
    gains, direct = random.normal(size=(cases, 2, count)), random.normal(size=(cases, 2))
    return SharedModes(rates, gains, direct, np.full(2, lag))


def drive(breaks):
    """Jumps at each break, straight between them."""
    random = np.random.default_rng(4)
    before, after = random.normal(size=(2, len(breaks)))
    return Linear(breaks, np.append(0.0, before[1:]), after)


def expected(given, part, times, begin, case):
    """Outputs of one case from a loop over all breaks and times."""
    whole = np.unique(np.concatenate([[0.0], part.times[part.times <= times[-1]], times]))
    starts, ends = part.value(whole[:-1]), part.value_before(whole[1:])
    rates = given.rates[case]
    own = [given.gains[case], given.direct[case], starts, ends, np.diff(whole)]
    found = march_loop(-rates, *own, begin[case])[0] if len(whole) > 1 else None
    rows = np.empty((2, len(whole)))
    if found is not None:
        rows = found.copy()
    if found is None or part.value(whole[-1:])[0] != ends[-1]:
        last = part.value(whole[-1:])[0] - (ends[-1] if len(whole) > 1 else 0.0)
        rows[:, -1] = (
            rows[:, -1] if found is not None else given.gains[case] @ begin[case]
        ) + last * given.direct[case]
    if np.any(given.lag):
        rows = rows - given.gains[case].sum(axis=1)[:, None] * part.value(whole)
    return rows[:, np.searchsorted(whole, times)]


@pytest.mark.parametrize("lag", [False, True])
@pytest.mark.parametrize("breaks", BREAKS)
@pytest.mark.parametrize("kind", TIMES)
def test_responses_are_those_of_the_plain_loop(kind, breaks, lag):
    given, part, times = modes(5, 4, lag=lag), drive(BREAKS[breaks]), TIMES[kind]
    begin = np.random.default_rng(5).normal(size=(5, 4))
    found = in_rows(given, part, times, begin)(slice(0, 5))
    for case in range(5):
        for mine, its in zip(found, expected(given, part, times, begin, case), strict=True):
            assert np.max(np.abs(mine[case] - its)) <= SAME * max(1.0, np.max(np.abs(its)))


def test_a_case_does_not_depend_on_the_company():
    given, part, times = modes(300, 3), drive(BREAKS["few"]), TIMES["even"]
    through = in_rows(given, part, times, np.zeros((300, 3)))
    whole = through(slice(0, 300))
    for some in (slice(0, 1), slice(3, 40), slice(290, 300)):
        for mine, its in zip(through(some), whole, strict=True):
            assert np.max(np.abs(mine - its[some])) <= 1e-14 * np.max(np.abs(its))


def test_what_all_cases_share_is_one_case():
    given, part, times = modes(1, 3), drive(BREAKS["few"]), TIMES["even"]
    shared = SharedModes(given.rates, np.repeat(given.gains, 3, axis=0), given.direct, given.lag)
    found = in_rows(shared, part, times, np.zeros((1, 3)))(slice(1, 3))
    alone = in_rows(given, part, times, np.zeros((1, 3)))(slice(1, 3))
    for several, one in zip(found, alone, strict=True):
        assert (several.shape, one.shape) == ((2, len(times)), (1, len(times)))
        assert np.allclose(several, one, rtol=0, atol=1e-14 * np.max(np.abs(one)))


def test_digits_are_kept():
    """Of a lag where the mode follows, and of modes that are slow beside the record, integrators among them.

    Behind a ramp of 1 V/s a mode lags by 1/rate. The response of a slow mode to 1 V from rest is one exponential.
    """
    ramp, times = (
        Linear(np.array([0.0, 2.0]), np.array([0.0, 2.0]), np.array([0.0, 2.0])),
        np.linspace(0.0, 1.0, 1001),
    )
    one, none = np.ones((1, 1, 1)), np.zeros((1, 1))
    lagging = SharedModes(np.array([[1e9]]), one, none, np.array([True]))
    (found,) = in_rows(lagging, ramp, times, none)(slice(0, 1))
    assert np.allclose(found[0, 1:], -1e-9, rtol=1e-13, atol=0)
    (found,) = in_rows(SharedModes(np.array([[0.0]]), one, none, np.array([True])), ramp, times, none)(
        slice(0, 1)
    )
    assert np.allclose(found[0], -times, rtol=1e-13, atol=0)

    step, rates = Linear(np.zeros(1), np.zeros(1), np.ones(1)), np.array([[1.0], [1e-3], [1e-30], [0.1]])
    slow = SharedModes(rates, np.ones((4, 1, 1)), np.zeros((4, 1)), np.array([False]))
    (found,) = in_rows(slow, step, times, np.zeros((4, 1)))(slice(0, 4))
    assert np.allclose(found, -np.expm1(-rates * times), rtol=2e-13, atol=0)


def test_a_drive_of_nothing_leaves_what_decays_and_what_is_trapped():
    rates, times = np.array([[0.0, 10.0, 5e3]]), np.linspace(0.0, 1.0, 77)
    left = SharedModes(rates, np.array([[[1.0, 2.0, 3.0]]]), np.zeros((1, 1)), np.zeros(1, bool))
    (found,) = in_rows(left, NOTHING, times, np.ones(rates.shape))(slice(0, 1))
    assert np.allclose(found[0], [1, 2, 3] @ np.exp(-np.outer(rates[0], times)), rtol=1e-13, atol=0)


def test_no_row_of_times_crosses_a_break_and_even_times_have_long_rows():
    times = TIMES["even"]
    found = Rows(drive(BREAKS["few"]), times)
    assert len(found.piece) + len(found.since) < 4 * np.sqrt(len(times))
    assert np.array_equal(np.unique(found.piece), [0, 1, 2, 3])
    assert len(Rows(NOTHING, TIMES["uneven"]).since) == 1
