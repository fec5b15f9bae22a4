"""A Trace that was damaged or edited is never opened with other numbers in silence."""

import os

import numpy as np
import pytest
import xarray
from typer.testing import CliRunner

import electrovib as ev
from electrovib.apps.cli import app
from electrovib.core.diagnostics import diagnostics_of
from electrovib.core.errors import InputError
from electrovib.data.atomic import VERIFIED

pytestmark = pytest.mark.usefixtures("forked")

FLIPS = int(os.environ.get("ELECTROVIB_FLIPS", "60"))
"""Flipped bits of each file."""


@pytest.fixture(scope="module")
def trace():
    scenario = ev.load("vezzoli_2014/fig6", changes={"time.duration": "20 ms"})
    return ev.simulate(scenario).isel(time=slice(0, 40))


def numbers_differ(one, two):
    plain = [each.assign_attrs(validity="") for each in (one, two)]
    return not plain[0].identical(plain[1])


@pytest.mark.parametrize("name", ["a.nc", "a.mat"])
def test_no_flipped_bit_changes_a_number_in_silence(name, trace, tmp_path):
    opened = tmp_path / name
    ev.save(trace, opened)
    saved = ev.open_trace(opened)
    whole = opened.read_bytes()
    generator, outcomes = np.random.default_rng(7), {"refused": 0, "the same": 0, "not verified": 0}
    for place in generator.integers(0, len(whole), FLIPS).tolist():
        spoiled = bytearray(whole)
        spoiled[place] ^= 1 << int(generator.integers(0, 8))
        opened.write_bytes(bytes(spoiled))
        try:
            found = ev.open_trace(opened)
        except InputError:
            outcomes["refused"] += 1
            continue
        told = any(each.name == VERIFIED for each in diagnostics_of(found))
        assert not numbers_differ(found, saved), (place, whole[max(0, place - 40) : place + 40])
        outcomes["not verified" if told else "the same"] += 1
    assert outcomes["refused"] > FLIPS / 4, outcomes


@pytest.mark.parametrize("suffix", [".nc", ".mat"])
def test_what_was_saved_is_verified_and_saved_again(suffix, trace, tmp_path):
    ev.save(trace, tmp_path / f"a{suffix}")
    found = ev.open_trace(tmp_path / f"a{suffix}")
    ev.save(found, tmp_path / f"b{suffix}")
    assert found.identical(ev.open_trace(tmp_path / f"b{suffix}"))
    assert not any(each.name == VERIFIED for each in diagnostics_of(found))


def test_a_trace_without_a_checksum_is_read_and_says_so_where_its_numbers_are_printed(trace, tmp_path):
    file = tmp_path / "a.nc"
    ev.save(trace, tmp_path / "saved.nc")
    with xarray.open_dataset(tmp_path / "saved.nc") as opened:
        plain = opened.load()
    del plain.attrs["written_by"]
    plain.to_netcdf(file, engine="h5netcdf")
    words = "not verified: a.nc states no checksum"
    found = ev.open_trace(file)
    assert words in found.attrs["validity"]
    assert [each.state for each in diagnostics_of(found) if each.name == VERIFIED] == ["warning"]
    for command in (["run", file], ["report", file, "-o", tmp_path / "a.html"]):
        done = CliRunner().invoke(app, [*map(str, command)])
        assert words in done.output or words in (tmp_path / "a.html").read_text(encoding="utf-8"), command
