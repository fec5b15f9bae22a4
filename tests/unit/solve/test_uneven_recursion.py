"""The compiled recursion of unequal pieces compared with the plain loop and the method without a compiler."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from plain_recursion import march_loop

from electrovib.solve.recursion import hold_weights, march, states_at, uneven
from electrovib.solve.recursion.hold import SLOW, StraightDrive

SAME = 1e-12  # of the largest possible output; some thousand roundings of 1.1e-16 at most
RATES = st.lists(st.floats(-6, 4).map(lambda power: 10.0**power), max_size=12)  # over the mean piece
KINDS = ("jitter", "pauses", "bursts", "repeats")


@pytest.fixture
def compiled(monkeypatch):
    """Send every record of unequal pieces through the compiled recursion."""
    pytest.importorskip("numba")
    monkeypatch.setattr(uneven, "_WORTH", 0)


def durations(kind, generator, pieces):
    """Of the pieces, over the usual one."""
    if kind == "jitter":
        return 1 + generator.uniform(-0.4, 0.4, pieces)
    if kind == "pauses":
        return np.where(generator.random(pieces) < 0.02, 300.0, 1 + generator.uniform(-0.1, 0.1, pieces))
    if kind == "bursts":
        return generator.choice([1.0, 20.0], pieces)
    return np.where(generator.random(pieces) < 0.1, 0.0, generator.exponential(1.0, pieces))


def record(seed, kind, rates, pieces):
    """Arguments of a march: jumps, both kinds of outputs, a state that is not at rest."""
    generator = np.random.default_rng(seed)
    drive, modes = np.cumsum(generator.normal(size=pieces + 1)), len(rates)
    starts = drive[:-1] + 3 * (generator.random(pieces) < 0.05)
    given_ = {"poles": -np.array(rates, float), "gains": generator.normal(size=(3, modes))}
    given_ |= {"direct": generator.normal(size=3), "starts": starts, "ends": drive[1:]}
    given_ |= {"steps": durations(kind, generator, pieces), "initial_state": generator.normal(size=modes)}
    return given_


def size_of(given_):
    """Largest output there could be."""
    drive = np.max(np.abs(given_["starts"])) + np.max(np.abs(given_["ends"]))
    return (drive + 3) * (np.abs(given_["gains"]).sum() + np.abs(given_["direct"]).sum() + 1)


@settings(deadline=None, max_examples=30)
@given(seed=st.integers(0, 10**6), kind=st.sampled_from(KINDS), rates=RATES, pieces=st.integers(2, 3000))
def test_the_compiled_recursion_is_the_loop(seed, kind, rates, pieces):
    """Outputs and states at places, those of the method without a compiler."""
    pytest.importorskip("numba")
    given_, lag = record(seed, kind, rates, pieces), np.array([False, True, True])
    where = np.random.default_rng(seed).integers(0, pieces + 1, 40)
    places = np.unique(np.concatenate([[0, 1, pieces - 1, pieces], where]))
    drive = [given_[name] for name in ("poles", "starts", "ends", "steps", "initial_state")]
    expected, final = march_loop(**given_, lag=lag)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(uneven, "_WORTH", 10**12)
        at_places = states_at(*drive, places)
        patch.setattr(uneven, "_WORTH", 0)
        patch.setattr(uneven, "PRODUCT", 10_000)  # a hundred pieces of ten modes together
        found, state = march(**given_, lag=lag)
        compiled_at_places = states_at(*drive, places)
    size = SAME * size_of(given_)
    assert np.max(np.abs(found - expected)) <= size
    assert np.max(np.abs(state - final), initial=0) <= size
    assert np.max(np.abs(compiled_at_places - at_places), initial=0) <= size


def test_a_lag_keeps_its_digits(compiled):
    """Of a mode far faster than the pieces the lag is the slope over its rate, to rounding of itself."""
    generator, rate = np.random.default_rng(2), 1e9
    steps = 1 + generator.uniform(-0.2, 0.2, 500)
    drive = generator.normal(size=501)
    state = np.array([drive[0]])
    found, _ = march([-rate], [[1.0]], [0.0], drive[:-1], drive[1:], steps, state, lag=[True])
    expected = -np.diff(drive) / steps / rate
    assert np.max(np.abs(found[0, 1:] / expected - 1)) < 1e-14


def test_what_goes_through_it(monkeypatch):
    """Many modes times pieces, and real ones."""
    pytest.importorskip("numba")
    drive, poles = StraightDrive(np.zeros(1000), np.zeros(1000), np.arange(1000.0)), -np.ones(1000)
    assert uneven._compiled(poles, drive) is not None
    assert uneven._compiled(poles.astype(complex), drive) is None
    monkeypatch.setattr(uneven, "_WORTH", 1_000_001)
    assert uneven._compiled(poles, drive) is None


@pytest.mark.parametrize("in_compiled_code", [False, True])
@pytest.mark.parametrize("rate", [1e-30, 1e-6, 1.0, 30.0])
def test_a_huge_drive_for_a_moment_leaves_what_its_moment_brings(monkeypatch, in_compiled_code, rate):
    """Steps over twelve decades: each keeps its own digits, however much longer the longest is."""
    if in_compiled_code:
        pytest.importorskip("numba")
    monkeypatch.setattr(uneven, "_WORTH", 0 if in_compiled_code else 10**12)
    steps = np.geomspace(1e-13, 0.1, 60)
    ends = 1e11 * np.exp(-np.arange(1, 61) * 2.0)
    starts = np.append(1e11, ends[:-1])
    places = np.array([0, 1, 10, 60])
    found = states_at(np.array([-rate]), starts, ends, steps, np.zeros(1), places)[0]
    decays, first, last = (np.asarray(each) for each in hold_weights(-rate * steps))
    expected = [0.0]
    for decay, early, late, begin, end in zip(decays, first, last, starts, ends, strict=True):
        expected.append(decay * expected[-1] + early * begin + late * end)
    np.testing.assert_allclose(found, np.array(expected)[places], rtol=1e-12)


@pytest.mark.parametrize("fall", [1e-9, 1e-3, 0.999 * SLOW, 1.001 * SLOW, 0.9, 7.0])
@pytest.mark.parametrize("share", [0.02, 0.3, 0.6, 0.99, 1.0, 50.0])
def test_what_one_ramp_leaves_is_its_weight(compiled, fall, share):
    """From rest, in a usual piece, in a short one, and in a pause among a hundred usual ones."""
    steps = np.append(share, np.ones(100))
    drive = np.append(0.0, np.ones(101))
    places = np.array([0, 1])
    found = states_at([-fall], drive[:-1], drive[1:], steps, [0.0], places)[0, 1]
    expected = hold_weights(-fall * share)[2]
    # some ten roundings of 1.1e-16 of a slow mode; of another one, the drive less its lag, of the drive
    assert abs(found - expected) < (4e-15 * expected if fall < SLOW else 1e-15)


@pytest.mark.parametrize("fall", [3.0, 10.0, 20.0, 40.0])
def test_what_is_left_of_a_lag_is_exact(compiled, fall):
    """Without a drive a lag decays by its exponential, wherever the piece lies between two of the table."""
    for share in np.linspace(0.31, 0.99, 41):
        found, _ = march([-fall], [[1.0]], [0.0], [0, 0], [0, 0], [share, 1.0], [1.0])
        assert abs(found[0, 1] - np.exp(-fall * share)) < 3e-16
