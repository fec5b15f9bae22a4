"""The same numbers for any tiles, any interruption, in memory and in a store; and what the numbers are."""

import threading

import numpy as np
import pytest
from stand_in_population import PATH, SPACE, StandInPopulation, stand_in

from electrovib.scenario import load
from electrovib.scenario.space import read_space
from electrovib.studies.population import StudyCancelledError, open_study, study
from electrovib.studies.population.result import percentile_words
from electrovib.studies.population.tiles import Evaluator, Statistics, TileSizes, largest_tile

ASKED = {"n": 5000, "exceed": ["1 mN"], "records": True}
FORCE = "electrostatic_force"
PERCENTILE = f"{FORCE}_percentile"


def drawn(count):
    return read_space(load("vezzoli_2014/fig6"), SPACE).draw(3, 0, count)


def test_the_numbers_are_those_of_the_fingers_in_memory_and_in_the_store(quick, same, tmp_path):
    found = quick(**ASKED, percentiles=(5, 25, 50, 95))
    values = stand_in(None, [PATH]).signals(drawn(5000))[FORCE]
    np.testing.assert_allclose(found[f"{FORCE}_mean"], values.mean(axis=0), rtol=1e-13)
    np.testing.assert_allclose(found[f"{FORCE}_variance"], values.var(axis=0, ddof=1), rtol=1e-12)
    expected = np.percentile(values.astype(np.float32).astype(float), [5, 25, 50, 95], axis=0)
    np.testing.assert_allclose(found[PERCENTILE], expected, rtol=1e-14)
    np.testing.assert_array_equal(found[f"{FORCE}_exceedance"], [(values > 1e-3).mean(axis=0)])
    np.testing.assert_array_equal(found[f"{FORCE}_exceedance_anywhere"], [(values > 1e-3).any(axis=1).mean()])
    np.testing.assert_array_equal(found[FORCE], values.astype(np.float32))
    np.testing.assert_array_equal(found[PATH], drawn(5000)[PATH])
    assert found.attrs["seed"] == 3
    units = [found[name].attrs["units"] for name in (PERCENTILE, f"{FORCE}_variance")]
    assert units == ["N", "N^2"]
    stored = quick(**ASKED, percentiles=(5, 25, 50, 95), output=tmp_path / "a.zarr")
    same(stored, found)
    assert stored.attrs == found.attrs


@pytest.mark.parametrize("memory", ["1 GB", "120 kB"])
@pytest.mark.parametrize("size", [16, 256, 1024, 2048])
def test_tiles_do_not_change_the_numbers(quick, tiles, same, memory, size, tmp_path):
    asked = ASKED | {"records": False, "budget_memory": memory}
    reference = quick(**asked)
    tiles(size)
    same(quick(**asked), reference)
    same(quick(**asked, output=tmp_path / "a.zarr"), reference)


def test_percentiles_beyond_the_memory_are_near_the_exact_ones(quick):
    exact, binned = quick(n=9000), quick(n=9000, budget_memory="200 kB")
    assert exact.attrs["percentiles_from"].startswith("exact")
    assert "0.3 %" in binned.attrs["percentiles_from"]
    one, other = (each[PERCENTILE].values for each in (exact, binned))
    np.testing.assert_allclose(other, one, rtol=3e-3)
    assert not np.array_equal(one, other)
    np.testing.assert_allclose(exact[f"{FORCE}_mean"], binned[f"{FORCE}_mean"], rtol=1e-12)


@pytest.mark.parametrize(("memory", "draws"), [("1 GB", False), ("120 kB", True)])
def test_a_study_that_is_ended_again_and_again_gives_the_same_numbers(
    quick, tiles, same, content, tmp_path, memory, draws
):
    tiles(64)
    asked = ASKED | {"records": draws, "budget_memory": memory}
    reference = quick(**asked, output=tmp_path / "reference.zarr")
    starts = []
    for end in (1500, 3000, 4500, 6000):
        begun = []

        def progress(fingers, total, end=end, begun=begun):
            begun.append(fingers)
            return fingers >= end

        try:
            quick(**asked, output=tmp_path / "ended.zarr", progress=progress)
        except StudyCancelledError:
            assert end < 5000
        starts.append(begun[0])
    assert starts == [0, 1536, 3008, 4544]  # every run begins where the last one ended
    same(open_study(tmp_path / "ended.zarr"), reference)
    assert set(content(tmp_path / "ended.zarr")) == set(content(tmp_path / "reference.zarr"))


