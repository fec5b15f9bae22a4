"""The page, the plots and the CSV of a study."""

from __future__ import annotations

import csv

import numpy as np
import pytest
from stand_in_population import PATH, SPACE, stand_in

import electrovib as ev
from electrovib.core.errors import InputError

SPACE_WITH_SOURCES = {
    PATH: SPACE[PATH] | {"source": "A. Author 2099", "status": "unverified", "confidence": "low"},
    "friction.coefficient": {
        "model": "Uniform",
        "low": 0.2,
        "high": 0.9,
        "source": "B. Author 2098",
        "status": "full text",
    },
}


@pytest.fixture(scope="module")
def found():
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr("electrovib.solve.population.population", stand_in)
        return ev.study(
            "vezzoli_2014/fig6",
            SPACE_WITH_SOURCES,
            n=1100,
            seed=1,
            percentiles=(5, 25, 50, 75, 95),
            exceed=["1 mN", "0.2 mN"],
        )


def test_bands_are_the_percentiles(found):
    ax = ev.plot.bands(found)
    bands = list(ax.collections)
    assert len(bands) == 2
    widest, inner = (each.get_paths()[0].vertices for each in bands)
    values = found["electrostatic_force_percentile"].values
    assert widest[:, 1].max() == values[4].max()
    assert inner[:, 1].max() == values[3].max()
    median, mean = ax.lines
    np.testing.assert_array_equal(median.get_ydata(), values[2])
    np.testing.assert_array_equal(mean.get_ydata(), found["electrostatic_force_mean"].values)
    labels = [text.get_text() for text in ax.get_legend().get_texts()]
    assert labels == ["5 to 95 % of the fingers", "25 to 75 % of the fingers", "median", "mean"]


def test_exceedance_probabilities_are_drawn(found):
    ax = ev.plot.exceedance(found)
    assert [line.get_label() for line in ax.lines] == ["above 200 µN", "above 1 mN"]
    np.testing.assert_array_equal(ax.lines[1].get_ydata(), found["electrostatic_force_exceedance"].values[1])
    with pytest.raises(InputError, match="no threshold"):
        ev.plot.exceedance(found.drop_vars("electrostatic_force_exceedance"))


def test_another_signal_is_refused(found):
    with pytest.raises(InputError, match="Did you mean 'electrostatic_force'"):
        ev.plot.bands(found, "electrostatic_forces")


def test_the_page_states_bands_sources_and_validity(found, tmp_path):
    page = ev.report(found, tmp_path / "study.html").read_text(encoding="utf-8")
    for words in (
        "Study of 1100 fingers",
        "95th percentile",
        f"{PATH} (unverified, cited from memory)",
        "A. Author 2099",
        "full text",
        "unverified, cited from memory, low confidence",
        "LogNormal: median 200 µm, factor 1.5",
        "the drawn fingers are not judged one by one",
        "seed 1",
        "stand-in",
        "exact order statistics",
    ):
        assert words in page, words
    assert "friction.coefficient (unverified" not in page


def test_the_page_of_a_store_is_that_of_its_result(tmp_path, monkeypatch):
    monkeypatch.setattr("electrovib.solve.population.population", stand_in)
    one = ev.study("vezzoli_2014/fig6", SPACE, n=50, seed=1, output=tmp_path / "a.zarr")
    first = ev.report(one, tmp_path / "one.html").read_bytes()
    assert ev.report(tmp_path / "a.zarr", tmp_path / "two.html").read_bytes() == first
    with pytest.raises(InputError, match="one study"):
        ev.report([tmp_path / "a.zarr", tmp_path / "a.zarr"], tmp_path / "three.html")
    with pytest.raises(InputError, match="no study of electrovib"):
        ev.report(tmp_path, tmp_path / "three.html")


def test_the_bands_as_csv(found, tmp_path):
    (path,) = ev.save(found, tmp_path / "bands.csv")
    lines = path.read_text(encoding="utf-8").splitlines()
    remarks = [line for line in lines if line.startswith("#")]
    assert any("1100 fingers, seed 1" in line for line in remarks)
    assert any("unverified, cited from memory" in line for line in remarks)
    assert any("single fingers are not judged" in line for line in remarks)
    rows = list(csv.DictReader(line for line in lines if not line.startswith("#")))
    assert len(rows) == found.sizes["time"]
    assert (
        float(rows[-1]["electrostatic_force percentile 95 [N]"])
        == found["electrostatic_force_percentile"].values[4, -1]
    )
    assert (
        float(rows[-1]["electrostatic_force variance [N^2]"])
        == found["electrostatic_force_variance"].values[-1]
    )
    assert (
        float(rows[-1]["electrostatic_force exceedance of 1 mN [1]"])
        == found["electrostatic_force_exceedance"].values[1, -1]
    )
    ev.save(found, path)  # ours
    path.write_text("mine")
    with pytest.raises(InputError, match="--force"):
        ev.save(found, path)
    with pytest.raises(InputError, match=r"bands of a study are a \.csv file"):
        ev.save(found, tmp_path / "bands.nc")
