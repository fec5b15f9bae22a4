"""Largest values between times: of one record, and of a batch in the same rounds."""

import numpy as np
import pytest

from electrovib.solve.diagnostics.peaks import REFINEMENTS, PeakRecord, crests, refined

EVEN = np.arange(5.0)


def test_a_crest_between_uneven_times_is_that_of_the_parabola():
    times = np.array([0.0, 0.1, 0.19, 0.33, 0.5, 1.0])
    record = PeakRecord(times, {"one": 1 - (times - 0.3) ** 2, "other": -3 + (times - 0.21) ** 2})
    assert record.peaks() == pytest.approx({"one": 1.0, "other": 3.0}, rel=1e-12)


@pytest.mark.parametrize("count", [1, 7])
def test_records_of_a_batch_are_refined_together_each_at_its_own_times(count):
    frequencies, times, asked = np.linspace(1.0, 2.0, count), np.linspace(0.0, 1.3, 14), []

    def rows(frequency, moments):
        turns = 2 * np.pi * frequency * moments
        return {"sine": np.sin(turns - 0.4), "larger": 5 * np.sin(turns - 1.1)}

    def look(cases, moments):
        asked.append(cases)
        return rows(frequencies[cases, None], moments)

    coarse = [PeakRecord(times, rows(each, times)) for each in frequencies]
    found = refined(coarse, look)
    assert 0 < len(asked) <= REFINEMENTS
    for record, start, frequency in zip(found, coarse, frequencies, strict=True):
        assert record.peaks() == pytest.approx({"sine": 1.0, "larger": 5.0}, rel=1e-4)
        assert np.all(np.diff(record.times) > 0)
        (alone,) = refined([start], lambda _, at, f=frequency: rows(f, at))
        assert record.peaks() == alone.peaks()


def test_records_of_different_lengths_have_the_crests_of_each_alone():
    rng, records = np.random.default_rng(2), []
    for count in (5, 40, 17, 3):
        rows = {"one": rng.normal(size=count), "other": np.linspace(-2, 1, count)}
        records.append(PeakRecord(np.sort(rng.random(count)), rows))
    for own, record in zip(crests(records), records, strict=True):
        (alone,) = crests([record])
        for mine, its in zip(own, alone, strict=True):
            np.testing.assert_array_equal(mine, its)
        assert own.places[1] == 0
        assert own.drops[1] == 0.0


def test_new_times_lie_between_the_neighbours_of_a_largest_value():
    times = np.array([0.0, 1.0, 2.0, 2.0 + 1e-16, 3.0, 4.0])
    wanted = PeakRecord(times, {"row": np.array([0.0, 0.1, 1.0, 1.0, 0.2, 0.0])}).unclear()
    assert wanted[0] > 1.0
    assert wanted[-1] < 3.0
    assert len(wanted) == 10  # 13 with both neighbours and the largest value itself


@pytest.mark.parametrize(
    ("times", "row", "peak"),
    [
        # both sides of a discontinuity are the largest that there is
        (np.append(0.5 + 1e-9 * np.arange(-1.0, 4.0), 1.0), [0.0, 0.6, 1.0, 0.7, 0.1, 0.0], 1.0),
        # a corner that is steep on one side only: the parabola through the three lies above it
        (EVEN, [0.98, 0.99, 1.0, 0.5, 0.0], 1.0),
        # a value beside unknown ones stands, and an unknown row stays unknown
        (EVEN, [0.1, 1.0, np.nan, 0.5, 0.5], 1.0),
        (EVEN, [0.0, 2.0, np.inf, 1.0, 1.0], 2.0),
        (EVEN, [np.nan] * 5, np.nan),
    ],
)
def test_where_there_is_no_crest_the_largest_value_stands(times, row, peak):
    np.testing.assert_equal(PeakRecord(times, {"row": np.array(row)}).peaks()["row"], peak)