@pytest.mark.parametrize("count", [1, 20])
@pytest.mark.parametrize("memory", ["1 GB", "120 kB"])
def test_a_finger_that_is_not_known_makes_its_samples_unknown(quick, monkeypatch, memory, count):
    monkeypatch.setattr(StandInPopulation, "unknown", np.sort(drawn(5000)[PATH])[-count])
    found = quick(n=5000, budget_memory=memory)
    assert found[f"{FORCE}_unknown"].values.tolist() == [0, 0, 0, count, 0, 0, 0]
    for name in ("percentile", "mean", "variance"):
        known = np.isfinite(found[f"{FORCE}_{name}"].values)
        assert not known[..., 3].any()
        assert known[..., :3].all()


def test_signals_thresholds_percentiles_and_seeds_that_are_asked_for(quick):
    found = quick(n=100, quantity="mean_force", exceed="1 mN")
    assert found["mean_force_percentile"].dims == ("percentile", "frequency")
    assert found["mean_force_exceedance"].dims == ("mean_force_threshold", "frequency")
    found = quick(n=100, quantity=[FORCE, "lateral_force"], exceed=["1 mN", 2e-3])
    np.testing.assert_array_equal(found[f"{FORCE}_threshold"], [1e-3, 2e-3])
    np.testing.assert_array_equal(found["lateral_force_threshold"], [1e-3])
    one, other = (quick(n=50, percentiles=(), seed=seed) for seed in (3, 4))
    assert "percentile" not in one.variables, "no value is held"
    assert not np.array_equal(one[f"{FORCE}_mean"], other[f"{FORCE}_mean"])


@pytest.mark.parametrize(
    ("memory", "exceed"),
    [
        ("1 GB", "10 mN"),
        ("1 MB", ()),
        pytest.param("1 GB", (), marks=pytest.mark.slow),
        pytest.param("1 MB", "10 mN", marks=pytest.mark.slow),
    ],
)
def test_threads_do_not_change_the_numbers(monkeypatch, same, memory, exceed):
    """The real population, in arrays over fingers."""
    scenario = load("vezzoli_2014/fig6_gap").replace({"time.samples": 50})
    asked = {"n": 7000, "seed": 2, "records": memory == "1 GB", "exceed": exceed, "budget_memory": memory}
    reference = study(scenario, "fingers", **asked)
    assert reference.attrs["method"].startswith("together")
    evaluated, original = set(), Evaluator.tile

    def noted(self, start, stop, rows=None):
        evaluated.add((start, stop, threading.get_ident()))
        return original(self, start, stop, rows)

    monkeypatch.setattr("electrovib.studies.population.tiles.thread_count", lambda _: 3)
    monkeypatch.setattr("electrovib.studies.population.tiles._HERE", 1e3)
    monkeypatch.setattr(Evaluator, "tile", noted)
    for size, most in ((5e4, 250), (3e5, 1024)):
        monkeypatch.setattr("electrovib.studies.population.tiles._BYTES", size)
        evaluated.clear()
        same(study(scenario, "fingers", **asked), reference)
        assert {stop - start for start, stop, _ in evaluated} == {most, 7000 % most} - {0}
        assert (len({thread for *_, thread in evaluated}) > 1) == (memory == "1 GB")


@pytest.mark.parametrize("memory", ["1 GB", "120 kB"])
def test_every_finger_is_counted_once_in_a_tile_of_many_blocks(monkeypatch, quick, tiles, same, memory):
    """With a finger that is not known in its middle, which is in the statistics of no other sample."""
    monkeypatch.setattr(StandInPopulation, "unknown", 6e-4)
    tiles(256)
    parts = quick(n=5000, exceed="1 mN", budget_memory=memory)
    tiles(4096)
    same(quick(n=5000, exceed="1 mN", budget_memory=memory), parts)


# statistics


def counted(values, *thresholds, binned=False):
    found = Statistics(thresholds, values.shape[1], binned=binned)
    found.add(values.copy())
    return found


