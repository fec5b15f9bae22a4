"""The fit from files to a folder of results: its verdict, its comparison of models, its posterior distribution."""

import json
import re
import shlex
import sys
import tomllib

import h5netcdf
import numpy as np
import pytest

import electrovib as ev
from electrovib.apps import fit as fit_module
from electrovib.core.errors import InputError
from electrovib.core.signals import make_trace
from electrovib.recordings.fit.problem import CancelledError
from electrovib.scenario.space import read_space
from electrovib.scenario.toml import to_toml

pytestmark = pytest.mark.usefixtures("blank_pictures")

GAP, LEAK = "stack.gap.thickness", "stack.gap.material.conductivity"
FILM, PERMITTIVITY = "stack.insulator.thickness", "stack.insulator.material.permittivity"


def test_the_folder_holds_what_can_be_used_again(spectra, here, table):
    out, models = here / "out", [spectra / "thick.toml"]
    found = ev.fit(
        spectra / "plate.toml", spectra / "a.nc", free=[GAP, LEAK], output=out, compare_with=models
    )
    estimate, correlation = found.best.estimate, found.best.estimate.correlation[0][1]
    files = {"parameters.csv", "parameters.toml", "report.html", "space.toml", "correlations.csv", "fit.txt"}
    assert {path.name for path in out.iterdir() if path.suffix != ".pdf"} == files
    text = (out / "fit.txt").read_text()
    for words in (
        "law MaxwellStressInGap, fitted to",
        "a.nc (impedance)",
        f"{GAP} = 3",
        " µm (",
        "electrovib ",
    ):
        assert words in text
    assert ev.load(out / "parameters.toml").stack.layers["gap"].thickness == estimate.values[GAP]
    (row,) = [row for row in table(out / "parameters.csv") if row["name"] == GAP]
    assert (float(row["value"]), row["unit"]) == (estimate.values[GAP], "m")
    assert float(row["lower"]) < 3e-6 < float(row["upper"])
    space = read_space(found.scenario, out / "space.toml")
    assert space.distributions[GAP].distribution.mean == estimate.values[GAP]
    assert space.distributions[GAP].distribution.deviation == estimate.standard_deviations[GAP]
    assert space.correlations == {(GAP, LEAK): correlation}
    assert tomllib.loads((out / "space.toml").read_text())["correlation"] == {f"{GAP} ~ {LEAK}": correlation}
    (_, *first), _ = (row.values() for row in table(out / "correlations.csv"))
    assert [float(each) for each in first] == [pytest.approx(1.0, abs=1e-12), correlation]
    covariance = estimate.covariance
    assert correlation == pytest.approx(covariance[0, 1] / np.sqrt(covariance[0, 0] * covariance[1, 1]))
    page = (out / "report.html").read_text()
    assert page.count("<figure>") == 3  # modulus, phase, residuals
    for words in ("Correlation of the estimates", "95 % interval", "Residuals", "leaves it no support"):
        assert words in page
    assert "src=" not in page
    assert found.comparison.candidates[0].name == "plate.toml"


def test_the_best_model_comes_first_even_if_it_was_not_asked_for(spectra):
    models = [spectra / "plate.toml"]
    found = ev.fit(spectra / "thick.toml", spectra / "a.nc", free=[GAP, LEAK], compare_with=models)
    first, second = found.comparison.candidates
    assert (first.name, second.name) == ("plate.toml", "thick.toml")
    assert (first.aicc, second.aicc > 10) == (0, True)
    assert "no noise" in second.against
    assert not found.comparison.is_weighed
    assert found.scenario.stack.layers["insulator"].thickness == 2e-6


def test_sessions_appear_in_what_is_printed_in_table_and_space(spectra, here, said, table):
    plate, *files = (spectra / name for name in ("plate.toml", "a.nc", "b.nc", "c.nc"))
    named = f"--all --session '{files[0]}=monday' --noise impedance=0.01"
    out = said(
        "fit", plate, *files, "--free", f"{GAP},{LEAK}", "--varying", GAP, *shlex.split(named), "-o", "out"
    )
    assert f"{GAP} [monday]: " in out
    for words in ("95 % interval", "scatter within a session"):
        assert words in out
    assert (here / "out" / "report.html").exists()
    row = table(here / "out" / "parameters.csv")[-1]
    assert row["name"] == f"{GAP} (mean of 3 sessions)"
    assert float(row["value"]) == pytest.approx(3.3e-6, rel=0.01)
    assert "between sessions" in row["note"]
    text = (here / "out" / "space.toml").read_text()
    assert f"# {GAP} varies between sessions: no correlation" in text
    assert "correlation" not in tomllib.loads(text)
    space = tomllib.loads(text)["space"]
    assert set(space) == {GAP, LEAK}
    # between sessions 0.3 um, and 0.3 um / sqrt(3) of the mean
    assert space[GAP]["deviation"] == pytest.approx(0.3e-6 * np.sqrt(4 / 3), rel=0.05)


