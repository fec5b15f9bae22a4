"""``electrovib import``: columns, recipes, parts of a file, a calibration, a second clock; and reports with a measurement."""

import tomllib

import numpy as np
import pytest

import electrovib as ev
from electrovib.core.signals import make_trace
from electrovib.recordings.fit.measured import MeasuredTrace
from electrovib.recordings.recording import CalibrationError
from electrovib.scenario.toml import to_toml

pytestmark = pytest.mark.usefixtures("blank_pictures")

TIME = np.linspace(0, 0.1, 201)
MEASURED = "lateral_force_measured"


@pytest.fixture
def record(here):
    """A file of an instrument: microseconds, and a force as a voltage with an offset."""
    rows = np.column_stack([TIME * 1e6, 2 * np.sin(60 * TIME) + 0.2])
    np.savetxt("a.csv", rows, delimiter=";", fmt="%.9g", header="t [us];Ch2", comments="")
    return here


def test_columns_then_a_trace_then_a_report(record, said, refused):
    assert "Tektronix internal format" in said("import")
    assert '--column drive_voltage="Ch2 [V]" -o trace.nc' in said("import a.csv")
    options = f"--column '{MEASURED}=Ch2 [V]' --set 'scale.{MEASURED}=0.5 N/V'"
    out = said(f"import a.csv {options} --set 'offset.{MEASURED}=0.2 V' -o m.nc")
    assert "multiplied by 0.5 N/V" in out
    assert "written: m.nc" in out
    np.testing.assert_allclose(ev.open_trace("m.nc")[MEASURED], np.sin(60 * TIME), atol=1e-8)
    signals = {"lateral_force": (("time",), np.sin(60 * TIME))}
    ev.save(make_trace(signals, {"time": TIME}, {"title": "run"}), "run.nc")
    said(f"import a.csv {options} -o with_offset.nc")
    said("report run.nc with_offset.nc -o r.html")
    page = (record / "r.html").read_text(encoding="utf-8")
    assert "Measured and predicted" in page
    assert "100 mN" in page  # the mean of the residual: 0.2 V of offset at 0.5 N/V
    assert "'electrovib import a.csv' reads it" in refused("report run.nc a.csv -o r.html")


@pytest.fixture
def plain(here):
    """A table of two columns, and the options that name them."""
    (here / "a.csv").write_text("t,u\n" + "".join(f"{at / 1000},{1 + at / 1000:.6f}\n" for at in range(20)))
    return f"--column '{MEASURED}=u [V]' --set 'time=t [s]' --set 'scale.{MEASURED}=2 N/V'"


def test_a_recipe_is_written_and_read(here, plain, said, refused):
    options = f"{plain} --set 'crop=5 ms..15 ms' --set detrend={MEASURED}"
    assert said(f"import a.csv {options} -o lab.toml") == "written: lab.toml\n"
    assert tomllib.loads((here / "lab.toml").read_text(encoding="utf-8")) == {
        "time": "t [s]",
        "crop": "5 ms..15 ms",
        "detrend": [MEASURED],
        "scale": {MEASURED: "2 N/V"},
        "columns": {MEASURED: "u [V]"},
    }
    said(f"import a.csv {options} -o first.nc")
    said("import a.csv --recipe lab.toml -o second.nc")
    first, second = ev.open_trace("first.nc"), ev.open_trace("second.nc")
    assert first.equals(second)
    assert first.attrs["history"] == second.attrs["history"]
    assert first.time.size == 11
    said("import a.csv --recipe lab.toml --set 'crop=5 ms..10 ms' -o third.nc")
    assert ev.open_trace("third.nc").time.size == 6
    assert "exists already" in refused(f"import a.csv {options} -o lab.toml")
    said("report second.nc -o r.html")


def test_a_truth_of_a_recipe_is_no_text(here, said, cli):
    rows = "".join(f"{at / 1000:.3f};{at}\n".replace(".", ",") for at in range(20))
    (here / "comma.csv").write_text(f"t;u\n{rows}")
    options = f"--column '{MEASURED}=u [N]' --set 'time=t [s]' --set 'delimiter=;'"
    said(f"import comma.csv {options} --set decimal_comma=true -o a.nc")
    assert ev.open_trace("a.nc").time.values[-1] == pytest.approx(0.019)
    for no in ("false", "False", "no", "0", "off", " NO "):
        assert cli(f"import comma.csv {options} --set 'decimal_comma={no}' -o b.nc")[0] == 2
    for number, yes in enumerate(("True", "yes", "1", "on")):
        said(f"import comma.csv {options} --set decimal_comma={yes} -o c{number}.nc")
        assert ev.open_trace(f"c{number}.nc").time.values[-1] == pytest.approx(0.019)
    for wrong in ("maybe", "2", "ja"):
        code, _, err = cli(f"import comma.csv {options} --set decimal_comma={wrong} -o b.nc")
        assert code == 2
        assert f"decimal_comma = {wrong}: expected true or false" in err