def test_values_that_are_not_known_are_counted_apart_and_thresholds_compared_in_float64():
    values = np.array([[1.0, np.nan], [2.0, np.nan], [3.0, 5.0]])
    found = counted(values, 1.5, 4.0, binned=True)
    np.testing.assert_array_equal(found.above, [[2, 1], [0, 1]])
    np.testing.assert_array_equal(found.anywhere, [2, 1])
    np.testing.assert_array_equal(found.unknown, [0, 2])
    found.count(values.astype(np.float32), None)
    assert found.histogram.count == 3
    np.testing.assert_allclose(found.histogram.quantiles([0.5])[0, 0], 2.0, rtol=2e-3)
    below = float(np.nextafter(1.0, 0.0))  # both have the same float32
    assert counted(np.array([[1.0]]), 1.0, below).above.tolist() == [[0], [1]]


def test_statistics_of_all_fingers_are_those_of_the_parts_and_are_restored_from_their_arrays():
    values = np.random.default_rng(1).normal(size=(20, 3))
    merged = Statistics((0.0, 1.0), 3)
    for part in (values[:7], values[7:]):
        merged.merge(counted(part, 0.0, 1.0))
    assert merged.fingers == 20
    np.testing.assert_allclose(merged.mean, values.mean(axis=0), rtol=1e-12)
    np.testing.assert_allclose(merged.variance(), values.var(axis=0, ddof=1), rtol=1e-12)
    whole, first = (counted(part, 0.0, 1.0, binned=True) for part in (values, values[:7]))
    whole.count(values.astype(np.float32), None)
    first.count(values[:7].astype(np.float32), None)
    later = Statistics((0.0, 1.0), 3, binned=True)
    later.restore(first.arrays())
    later.merge(counted(values[7:], 0.0, 1.0))
    later.count(values[7:].astype(np.float32), None)
    arrays, expected = later.arrays(), whole.arrays()
    for name in set(expected) - {"pages", "bins"}:
        np.testing.assert_allclose(arrays[name], expected[name], rtol=1e-12)
    for name in ("above", "anywhere", "unknown"):
        np.testing.assert_array_equal(getattr(merged, name), getattr(whole, name))
    shares = np.linspace(0.0, 1.0, 9)
    np.testing.assert_array_equal(later.histogram.quantiles(shares), whole.histogram.quantiles(shares))


def test_percentiles_in_words():
    found = [percentile_words(share) for share in (5.0, 1.0, 2.0, 3.0, 11.0, 21.0, 2.5)]
    assert found == [f"{each} percentile" for each in ("5th", "1st", "2nd", "3rd", "11th", "21st", "2.5th")]
    assert percentile_words(50.0) == "median"


# sizes of tiles


STOPS = {
    (0, 1024): 1024,
    (64, 100): 164,
    (64, 1024): 1024,
    (1000, 3000): 3072,
    (1024, 4096): 5000,
    (4992, 64): 5000,
}
WANTED = {1.0: 100, 0.01: 4096, 1e3: 1, 0.1: 1000}
"""Fingers of the next tile after 100 fingers in a time [s]."""


def test_a_tile_of_a_block_or_more_ends_with_a_block_and_its_size_follows_from_the_time():
    for (start, wanted), stop in STOPS.items():
        sizes = TileSizes(5000, 4096, seconds=1.0)
        sizes.wanted = wanted
        assert sizes.stop(start) == stop, (start, wanted)
    for seconds, wanted in WANTED.items():
        sizes = TileSizes(10**6, 4096, seconds=1.0)
        sizes.measured(100, seconds)
        assert sizes.wanted == wanted, seconds
    assert TileSizes(10**6, 4096, seconds=1.0).stop(0) == 16
    assert TileSizes(10**6, 256, seconds=1.0, in_arrays=True).stop(0) == 256
    sizes = TileSizes(10**6, 4096, seconds=1.0, in_arrays=True)
    assert sizes.stop(0) == 1024
    sizes.measured(100, 1e3)
    assert sizes.wanted == 1024, "a block at least, however slow the machine is"
    assert largest_tile(2001) * 2001 * 4 <= 64e6
    assert (largest_tile(10**9), largest_tile(1)) == (1, 65536)
