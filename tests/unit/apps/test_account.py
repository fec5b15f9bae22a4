"""Everything that a file has is read, or named as not read: in the listing, the Trace, its diagnostics and the recipe."""

import json

import numpy as np
import pytest
import scipy.io

import electrovib as ev

T = np.arange(40) * 1e-3
FEW = {f"few{number}": np.arange(2.0 + number) for number in range(25)}


@pytest.fixture
def several(here):
    """Two rows of one length, one of them with a gap, and 25 of other lengths."""
    gaps = np.where(T < 2e-3, np.nan, 3 * T)
    scipy.io.savemat(here / "a.mat", {"time": T, "force": gaps, **FEW})
    return here / "a.mat"


def test_a_trace_states_what_was_read_and_what_was_not(several):
    found = ev.import_file(several, {"lateral_force": "force [N]"}, time="time [s]")
    account = json.loads(found.attrs["columns_of_file"])
    assert [each["name"] for each in account["read"]] == ["time", "force"]
    force = {"unit": "", "type": "float64", "rows": 40, "missing": 2, "first": 3 * T[2], "last": 3 * T[-1]}
    assert account["read"][1] == {"name": "force"} | force
    assert [each["name"] for each in account["not_read"]] == list(FEW)
    assert "it has 7 rows, those that are read 40" in account["not_read"][5]["why"]
    (said,) = [each for each in json.loads(found.attrs["validity"]) if each["name"] == "rest of the file"]
    assert said["text"].startswith("not read: few0 (it has 2 rows")
    assert said["text"].endswith("; and 5 more")
    assert said["text"] in found.attrs["history"]
    for suffix in (".nc", ".mat"):
        ev.save(found, several.with_name(f"saved{suffix}"))
        again = ev.open_trace(several.with_name(f"saved{suffix}"))
        assert json.loads(again.attrs["columns_of_file"]) == account


def test_the_listing_is_cut_and_the_recipe_is_whole(several, said):
    listed = said("import a.mat")
    assert "  1  force  [unit not stated]  40 rows of float64: 0.006 first, 0.117 last, 2 missing" in listed
    assert listed.count("  not read: few") == 20
    assert "not read either: 5 more" in listed
    said("import a.mat --column 'lateral_force=force [N]' --set 'time=time [s]' -o lab.toml")
    recipe = several.with_name("lab.toml").read_text(encoding="utf-8")
    assert recipe.count("# " + "  not read: few") == 25
    assert "#   0  time  [unit not stated]  40 rows of float64: 0 first, 0.039 last" in recipe
    said("import a.mat --recipe lab.toml -o a.nc")
    assert ev.open_trace("a.nc").lateral_force.size == 40


def test_the_account_of_many_columns_is_whole(tmp_path):
    names = [f"channel {number}" for number in range(1000)]
    rows = "".join(",".join(f"{row + number / 8}" for number in range(1000)) + "\n" for row in range(3))
    (tmp_path / "a.csv").write_text(",".join(names) + "\n" + rows)
    found = ev.import_file(tmp_path / "a.csv", {"drive_voltage": "channel 7 [V]"}, step="1 ms")
    ev.save(found, tmp_path / "a.nc")
    read = json.loads(ev.open_trace(tmp_path / "a.nc").attrs["columns_of_file"])["read"]
    assert [each["name"] for each in read] == names
    assert [each["last"] for each in read] == [2 + number / 8 for number in range(1000)]