def test_calibration_and_a_second_clock(record, said):
    (record / "cal.csv").write_text("u [V];F [N]\n0.2;0\n1.2;0.5\n2.2;1.001\n", encoding="utf-8")
    pulse = np.where((TIME > 0.03) & (TIME < 0.06), 100.0, 0.0)
    rows = np.column_stack([TIME - 0.01, pulse])
    np.savetxt("scope.csv", rows, delimiter=",", header="Time [s],CH1 [V]", comments="")
    rows = np.column_stack([TIME * 1e6, 2 * np.sin(60 * TIME) + 0.2, pulse])
    np.savetxt("daq.csv", rows, delimiter=";", fmt="%.9g", header="t [us];Ch2;Sync [V]", comments="")
    said("import scope.csv --column drive_voltage=CH1 -o scope.nc")
    words = f"import daq.csv --column '{MEASURED}=Ch2 [V]' --column plate_voltage=Sync"
    aligned = "--set with=scope.nc --set edges=drive_voltage=plate_voltage"
    out = said(f"{words} --set calibration.{MEASURED}=cal.csv {aligned} -o both.nc")
    assert "-10 ms added to its time stamps" in out
    assert "from 2 common edges" in out
    found = ev.open_trace("both.nc")
    expected = np.sin(60 * (found["time"].values + 0.01))
    assert np.abs(found[MEASURED].values - expected).max() < 2e-3
    assert found[MEASURED].attrs["gain_uncertainty"] > 0
    assert found[MEASURED].attrs["units"] == "N"
    assert "gain_uncertainty" not in found["plate_voltage"].attrs


def test_a_material_is_written_as_toml(here, said, refused):
    grid = np.geomspace(10, 1e4, 8)
    rows = np.column_stack([grid, 80 + 0 * grid])
    np.savetxt("e.csv", rows, delimiter=",", header="f,permittivity", comments="")
    assert "assumed to be 0" in said("import e.csv --as material -o e.toml")
    assert "[stack.stratum_corneum.material]" in (here / "e.toml").read_text(encoding="utf-8")
    assert "exists already" in refused("import e.csv --as material -o e.toml")


def test_a_part_of_a_file_becomes_a_material(here, said, refused):
    grid = np.geomspace(10, 1e5, 9)
    lines = ["EXPLAIN", "TAG\tX", "OCV\tTABLE\t3", "\tPt\tT", "\t#\ts", "\t0\t0", "\t1\t1"]
    for name, size in (("ZCURVE", 1e5), ("ZSECOND", 2e5)):
        lines += [f"{name}\tTABLE", "\tFreq\tZreal\tZimag", "\tHz\tohm\tohm"]
        each = size / (1 + 2j * np.pi * grid * size * 1e-9)
        lines += [f"\t{f}\t{z.real}\t{z.imag}" for f, z in zip(grid, each, strict=True)]
    (here / "z.dta").write_text("\n".join(lines))
    geometry = "--set 'area=1 cm2' --set 'thickness=1 mm' --set"
    said(f"import z.dta --as material {geometry} part=ZSECOND -o second.toml")
    layer = tomllib.loads((here / "second.toml").read_text())["stack"]["stratum_corneum"]
    assert layer["thickness"] == "1 mm"
    first, second = (
        ev.import_material(
            "z.dta", ev.SpectrumRecipe(area="1 cm2", thickness="1 mm", part=part)
        ).material.loss_samples.values
        for part in ("ZCURVE", "ZSECOND")
    )
    np.testing.assert_allclose(second, first / 2, rtol=1e-9)  # conduction 1/R of the sample
    assert "ZCURVE" in refused(f"import z.dta --as material {geometry} part=ZZ")
    for part, conductivity in (("ZCURVE", "100 uS/m"), ("ZSECOND", "50 uS/m")):
        out = said(f"fit-material z.dta --form constant {geometry} part={part}")
        (row,) = (line for line in out.splitlines() if line.startswith("conductivity "))
        assert conductivity in row


POINTS = "voltage (kV),force (mN),sd (%)\n0.05,1.1,10\n0.1,4.2,20\n"
SETTINGS = {
    "title": "made up", "source": "this test", "group": "nobody", "scenario": "vezzoli_2014/fig6_gap", "over": "drive.level",
    "changes.drive": '{ model = "Step", level = "100 V" }', "changes.time.duration": "1 ms", "spread_of": "repeats",
    "quantity": "final electrostatic_force",
    "unknown.stack.gap.thickness": '{ model = "LogUniform", low = "1 um", high = "4 um", choice = "of this test" }',
}  # fmt: skip


