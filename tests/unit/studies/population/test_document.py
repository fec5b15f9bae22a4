"""The page, the plots and the CSV of a study."""

import csv
import html
import pickle
from types import SimpleNamespace

import numpy as np
import pytest
import xarray
from stand_in_population import PATH, SPACE, stand_in
from typer.testing import CliRunner

import electrovib as ev
from electrovib.apps.cli import app
from electrovib.core.errors import InputError
from electrovib.core.signals import make_trace
from electrovib.studies.population.answer import StudyResult, study_document
from electrovib.studies.population.result import nominal_words
from electrovib.view import notebook

UNIFORM = {"model": "Uniform", "low": 0.2, "high": 0.9, "source": "B. Author 2098", "status": "full text"}
SPACE_WITH_SOURCES = {
    PATH: SPACE[PATH] | {"source": "A. Author 2099", "status": "unverified", "confidence": "low"},
    "friction.coefficient": UNIFORM,
}


@pytest.fixture(scope="module")
def found():
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr("electrovib.solve.population.Population", stand_in)
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


def test_exceedance_probabilities_are_drawn_and_other_signals_refused(found):
    ax = ev.plot.exceedance(found)
    assert [line.get_label() for line in ax.lines] == ["above 200 µN", "above 1 mN"]
    np.testing.assert_array_equal(ax.lines[1].get_ydata(), found["electrostatic_force_exceedance"].values[1])
    with pytest.raises(InputError, match="no threshold"):
        ev.plot.exceedance(found.drop_vars("electrostatic_force_exceedance"))
    with pytest.raises(InputError, match="Did you mean 'electrostatic_force'"):
        ev.plot.bands(found, "electrostatic_forces")


def test_the_page_states_bands_sources_and_validity(found, tmp_path):
    page = ev.report(found, tmp_path / "study.html").read_text(encoding="utf-8")
    for words in (
        *("Study of 1100 fingers", "95th percentile", "A. Author 2099", "full text", "seed 1", "stand-in"),
        f"{PATH} (unverified, cited from memory)",
        *("unverified, cited from memory</td>", ">low</td>"),
        "LogNormal, median 200 µm, factor 1.5",
        "the drawn fingers are not judged one by one",
        "exact order statistics",
    ):
        assert words in page, words
    assert "friction.coefficient (unverified" not in page


def test_terminal_page_and_notebook_show_one_document(found, tmp_path):
    said = study_document(found)
    assert said.sentences[0].startswith("Electrostatic force at ")
    assert any(each.startswith("1100 fingers, seed 1; ") for each in said.remarks)
    page = ev.report(found, tmp_path / "study.html").read_text(encoding="utf-8")
    page = " ".join(html.unescape(page).replace("µ", "u").split())
    for sentence in said.sentences:
        assert sentence in said.text
        assert html.escape(sentence) in notebook._dataset(found)
        assert sentence in page
    printed = []
    notebook._dataset_as_text(found, SimpleNamespace(text=printed.append), cycle=False)
    assert printed == [said.text] == [repr(found)]
    assert found._repr_html_() == notebook._dataset(found) == said.html


def test_the_result_is_a_dataset_in_all_that_xarray_does_with_it(found):
    assert isinstance(found, xarray.Dataset)
    plain = xarray.Dataset(found.data_vars, found.coords, found.attrs)
    assert found.identical(plain)
    assert dict(found.sizes) == dict(plain.sizes)
    for again in (pickle.loads(pickle.dumps(found)), found.copy(deep=True), found.compute(), found.load()):
        xarray.testing.assert_identical(again, found)
    assert xarray.concat([found, found], "k").sizes["k"] == 2
    assert StudyResult.of(plain).document.text == found.document.text
    # a coordinate of the user's own
    noted = plain.assign_coords(note=("time", np.arange(plain.sizes["time"])))
    assert StudyResult.of(noted).identical(noted)
    bands = found["electrostatic_force_percentile"]
    assert type(bands) is xarray.DataArray
    assert bands.dims == ("percentile", "time")


def test_a_part_of_the_time_is_an_answer_and_what_has_lost_its_axis_is_shown_by_xarray(found):
    part = found.isel(time=slice(0, 3))
    assert repr(part).startswith("Electrostatic force at ")
    assert repr(part) != repr(found)
    lost = (
        found.isel(time=0),
        found.mean(),
        found.drop_vars("electrostatic_force_mean"),
        found.drop_vars("electrostatic_force_variance"),
        found.drop_attrs(),
    )
    for each in lost:
        assert "Dimensions" in repr(each)
        assert "xr-header" in each._repr_html_()


