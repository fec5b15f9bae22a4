"""Largest values between times: of one record, and of a batch in the same rounds."""

from __future__ import annotations

import numpy as np
import pytest

from electrovib.solve.diagnostics.peaks import REFINEMENTS, PeakRecord, crests, refined


def test_a_crest_between_uneven_times_is_that_of_the_parabola():
    times = np.array([0.0, 0.1, 0.19, 0.33, 0.5, 1.0])
    record = PeakRecord(times, {"one": 1 - (times - 0.3) ** 2, "other": -3 + (times - 0.21) ** 2})
    assert record.peaks() == pytest.approx({"one": 1.0, "other": 3.0}, rel=1e-12)


@pytest.mark.parametrize("count", [1, 7])
def test_records_of_a_batch_are_refined_together_each_at_its_own_times(count):
    frequencies = np.linspace(1.0, 2.0, count)
    times, asked = np.linspace(0.0, 1.3, 14), []
    names = {"sine": (1.0, -0.4), "larger": (5.0, -1.1)}

    def rows(frequency, moments):
        waves = {name: phase + 2 * np.pi * frequency * moments for name, (_, phase) in names.items()}
        return {name: names[name][0] * np.sin(wave) for name, wave in waves.items()}

    def look(cases, moments):
        asked.append(cases)
        return rows(frequencies[cases, None], moments)

    coarse = [PeakRecord(times, rows(each, times)) for each in frequencies]
    found = refined(coarse, look)
    for record in found:
        assert record.peaks() == pytest.approx({"sine": 1.0, "larger": 5.0}, rel=1e-4)
        assert np.all(np.diff(record.times) > 0)
    assert 0 < len(asked) <= REFINEMENTS
    alone = [
        refined([each], lambda _, at, f=f: rows(f, at))[0]
        for each, f in zip(coarse, frequencies, strict=True)
    ]
    assert [each.peaks() for each in found] == [each.peaks() for each in alone]


def test_records_of_different_lengths_have_the_crests_of_each_alone():
    rng = np.random.default_rng(2)
    counts = (5, 40, 17, 3)
    records = [
        PeakRecord(
            np.sort(rng.random(count)), {"one": rng.normal(size=count), "other": np.linspace(-2, 1, count)}
        )
        for count in counts
    ]
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


def test_both_sides_of_a_discontinuity_are_the_largest_that_there_is():
    times = np.append(0.5 + 1e-9 * np.arange(-1.0, 4.0), 1.0)
    record = PeakRecord(times, {"row": np.array([0.0, 0.6, 1.0, 0.7, 0.1, 0.0])})
    assert record.peaks()["row"] == 1.0


def test_a_corner_that_is_steep_on_one_side_only_has_no_crest():
    times = np.array([0.0, 1.0, 2.0, 3.0, 4.0])
    record = PeakRecord(times, {"row": np.array([0.98, 0.99, 1.0, 0.5, 0.0])})
    assert record.peaks()["row"] == 1.0  # the parabola through the three lies above it


def test_a_largest_value_beside_unknown_ones_stands_and_an_unknown_row_stays_unknown():
    times = np.array([0.0, 1.0, 2.0, 3.0])
    rows = {
        "some": np.array([0.1, 1.0, np.nan, 0.5]),
        "all": np.full(4, np.nan),
        "inf": np.array([0, 2, np.inf, 1.0]),
    }
    found = PeakRecord(times, rows).peaks()
    assert (found["some"], found["inf"]) == (1.0, 2.0)
    assert np.isnan(found["all"])
