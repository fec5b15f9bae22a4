"""The same numbers for any tiles, any interruption, in memory and in a store; and what the numbers are."""

from __future__ import annotations

import threading

import numpy as np
import pytest
from stand_in_population import PATH, SPACE, StandInPopulation, stand_in

from electrovib.scenario import load
from electrovib.scenario.space import read_space
from electrovib.study.population import StudyCancelledError, open_study, study
from electrovib.study.population.fingers import Evaluator

ASKED = {"n": 5000, "exceed": ["1 mN"], "draws": True}


def same(one, other):
    """Whether two results have the same numbers and attributes.

    Sums over fingers are formed tile by tile, so that means and variances differ by rounding; all else is counted or sorted.
    """
    assert set(one.variables) == set(other.variables)
    for name in one.variables:
        rtol = 1e-12 if name.endswith(("_mean", "_variance")) else 0.0
        np.testing.assert_allclose(one[name].values, other[name].values, rtol=rtol, err_msg=name)
        assert one[name].attrs == other[name].attrs
    return one.attrs == other.attrs


def test_the_numbers_are_those_of_the_fingers(quick):
    found = quick(**ASKED, percentiles=(5, 25, 50, 95))
    scenario = load("vezzoli_2014/fig6")
    drawn = read_space(scenario, SPACE).draw(3, 0, 5000)
    values = stand_in(scenario, [PATH]).signals(drawn)["electrostatic_force"]
    name = "electrostatic_force"
    np.testing.assert_allclose(found[f"{name}_mean"], values.mean(axis=0), rtol=1e-13)
    np.testing.assert_allclose(found[f"{name}_variance"], values.var(axis=0, ddof=1), rtol=1e-12)
    expected = np.percentile(values.astype(np.float32).astype(float), [5, 25, 50, 95], axis=0)
    np.testing.assert_allclose(found[f"{name}_percentile"], expected, rtol=1e-14)
    np.testing.assert_array_equal(found[f"{name}_exceedance"], [(values > 1e-3).mean(axis=0)])
    np.testing.assert_array_equal(found[f"{name}_exceedance_anywhere"], [(values > 1e-3).any(axis=1).mean()])
    np.testing.assert_array_equal(found[name], values.astype(np.float32))
    np.testing.assert_array_equal(found[PATH], drawn[PATH])


@pytest.mark.parametrize("memory", ["1 GB", "80 kB"])
@pytest.mark.parametrize("size", [16, 256, 1024, 2048])
def test_tiles_do_not_change_the_numbers(quick, tiles, memory, size, tmp_path):
    reference = quick(**ASKED | {"draws": False}, budget_memory="1 GB" if memory == "1 GB" else "120 kB")
    tiles(size)
    if memory == "1 GB":
        assert same(quick(**ASKED | {"draws": False}), reference)
    found = quick(
        **ASKED | {"draws": False},
        budget_memory=memory if memory == "1 GB" else "120 kB",
        output=tmp_path / "a.zarr",
    )
    assert same(found, reference)


def test_percentiles_beyond_the_memory_are_near_the_exact_ones(quick):
    exact = quick(n=9000)
    binned = quick(n=9000, budget_memory="200 kB")
    assert exact.attrs["percentiles_from"].startswith("exact")
    assert "0.3 %" in binned.attrs["percentiles_from"]
    one, other = (each["electrostatic_force_percentile"].values for each in (exact, binned))
    np.testing.assert_allclose(other, one, rtol=3e-3)
    assert not np.array_equal(one, other)
    np.testing.assert_allclose(
        exact["electrostatic_force_mean"], binned["electrostatic_force_mean"], rtol=1e-12
    )


@pytest.mark.parametrize(("memory", "draws"), [("1 GB", False), ("120 kB", True)])
def test_a_study_that_is_ended_again_and_again_gives_the_same_numbers(quick, tiles, tmp_path, memory, draws):
    tiles(64)
    asked = ASKED | {"draws": draws, "budget_memory": memory}
    reference = quick(**asked, output=tmp_path / "reference.zarr")
    done, starts = 0, []
    while done < 5000:
        end = done + 1500

        def progress(fingers, total, end=end, starts=starts, begun=[]):  # noqa: B006
            begun.append(fingers)
            if len(begun) == 1:
                starts.append(fingers)
            return fingers >= end

        if end < 5000:
            with pytest.raises(StudyCancelledError, match="the same call continues"):
                quick(**asked, output=tmp_path / "ended.zarr", progress=progress)
        else:
            quick(**asked, output=tmp_path / "ended.zarr", progress=progress)
        done = end
    assert starts == [0, 1536, 3008, 4544]  # every run begins where the last one ended
    assert same(open_study(tmp_path / "ended.zarr"), reference)
    one, other = (
        {each.relative_to(root) for each in root.rglob("*") if each.is_file()}
        for root in (tmp_path / "ended.zarr", tmp_path / "reference.zarr")
    )
    assert one == other  # and no other file


