"""Sizes of tiles."""

from __future__ import annotations

import pytest

from electrovib.study.population.tiles import TileSizes, largest_tile


@pytest.mark.parametrize(
    ("start", "wanted", "stop"),
    [
        (0, 1024, 1024),
        (64, 100, 164),
        (64, 1024, 1024),
        (1000, 3000, 3072),
        (1024, 4096, 5000),
        (4992, 64, 5000),
    ],
)
def test_a_tile_of_a_block_or_more_ends_with_a_block(start, wanted, stop):
    sizes = TileSizes(5000, 4096, seconds=1.0)
    sizes.wanted = wanted
    assert sizes.stop(start) == stop


@pytest.mark.parametrize(("seconds", "wanted"), [(1.0, 100), (0.01, 4096), (1e3, 1), (0.1, 1000)])
def test_the_size_follows_from_the_time(seconds, wanted):
    sizes = TileSizes(10**6, 4096, seconds=1.0)
    sizes.measured(100, seconds)
    assert sizes.wanted == wanted


def test_the_first_tile_is_small_unless_fingers_are_computed_in_arrays():
    assert TileSizes(10**6, 4096, seconds=1.0).stop(0) == 16
    assert TileSizes(10**6, 4096, seconds=1.0, in_arrays=True).stop(0) == 1024
    assert TileSizes(10**6, 256, seconds=1.0, in_arrays=True).stop(0) == 256


def test_a_tile_of_arrays_is_a_block_at_least_however_slow_the_machine_is():
    sizes = TileSizes(10**6, 4096, seconds=1.0, in_arrays=True)
    sizes.measured(100, 1e3)
    assert sizes.wanted == 1024


def test_the_signals_of_a_tile_stay_small():
    assert largest_tile(2001) * 2001 * 4 <= 64e6
    assert largest_tile(10**9) == 1
    assert largest_tile(1) == 65536