def test_files_of_the_same_name_are_numbered(spectra, here):
    (here / "a.nc").write_bytes((spectra / "b.nc").read_bytes())
    found = ev.fit(spectra / "plate.toml", [spectra / "a.nc", "a.nc"], free=[GAP], varying=[GAP])
    assert [row.name for row in found.rows[:2]] == [f"{GAP} [a.nc (1)]", f"{GAP} [a.nc (2)]"]


def test_what_is_not_determined_says_why_and_is_not_in_the_space(spectra, here):
    found = ev.fit(spectra / "plate.toml", spectra / "a.nc", free=[FILM, PERMITTIVITY], output="out")
    assert {row.state for row in found.rows} == {"not"}
    assert all("they determine" in row.note for row in found.rows)
    assert "not determined" in (here / "out" / "report.html").read_text()
    text = (here / "out" / "space.toml").read_text()
    assert FILM not in tomllib.loads(text).get("space", {})
    assert "correlation" not in tomllib.loads(text)
    assert f"# {FILM} is omitted: the data do not determine" in text


def test_a_file_of_somebody_else_is_not_replaced_and_cancelled_nothing_is_written(spectra, here):
    plate, record = spectra / "plate.toml", spectra / "a.nc"
    for name, sampling in (("posterior.nc", ev.Sampling(seed=1)), ("parameters.csv", None)):
        (here / name).write_text("mine")
        with pytest.raises(InputError, match=f"{name}: exists already"):
            ev.fit(plate, record, free=[GAP], posterior=sampling, output=here)
    assert len(list(here.iterdir())) == 2
    ev.fit(plate, record, free=[GAP], output=here, force=True)
    ev.fit(plate, record, free=[GAP], output=here)  # our own is
    with pytest.raises(CancelledError):
        ev.fit(plate, record, free=[GAP], output="out", progress=lambda count, _: count > 1)
    assert not (here / "out").exists()


def test_mistakes_are_reported_together(spectra, here, monkeypatch):
    plate, record = spectra / "plate.toml", spectra / "a.nc"
    (here / "out").write_text("a file")
    with pytest.raises(InputError) as caught:
        ev.fit("bau_2010/sin", spectra / "none.nc", free=[GAP], output="out", compare_with=["nothing"])
    for words in ("bau_2010/sine", "none.nc", "nothing", "is a file"):
        assert words in " ".join(caught.value.problems)
    for wrong, words in (
        ({"session": {"b.nc": "x"}}, "none of the recordings"),
        ({"noise": {"mean_force": 1.0}}, "no recording has this signal"),
        ({"noise": {"impedanc": 1.0}}, "impedance"),
    ):
        with pytest.raises(InputError, match=words):
            ev.fit(plate, ev.Recordings(traces=record, **wrong), free=[GAP])
    with pytest.raises(InputError, match="none of the free parameters"):
        ev.fit(plate, record, free=[GAP], compare_with=["vezzoli_2014/fig6"])
    monkeypatch.setitem(sys.modules, "emcee", None)
    with pytest.raises(InputError, match=r"emcee.*pip install 'electrovib\[fit\]'"):
        ev.fit(plate, record, free=[GAP], posterior=ev.Sampling(seed=1))


def test_the_errors_of_gain_and_zero_of_a_sensor_are_its_calibration():
    known = ev.Recordings(traces=(), gain_error={"lateral_force": 0.02}, zero_error={"lateral_force": 1e-3})
    (error,) = known.calibration.values()
    assert (error.gain, error.zero) == (0.02, 1e-3)


PULSE = {"model": "Trapezium", "high": "100 V", "rise": "10 us", "hold": "20 ms", "fall": "10 us"}
TIMES = np.linspace(0, 30e-3, 60)