def test_a_measurement_is_written_and_judged(here, said, refused):
    (here / "points.csv").write_text(POINTS, encoding="utf-8")
    given = " ".join(f"--set '{key}={value}'" for key, value in SETTINGS.items())
    line = f"import points.csv --as measurement --column value=force --column at=voltage --column spread=sd {given}"
    out = said(line)
    assert "drive.level = 100 V: 4.2 mN, spread 20 %" in out
    assert "written" not in out
    assert said(f"{line} -o mine.toml").endswith("written: mine.toml\n")
    (found,) = ev.measurements("mine.toml").values()
    assert (found.values, found.at, found.spread) == ((0.0011, 0.0042), (50.0, 100.0), (0.1, 0.2))
    assert found.unknown["stack.gap.thickness"]["high"] == "4 um"
    said(f"{line} -o mine.toml")  # it is ours
    out = said("evidence mine.toml israr_2006/cylinder -n 4 -o mine.html")
    assert "israr_2006/cylinder" in out
    assert "made up" in (here / "mine.html").read_text(encoding="utf-8")
    second = "import points.csv --as measurement --recipe mine.toml --column value=force --column at=voltage --column spread=sd"
    said(f"{second} --set group=us -o second.toml")
    assert ev.measurements("second.toml")["second"].group == "us"
    (here / "other.toml").write_text("schema = 1\n", encoding="utf-8")
    assert "other.toml: exists already and is no measurement" in refused(f"{line} -o other.toml")
    said(f"{line} -o other.toml --force")
    assert "a measurement is written as .toml" in refused(f"{line} -o other.nc")
    assert refused("import points.csv --as measurement").count("missing, for instance") == 10
    assert "changes: expected changes.PATH=VALUE" in refused(f"{line} --set changes=1")
    assert "Did you mean 'quantity'?" in refused(f"{line} --set quantiti=1")
    assert "expected trace, material or measurement" in refused("import points.csv --as measured")


GAP, FORCE = "stack.gap.thickness", "electrostatic_force"
PLATE = {
    "drive": {"model": "Trapezium", "high": "100 V", "rise": "10 us", "hold": "20 ms", "fall": "10 us"},
    "time": {"model": "TimeGrid", "duration": "30 ms"},
    "stack.gap.material.conductivity": "2e-9 S/m",
}
SENSITIVITY = 0.05
"""N/V of the sensor; its readings below are in mV."""


@pytest.fixture
def weighed(here):
    """A recorded step, and the readings of its sensor under five weights with a scatter of 1 %."""
    plate, rng = ev.load("bau_2010/sine").replace(PLATE), np.random.default_rng(5)
    (here / "plate.toml").write_text(to_toml(plate))
    trace, time = ev.simulate(plate), np.linspace(1e-3, 29e-3, 60)
    force = np.interp(time, trace["time"].values, trace[FORCE].values)
    force += 0.003 * force.max() * rng.normal(size=time.size)
    weights = np.linspace(0, 1.2 * force.max(), 5)
    readings = weights + 0.01 * force.max() * np.array([1.0, -1.5, 0.5, 1.0, -1.0])
    for name, header, columns in (
        ("a.csv", "t [s],u [mV]", (time, 1e3 * force / SENSITIVITY)),
        ("cal.csv", "u [mV],F [N]", (1e3 * readings / SENSITIVITY, weights)),
    ):
        np.savetxt(name, np.column_stack(columns), delimiter=",", fmt="%.17g", header=header, comments="")
    return f"import a.csv --column {FORCE}=u --set calibration.{FORCE}=cal.csv"


def test_a_calibration_at_import_is_the_systematic_error_of_the_fit(weighed, here, said, table):
    said(f"{weighed} -o a.nc")
    stated = ev.open_trace("a.nc")[FORCE].attrs
    assert "by calibration" in said(f"fit plate.toml a.nc --free {GAP} -o fit")
    row = next(row for row in table(here / "fit" / "parameters.csv") if row["name"] == GAP)
    assert float(row["systematic"]) > 0
    assert "y calibration" in (here / "fit" / "report.html").read_text()
    line = ev.calibrate(*(np.loadtxt("cal.csv", delimiter=",", skiprows=1).T * [[1e-3], [1.0]]))
    zero = line.standard_uncertainty(-line.intercept / line.sensitivity)
    assert stated["gain_uncertainty"] == pytest.approx(np.sqrt(line.covariance[1, 1]) / line.sensitivity)
    assert stated["zero_uncertainty"] == pytest.approx(zero)
    error = CalibrationError.from_attributes(stated)
    assert -1 < error.covariance / (error.gain * error.zero) < -0.5
    bare = ev.open_trace("a.nc")
    bare[FORCE].attrs = {"units": "N"}
    by_hand = ev.fit("plate.toml", MeasuredTrace(trace=bare, calibration={FORCE: error}), free=[GAP])
    assert by_hand.rows[0].systematic == float(row["systematic"])
