"""The compiled recursion of long records compared with the plain loop, closed forms and the method without a compiler."""

import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from electrovib.solve.recursion import long_records, march, march_loop, march_rows
from electrovib.solve.recursion.inputs import of_values
from electrovib.solve.recursion.record import StraightDrive

SAME = 1e-12
RATES = st.lists(st.floats(-7, 3).map(lambda power: 10.0**power), min_size=1, max_size=20)  # over the step


@pytest.fixture
def compiled(monkeypatch):
    """Send every record of equal steps through the compiled recursion."""
    pytest.importorskip("numba")
    monkeypatch.setattr(long_records, "_WORTH", 0)
    if long_records._kernel() is None:
        pytest.skip("no vectors on this processor")


@settings(deadline=None, max_examples=25)
@given(seed=st.integers(0, 10**6), rates=RATES, samples=st.integers(2, 3000))
def test_the_compiled_recursion_is_the_loop(seed, rates, samples):
    pytest.importorskip("numba")
    generator, modes = np.random.default_rng(seed), len(rates)
    drive, lag = np.cumsum(generator.normal(size=samples)), np.array([False, True, False])
    given_ = {"poles": -np.array(rates), "gains": generator.normal(size=(3, modes))}
    given_ |= {"direct": generator.normal(size=3), "starts": drive[:-1], "ends": drive[1:], "steps": 1.0}
    given_ |= {"initial_state": generator.normal(size=modes)}
    expected, final = march_loop(**given_, lag=lag)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(long_records, "_WORTH", 0)
        found, state = march(**given_, lag=lag)
        rows = march_rows(**given_, lag=lag)
    size = np.max(np.abs(drive)) * (np.abs(given_["gains"]).sum() + np.abs(given_["direct"]).sum() + 1) + 10
    assert np.max(np.abs(found - expected)) <= SAME * size
    assert np.max(np.abs(state - final)) <= SAME * size
    assert np.array_equal(rows, found)


def test_slow_modes_keep_their_digits(compiled):
    """The response to 1 V from rest after very many samples is one exponential for each mode."""
    count, step = 1_000_000, 1e-6
    rates = np.array([0.3, 0.7, 1.1, 13.0])
    drive = np.ones(count)
    found, state = march(-rates, np.eye(4), np.zeros(4), drive[:-1], drive[1:], step, np.zeros(4))
    expected = -np.expm1(-rates[:, np.newaxis] * step * np.arange(count))
    assert np.max(np.abs(found - expected)) < 5e-14
    assert np.max(np.abs(state - expected[:, -1])) < 5e-14


@pytest.mark.parametrize("modes", [1, 12, 19])
def test_a_second_thread_changes_no_bit(compiled, monkeypatch, modes):
    """It begins with the state that the first thread computes too, at the same place of the record."""
    random = np.random.default_rng(modes)
    drive, rates = np.cumsum(random.normal(size=300_005)), 10.0 ** random.uniform(-6, 0, modes)
    gains, direct, state = random.normal(size=(2, modes)), random.normal(size=2), random.normal(size=modes)
    found, begun = [], []

    class Counted(long_records.ThreadPoolExecutor):
        def submit(self, *given):
            begun.append(given)
            return super().submit(*given)

    monkeypatch.setattr(long_records, "ThreadPoolExecutor", Counted)
    for threads in (1, 2):
        monkeypatch.setattr(long_records, "_THREADS", threads)
        monkeypatch.setattr(long_records, "_LEAST", 32)
        assert not begun
        found.append(march(-rates, gains, direct, drive[:-1], drive[1:], 1.0, state))
    assert len(begun) == 1
    assert np.array_equal(found[0][0], found[1][0])
    assert np.array_equal(found[0][1], found[1][1])
    expected, _ = march_loop(-rates, gains, direct, drive[:3000], drive[1:3001], 1.0, state)
    assert np.max(np.abs(found[1][0][:, :3001] - expected)) <= SAME * np.max(np.abs(expected)) * modes


def test_two_threads_share_the_work_at_whole_groups_of_blocks():
    cut = long_records._cut(10**6, 144, 160, 512)
    assert cut % 512 == 0
    first, second = cut * (144 + 160), cut * 144 + (10**6 - cut) * (144 + 160)
    assert abs(first / second - 1) < 0.01
    assert long_records._cut(512 * long_records._LEAST - 1, 144, 160, 512) == 0


def test_what_goes_through_it(compiled, monkeypatch):
    """Real modes, every sample, a continuous drive, and enough of it."""
    drive, z = np.zeros(1000), -np.ones(3)
    straight = of_values(StraightDrive(drive[:-1], drive[1:], np.asarray(1.0)), z)
    jumping = of_values(StraightDrive(drive[:-1], drive[1:] + 1.0, np.asarray(1.0)), z)
    gains = np.ones((2, 3))
    assert long_records.is_long(gains, straight, 1)
    assert not long_records.is_long(gains, straight, 2)
    assert not long_records.is_long(gains, jumping, 1)
    assert not long_records.is_long(gains.astype(complex), straight, 1)
    monkeypatch.setattr(long_records, "_WORTH", 2 * 999 + 1)
    assert not long_records.is_long(gains, straight, 1)
    monkeypatch.setattr(long_records, "_WORTH", 2 * 999)
    assert long_records.is_long(gains, straight, 1)
    monkeypatch.setattr(long_records, "_kernel", lambda: None)
    assert not long_records.is_long(gains, straight, 1)


def test_without_numba_the_response_is_the_same(monkeypatch):
    monkeypatch.setattr(long_records, "_WORTH", 0)
    long_records._kernel.cache_clear()
    monkeypatch.setitem(sys.modules, "electrovib.solve.recursion.vectors.width", None)
    drive = np.sin(np.arange(500))
    given_ = [-0.1, -2.0], [[1.0, 0.5]], [0.2], drive[:-1], drive[1:], 1.0, [0.0, 0.0]
    try:
        found, _ = march(*given_)
        assert long_records._kernel() is None
    finally:
        long_records._kernel.cache_clear()
    assert np.max(np.abs(found - march_loop(*given_)[0])) < 1e-14


def test_the_compiler_is_not_loaded_for_usual_records():
    code = """
import sys, numpy as np, electrovib.solve.recursion as recursion
drive = np.ones(100_000)
recursion.march([-1.0] * 40, [[1.0] * 40], [0.0], drive[1:], drive[1:], 1.0, [0.0] * 40)
print("numba" in sys.modules)
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "False"