@pytest.fixture
def recorded(here):
    """A force of 100 V with 1 % of noise and the recorded voltage, its model, one without leak and one of 300 V."""
    rng, grid = np.random.default_rng(6), {"model": "TimeGrid", "duration": "30 ms"}
    plate = ev.load("bau_2010/sine").replace({"drive": PULSE, "time": grid, LEAK: "2e-9 S/m"})
    force = ev.prepare(plate, free=[GAP]).signals([3e-6], names=["electrostatic_force"], time=TIMES)
    values = force["electrostatic_force"]
    values = values + 0.01 * values.max() * rng.normal(size=TIMES.size)
    voltage = plate.drive.voltage(TIMES) + 0.2 * rng.normal(size=TIMES.size)
    signals = {"electrostatic_force": (("time",), values), "drive_voltage": (("time",), voltage)}
    ev.save(make_trace(signals, {"time": TIMES}, {}), here / "a.nc")
    for name, changes in (("right", {}), ("wrong", {LEAK: 0.0}), ("high", {"drive.high": "300 V"})):
        (here / f"{name}.toml").write_text(to_toml(plate.replace(changes)))
    return here


def test_a_model_that_does_not_describe_its_recording_ends_with_3_and_says_so_in_every_file(recorded, cli):
    code, out, _ = cli(f"fit wrong.toml a.nc --free {GAP} -o out")
    assert code == 3
    words = "warning: the model does not describe this recording: electrostatic_force of a.nc"
    assert out.startswith(words)
    of_scenario = ("warning: the voltage across", "not judged:", "written:")  # which every command prints
    assert len([line for line in out.splitlines() if not line.startswith(of_scenario)]) <= 5
    for name in ("report.html", "parameters.csv", "parameters.toml", "space.toml"):
        text = (recorded / "out" / name).read_text().lower()
        assert "the model does not describe this recording" in text, name
    assert ",misfit," in (recorded / "out" / "parameters.csv").read_text()


def test_a_voltage_that_differs_is_stated_with_both_numbers_and_refused_where_it_was_set(
    recorded, cli, said, refused
):
    assert "does not describe" not in said(f"fit right.toml a.nc --free {GAP}")
    out = said(f"fit high.toml a.nc --free {GAP}")
    assert "a.nc: the drive has up to 100." in out
    assert "300 V in the scenario" in out
    changed = f"fit right.toml a.nc --free {GAP} --set 'drive.high=300 V'"
    assert "--keep drive" in refused(changed)
    code, out, _ = cli(f"{changed} --keep drive")
    assert code in {0, 3}
    assert f"{GAP}: 1" in out  # um, three times as wide and more


def test_laws_are_weighed_and_what_cannot_be_fitted_says_why(recorded, cli):
    free = f"--free {GAP},{LEAK}"
    code, out, _ = cli(f"fit-laws right.toml a.nc {free} --laws EffectiveMedium --all -o out")
    assert code == 0
    first, *lines = out.splitlines()
    assert first.startswith("MaxwellStressInGap is more than a million times as probable as the next, ")
    for model, share in (
        ("MaxwellStressInGap", "100 %"),
        ("EffectiveMedium", "< 0.01 %"),
        ("EffectiveMedium without leak", "< 0.01 %"),
    ):
        assert any(re.match(f"{model}  .* {share} ", line) for line in lines), model
    page = (recorded / "out" / "report.html").read_text()
    for words in (
        "ln evidence below the best",
        "What speaks against it",
        "a factor of 100 from the value",
        "dynesty",
    ):
        assert words in page, words
    assert page.count("<figure>") == 3  # with that of the residuals by each model
    few = cli(f"fit-laws right.toml a.nc {free} --laws EffectiveMedium")[1].splitlines()
    assert few[0] == first
    told = cli(f"fit-laws right.toml a.nc --free {GAP} --all")[1]
    not_fitted = told.partition("Models not fitted")[2]
    assert re.search("EffectiveMedium without gap +has none of the free", not_fitted)
    assert re.search(r"Persson2018RoughGap +force\.mean_gap", not_fitted)
    assert re.search("Vezzoli2014PerFrequency ", not_fitted)


