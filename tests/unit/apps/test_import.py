"""``electrovib import`` and a report with a measurement."""

import sys
import tomllib

import numpy as np
import pytest

import electrovib as ev
from electrovib.apps import cli
from electrovib.core.trace import make_trace

TIME = np.linspace(0, 0.1, 201)


@pytest.fixture
def record(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    rows = np.column_stack([TIME * 1e6, 2 * np.sin(60 * TIME) + 0.2])
    np.savetxt("a.csv", rows, delimiter=";", fmt="%.9g", header="t [us];Ch2", comments="")
    return tmp_path


def run(monkeypatch, *words):
    monkeypatch.setattr(sys, "argv", ["electrovib", *words])
    with pytest.raises(SystemExit) as stop:
        cli.main()
    return stop.value.code or 0


def test_columns_then_a_trace_then_a_report(record, monkeypatch, capsys):
    assert run(monkeypatch, "import", "a.csv") == 0
    assert '--column drive_voltage="Ch2 [V]" -o trace.nc' in capsys.readouterr().out
    options = ["--column", "lateral_force_measured=Ch2 [V]", "--set", "scale.lateral_force_measured=0.5 N/V"]
    assert (
        run(
            monkeypatch,
            "import",
            "a.csv",
            *options,
            "--set",
            "offset.lateral_force_measured=0.2 V",
            "-o",
            "m.nc",
        )
        == 0
    )
    said = capsys.readouterr().out
    assert "multiplied by 0.5 N/V" in said
    assert "written: m.nc" in said
    found = ev.open_trace("m.nc")
    np.testing.assert_allclose(found["lateral_force_measured"], np.sin(60 * TIME), atol=1e-8)
    predicted = make_trace(
        {"lateral_force": (("time",), np.sin(60 * TIME))}, {"time": TIME}, {"title": "run"}
    )
    ev.save(predicted, "run.nc")
    assert run(monkeypatch, "report", "run.nc", "a.csv", *options, "-o", "r.html") == 0
    page = (record / "r.html").read_text(encoding="utf-8")
    assert "Measured and predicted" in page
    assert "100 mN" in page  # the mean of the residual: 0.2 V of offset at 0.5 N/V
    assert run(monkeypatch, "report", "run.nc", "a.csv", "-o", "r.html") == 2
    assert "'electrovib import' makes one" in capsys.readouterr().err


def test_a_material_is_written_as_toml(record, monkeypatch, capsys):
    grid = np.geomspace(10, 1e4, 8)
    np.savetxt(
        "e.csv", np.column_stack([grid, 80 + 0 * grid]), delimiter=",", header="f,permittivity", comments=""
    )
    assert run(monkeypatch, "import", "e.csv", "--as", "material", "-o", "e.toml", "--layer", "film") == 0
    assert "assumed to be 0" in capsys.readouterr().out
    assert "[stack.film.material]" in (record / "e.toml").read_text(encoding="utf-8")
    assert run(monkeypatch, "import", "e.csv", "--as", "material", "-o", "e.toml") == 2
    assert "exists already" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--column", "drive_voltage"], "expected SIGNAL=COLUMN"),
        (["--column", "drive_voltage=Ch2 [V]", "--column", "drive_voltage=t"], "is given twice"),
        (["--as", "picture"], "expected trace or material"),
        (["--set", "reader=txt"], "Did you mean 'text'"),
        (["--as", "material", "-o", "x.csv"], "written as .toml"),
    ],
)
def test_mistakes_are_one_line(record, monkeypatch, capsys, words, said):
    assert run(monkeypatch, "import", "a.csv", *words) == 2
    assert said in capsys.readouterr().err


def test_readers_are_listed(monkeypatch, capsys):
    assert run(monkeypatch, "import") == 0
    assert "Tektronix internal format" in capsys.readouterr().out