def test_the_result_in_memory_is_that_of_the_store(quick, tmp_path):
    found = quick(**ASKED, output=tmp_path / "a.zarr")
    assert same(found, quick(**ASKED))
    assert found.attrs["seed"] == 3
    assert found["electrostatic_force_percentile"].attrs["units"] == "N"
    assert found["electrostatic_force_variance"].attrs["units"] == "N^2"


@pytest.mark.parametrize("count", [1, 20])
@pytest.mark.parametrize("memory", ["1 GB", "120 kB"])
def test_a_finger_that_is_not_known_makes_its_samples_unknown(quick, monkeypatch, memory, count):
    thickness = np.sort(read_space(load("vezzoli_2014/fig6"), SPACE).draw(3, 0, 5000)[PATH])
    monkeypatch.setattr(StandInPopulation, "unknown", thickness[-count])
    found = quick(n=5000, budget_memory=memory)
    assert found["electrostatic_force_unknown"].values[3] == count
    assert found["electrostatic_force_unknown"].values[[0, 1, 2, 4, 5, 6]].sum() == 0
    for name in ("percentile", "mean", "variance"):
        known = np.isfinite(found[f"electrostatic_force_{name}"].values)
        assert not known[..., 3].any()
        assert known[..., :3].all()


def test_signals_over_frequency(quick):
    found = quick(n=100, signal="mean_force", exceed="1 mN")
    assert found["mean_force_percentile"].dims == ("percentile", "frequency")
    assert found["mean_force_exceedance"].dims == ("mean_force_threshold", "frequency")


def test_two_signals_share_the_thresholds_of_their_unit(quick):
    found = quick(n=100, signal=["electrostatic_force", "lateral_force"], exceed=["1 mN", 2e-3])
    np.testing.assert_array_equal(found["electrostatic_force_threshold"], [1e-3, 2e-3])
    np.testing.assert_array_equal(found["lateral_force_threshold"], [1e-3])


def test_without_percentiles_no_value_is_held(quick):
    found = quick(n=100, percentiles=())
    assert "percentile" not in found.variables
    assert "electrostatic_force_mean" in found


def test_another_seed_draws_other_fingers(quick):
    assert not np.array_equal(
        quick(n=50)["electrostatic_force_mean"], quick(n=50, seed=4)["electrostatic_force_mean"]
    )


@pytest.mark.parametrize(
    ("memory", "exceed"), [("1 GB", "10 mN"), ("1 MB", "10 mN"), ("1 GB", ()), ("1 MB", ())]
)
def test_threads_do_not_change_the_numbers(monkeypatch, memory, exceed):
    """The real population, in arrays over fingers."""
    scenario = load("vezzoli_2014/fig6_gap").replace({"time.samples": 50})
    asked = {"n": 7000, "seed": 2, "draws": memory == "1 GB", "exceed": exceed, "budget_memory": memory}
    reference = study(scenario, "fingers", **asked)
    assert reference.attrs["method"].startswith("together")
    evaluated, original = set(), Evaluator.tile

    def noted(self, start, stop, rows=None):
        evaluated.add((start, stop, threading.get_ident()))
        return original(self, start, stop, rows)

    monkeypatch.setattr("electrovib.study.population.tiles.thread_count", lambda _: 3)
    monkeypatch.setattr(Evaluator, "tile", noted)
    for size, most in ((5e4, 250), (3e5, 1024)):
        monkeypatch.setattr("electrovib.study.population.tiles._BYTES", size)
        monkeypatch.setattr("electrovib.study.population.tiles._HERE", 1e3)
        evaluated.clear()
        assert same(study(scenario, "fingers", **asked), reference)
        assert {stop - start for start, stop, _ in evaluated} == {most, 7000 % most} - {0}
        assert (len({thread for *_, thread in evaluated}) > 1) == (memory == "1 GB")


@pytest.mark.parametrize("memory", ["1 GB", "120 kB"])
def test_every_finger_is_counted_once_in_a_tile_of_many_blocks(monkeypatch, quick, tiles, memory):
    """With a finger that is not known in its middle, which is in the statistics of no other sample."""
    monkeypatch.setattr(StandInPopulation, "unknown", 6e-4)
    tiles(256)
    parts = quick(n=5000, exceed="1 mN", budget_memory=memory)
    tiles(4096)
    assert same(quick(n=5000, exceed="1 mN", budget_memory=memory), parts)