def test_laws_are_known_and_need_dynesty(recorded, refused, monkeypatch):
    assert "EffectiveMedium" in refused(f"fit-laws right.toml a.nc --free {GAP} --laws EffectiveMediu")
    monkeypatch.setitem(sys.modules, "dynesty", None)
    with pytest.raises(InputError, match=r"dynesty.*pip install 'electrovib\[fit\]'"):
        ev.fit_laws("right.toml", "a.nc", free=[GAP])


def test_the_seed_of_the_evidence_is_that_of_the_command_and_a_cancelled_fit_ends(recorded, monkeypatch):
    seeds = []
    kept = fit_module.weigh
    monkeypatch.setattr(fit_module, "weigh", lambda *a, **k: seeds.append(k["seed"]) or kept(*a, **k))
    laws = {"free": [GAP], "laws": ["EffectiveMedium"]}
    ev.fit_laws("right.toml", "a.nc", seed=3, **laws)
    ev.fit_laws("right.toml", "a.nc", **laws)
    assert seeds == [3, 0]
    counted = []

    def at_second(count, _):
        counted.append(count)
        return counted.count(1) == 2  # of the second model

    with pytest.raises(CancelledError):
        ev.fit_laws("right.toml", "a.nc", progress=at_second, **laws)


@pytest.fixture(scope="module")
def six(tmp_path_factory):
    """A scenario and its impedance at six frequencies, with 0.1 % of noise."""
    place, rng = tmp_path_factory.mktemp("posterior"), np.random.default_rng(3)
    grid = {"frequency.low": 1e2, "frequency.high": 1e5, "frequency.samples": 6}
    plate = ev.load("bau_2010/sine").replace(grid)
    (place / "plate.toml").write_text(to_toml(plate))
    exact = ev.simulate(plate)
    noise = 1e-3 * rng.normal(size=6) + 1e-3j * rng.normal(size=6)
    values = {"impedance": (("frequency",), exact["impedance"].values * (1 + noise))}
    ev.save(make_trace(values, {"frequency": exact["frequency"].values}, {}), place / "a.nc")
    return place / "plate.toml", place / "a.nc"


def test_the_posterior_distribution_is_kept_with_its_diagnostics_and_repeated(six, here, said):
    sampling = ev.Sampling(seed=1, steps=40)
    found = ev.fit(*six, free=[GAP], posterior=sampling, output="out")
    posterior, estimate = found.posterior, found.best.estimate
    assert len(posterior.problems) == 1  # 40 steps are too few
    assert set(posterior.samples[GAP]) <= set(posterior.chains[GAP][20:].ravel())
    best = np.unravel_index(np.argmax(posterior.log_density), posterior.log_density.shape)
    near = pytest.approx(estimate.values[GAP], abs=0.3 * estimate.standard_deviations[GAP])
    assert posterior.chains[GAP][best] == near
    with h5netcdf.File(here / "out" / "posterior.nc", "r") as file:
        assert file["value"].shape == (1, 40, 4)
        np.testing.assert_array_equal(file["value"][0], posterior.chains[GAP])
        assert file["parameter"][0] in {GAP, GAP.encode()}
        assert file["unit"][0] in {"m", b"m"}
        assert file["log_density"].shape == (40, 4)
        assert (file.attrs["burn_in"], file.attrs["seed"]) == (20, 1)
        assert json.loads(file.attrs["problems"]) == list(posterior.problems)
    page = (here / "out" / "report.html").read_text()
    for words in ("Posterior distribution", "4 chains of 40 steps", "may not represent", "MCMC Hammer"):
        assert words in page
    out = said("fit", *six, "--free", GAP, "--posterior", "--seed", "1", "-n", "40", "-o", "out")
    assert "Posterior distribution" in out
    assert "The samples may not represent the distribution" in " ".join(out.split())
    with h5netcdf.File(here / "out" / "posterior.nc", "r") as file:
        np.testing.assert_array_equal(file["value"][0], posterior.chains[GAP])


def test_a_posterior_distribution_that_is_cancelled_is_not_written(six, here):
    sampling = ev.Sampling(seed=1, steps=40, progress=lambda done, total: (done, total) == (3, 40))
    with pytest.raises(CancelledError):
        ev.fit(*six, free=[GAP], posterior=sampling, output="out")
    assert not (here / "out").exists()
    with pytest.raises(InputError, match="seed = -1"):
        ev.Sampling(seed=-1)