def test_calibration_and_a_second_clock(record, monkeypatch, capsys):
    (record / "cal.csv").write_text("u [V];F [N]\n0.2;0\n1.2;0.5\n2.2;1.001\n", encoding="utf-8")
    pulse = np.where((TIME > 0.03) & (TIME < 0.06), 100.0, 0.0)
    rows = np.column_stack([TIME - 0.01, pulse])
    np.savetxt("scope.csv", rows, delimiter=",", header="Time [s],CH1 [V]", comments="")
    rows = np.column_stack([TIME * 1e6, 2 * np.sin(60 * TIME) + 0.2, pulse])
    np.savetxt("daq.csv", rows, delimiter=";", fmt="%.9g", header="t [us];Ch2;Sync [V]", comments="")
    assert run(monkeypatch, "import", "scope.csv", "--column", "drive_voltage=CH1", "-o", "scope.nc") == 0
    words = [
        "import",
        "daq.csv",
        "--column",
        "lateral_force_measured=Ch2 [V]",
        "--column",
        "plate_voltage=Sync",
    ]
    words += ["--set", "calibration.lateral_force_measured=cal.csv"]
    aligned = ["--set", "with=scope.nc", "--set", "edges=drive_voltage=plate_voltage"]
    assert run(monkeypatch, *words, *aligned, "-o", "both.nc") == 0
    said = capsys.readouterr().out
    assert "-10 ms added to its time stamps" in said
    assert "from 2 common edges" in said
    found = ev.open_trace("both.nc")
    expected = np.sin(60 * (found["time"].values + 0.01))
    assert np.abs(found["lateral_force_measured"].values - expected).max() < 2e-3
    assert found["lateral_force_measured"].attrs["gain_uncertainty"] > 0
    assert found["lateral_force_measured"].attrs["units"] == "N"
    assert "gain_uncertainty" not in found["plate_voltage"].attrs
    assert run(monkeypatch, *words, "--set", "clock_shift=1 ms") == 2
    assert "clock_shift: belongs to with=TRACE" in capsys.readouterr().err


def test_a_part_of_a_file_becomes_a_material(record, monkeypatch, capsys):
    grid = np.geomspace(10, 1e5, 9)
    lines = ["EXPLAIN", "TAG\tX", "OCV\tTABLE\t3", "\tPt\tT", "\t#\ts", "\t0\t0", "\t1\t1"]
    for name, size in (("ZCURVE", 1e5), ("ZSECOND", 2e5)):
        lines += [f"{name}\tTABLE", "\tFreq\tZreal\tZimag", "\tHz\tohm\tohm"]
        each = size / (1 + 2j * np.pi * grid * size * 1e-9)
        lines += [f"\t{f}\t{z.real}\t{z.imag}" for f, z in zip(grid, each, strict=True)]
    (record / "z.dta").write_text("\n".join(lines))
    geometry = ["--set", "area=1 cm2", "--set", "thickness=1 mm"]
    words = ["import", "z.dta", "--as", "material", *geometry]
    assert run(monkeypatch, *words, "--set", "part=ZSECOND", "-o", "second.toml") == 0
    assert (
        tomllib.loads((record / "second.toml").read_text())["stack"]["stratum_corneum"]["thickness"] == "1 mm"
    )
    capsys.readouterr()
    found = ev.import_material("z.dta", area="1 cm2", thickness="1 mm", part="ZCURVE")
    stored = ev.import_material("z.dta", area="1 cm2", thickness="1 mm", part="ZSECOND")
    # conduction 1/R of the sample: the loss factor of the second one is half that of the first one
    np.testing.assert_allclose(
        stored.material.loss_samples.values, found.material.loss_samples.values / 2, rtol=1e-9
    )
    assert run(monkeypatch, *words, "--set", "part=ZZ") == 2
    assert "ZCURVE" in capsys.readouterr().err
    fitted = ["fit", "z.dta", *geometry, "--form", "constant", "--set"]
    assert run(monkeypatch, *fitted, "part=ZCURVE") == 0
    first = capsys.readouterr().out
    assert run(monkeypatch, *fitted, "part=ZSECOND") == 0
    assert "conductivity: 100 uS/m" in first
    assert "conductivity: 50 uS/m" in capsys.readouterr().out