def test_a_study_that_xarray_has_read_is_saved_as_the_answer_is(found, tmp_path):
    plain = xarray.Dataset(found.data_vars, found.coords, found.attrs)
    for name, each in (("a", found), ("b", plain)):
        ev.save(each, tmp_path / f"{name}.csv")
    assert (tmp_path / "a.csv").read_bytes() == (tmp_path / "b.csv").read_bytes()


def test_the_page_of_a_store_is_that_of_its_result(tmp_path, monkeypatch):
    monkeypatch.setattr("electrovib.solve.population.Population", stand_in)
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
    remarks = " ".join(line for line in lines if line.startswith("#"))
    for words in ("1100 fingers, seed 1", "unverified, cited from memory", "single fingers are not judged"):
        assert words in remarks
    rows = list(csv.DictReader(line for line in lines if not line.startswith("#")))
    assert len(rows) == found.sizes["time"]
    for column, value in {
        "percentile 95 [N]": found["electrostatic_force_percentile"].values[4, -1],
        "variance [N^2]": found["electrostatic_force_variance"].values[-1],
        "exceedance of 1 mN [1]": found["electrostatic_force_exceedance"].values[1, -1],
    }.items():
        assert float(rows[-1][f"electrostatic_force {column}"]) == value
    ev.save(found, path)  # ours
    path.write_text("mine")
    with pytest.raises(InputError, match="--force"):
        ev.save(found, path)
    with pytest.raises(InputError, match=r"written as \.html, \.pdf, .*\.csv"):
        ev.save(found, tmp_path / "bands.nc")


def recording(found):
    """A recording of the signal of a study, without a scenario."""
    time = np.asarray(found["time"].values)
    return make_trace({"electrostatic_force": (("time",), np.full(time.size, 1e-3))}, {"time": time}, {})


@pytest.mark.slow
@pytest.mark.parametrize("order", [(0, 1, 2), (2, 1, 0), (1, 2, 0)])
def test_a_recording_and_a_run_are_drawn_over_the_bands_in_any_order(tmp_path, monkeypatch, order):
    monkeypatch.setattr("electrovib.solve.population.Population", stand_in)
    study = ev.study("vezzoli_2014/fig6", SPACE, n=50, seed=1, output=tmp_path / "a.zarr")
    recording(study).to_netcdf(tmp_path / "rec.nc")
    ev.save(ev.simulate("vezzoli_2014/fig6"), tmp_path / "run.nc")
    files = [str(tmp_path / name) for name in ("a.zarr", "rec.nc", "run.nc")]
    out = tmp_path / "page.html"
    result = CliRunner().invoke(app, ["report", *(files[at] for at in order), "-o", str(out)])
    assert result.exit_code == 0, result.output
    page = out.read_text(encoding="utf-8")
    assert "Electrostatic force over the fingers" in page
    assert "5 to 95 % of the fingers" in page
    axes = ev.plot.bands(study, beside={"rec": recording(study), "run": ev.simulate("vezzoli_2014/fig6")})
    drawn = {line.get_label(): line for line in axes.get_lines()}
    assert drawn["rec"].get_marker() == "."
    assert drawn["rec"].get_zorder() < drawn["run"].get_zorder()
    assert drawn["run"].get_linestyle() == "-"


def test_a_scenario_at_the_edge_of_its_population_is_named(found):
    """The skin of the scenario has 200 um; nine of ten fingers of one space are thicker, half of the other."""

    def of(low):
        space = f'[space."{PATH}"]\nmodel = "Uniform"\nlow = "{low} um"\nhigh = "300 um"\n'
        return nominal_words(found.assign_attrs(space_toml=f"schema = 1\n{space}"))

    (line,) = of(190)
    assert f"{PATH} = 200 um (below 9" in line
    assert of(100) == []


@pytest.mark.parametrize(("lowest", "scale"), [(1e-6, "log"), (5e-4, "linear")])
def test_bands_that_would_touch_zero_have_a_logarithmic_axis(found, lowest, scale):
    percentiles = found["electrostatic_force_percentile"].copy(deep=True)
    percentiles[:] = np.geomspace(lowest, 1e-3, len(percentiles))[:, None]
    axes = ev.plot.bands(found.assign(electrostatic_force_percentile=percentiles))
    assert axes.get_yscale() == scale
    if scale == "log":
        assert lowest / 10 < axes.get_ylim()[0] < lowest
        # of the scenario's own curve
        highest = max(float(np.nanmax(line.get_ydata())) for line in axes.get_lines())
        assert 1e-3 < highest < axes.get_ylim()[1] < 20 * highest  # an automatic axis would add decades
