"""No command replaces an input, and a file that electrovib did not write only with ``--force``."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

import electrovib as ev
from electrovib.apps.cli import main
from electrovib.core.errors import InputError
from electrovib.data.marks import Form, is_ours
from electrovib.export.design import write_design
from electrovib.study.population.files import write_group
from electrovib.view import report
from electrovib.view.checked import write_check

DRIVE = "time [s],voltage [V]\n0,0\n1e-3,100\n2e-3,0\n"
STACK = """
schema = 1
force = { model = "Vezzoli2014Causal" }
friction = { model = "Coulomb", coefficient = 0.5 }
contact = { model = "FixedArea", area = "1 cm2" }
time.samples = 21
frequency.samples = 3
[load]
normal_force = "0.5 N"
[circuit]
return_path = { model = "Grounded", resistance = "1 kohm" }
[stack.insulator]
thickness = "90 um"
material = { model = "Constant", permittivity = 3.35 }
[stack.stratum_corneum]
thickness = "200 um"
material = { model = "Constant", permittivity = 1560, conductivity = "1.79 uS/m" }
"""
PULSE = '[drive]\nmodel = "Trapezium"\nhigh = "1 kV"\nrise = "1 ms"\nhold = "1 ms"\nfall = "1 ms"\n'
MEASURED = '[drive]\nmodel = "Sampled"\nfile = "drive.csv"\n'


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return a folder with two scenarios, a measured drive, a Trace and files of others."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(report, "figures", lambda *_: [])  # which take the time, and are not the point here
    for name, text in {
        "drive.csv": DRIVE,
        "s.toml": STACK + MEASURED,
        "b.toml": STACK + PULSE,
        "meas.csv": "time,force\n0,1\n",
        "z.frequency.csv": "my,numbers\n1,2\n",
        "notes.html": "<p>mine</p>",
        "old.nc": "not HDF5",
        "old.mat": "MATLAB 5.0 MAT-file of somebody else",
        "old.cir": "* my circuit\n.end\n",
        "old.toml": "schema = 1\n",
    }.items():
        (tmp_path / name).write_text(text)
    ev.run("b.toml", output="t.nc")
    ev.save(ev.open_trace("t.nc"), "t.csv")
    return tmp_path


@pytest.fixture
def cli(here, capsys, monkeypatch):
    """Return a function that runs a command in this process: exit code and error output."""

    def call(*arguments: str) -> tuple[int, str]:
        monkeypatch.setattr(sys, "argv", ["electrovib", *arguments])
        with pytest.raises(SystemExit) as stop:
            main()
        return int(stop.value.code or 0), capsys.readouterr().err

    return call


def contents(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir()}


INPUTS = {
    "the drive of the scenario": ["run", "s.toml", "-o", "drive.csv"],
    "a measured file named by an option": [
        "run", "b.toml", "--set", 'drive={ model = "Sampled", file = "drive.csv" }', "-o", "drive.csv",
    ],
    "the repeated Trace": ["run", "t.nc", "-o", "t.nc"],
    "the second file of the repeated Trace": ["run", "t.csv", "-o", "t.frequency.csv"],
    "the scenario of a new one": ["init", "b.toml", "-o", "b.toml"],
}  # fmt: skip


@pytest.mark.parametrize("case", INPUTS)
@pytest.mark.parametrize("force", [(), ("--force",)])
def test_an_input_stays_whatever_is_forced(case, force, cli, here):
    before = contents(here)
    code, err = cli(*INPUTS[case], *force)
    assert code == 2
    assert "is an input" in err
    assert len(err.splitlines()) == 1
    assert contents(here) == before


PAGES = [
    ["report", "t.nc", "-o", "t.nc"],
    ["report", "t.nc", "-o", "meas.csv"],
    ["report", "b.toml", "-o", "b.toml"],
    ["run", "b.toml", "--report", "b.toml"],
    ["compare", "b.toml", "-o", "b.toml"],
]


@pytest.mark.parametrize("arguments", PAGES)
def test_a_report_is_an_html_file(arguments, cli, here):
    before = contents(here)
    code, err = cli(*arguments, "--force")
    assert code == 2
    assert f"{arguments[-1]}: a report or a comparison is an .html file" in err
    assert contents(here) == before


OTHERS = {
    "z.frequency.csv": ["run", "b.toml", "-o", "z.csv"],
    "meas.csv": ["run", "b.toml", "-o", "meas.csv"],
    "old.nc": ["run", "b.toml", "-o", "old.nc"],
    "old.mat": ["run", "b.toml", "-o", "old.mat"],
    "notes.html": ["report", "t.nc", "-o", "notes.html"],
    "old.cir": ["export", "b.toml", "old.cir"],
    "old.toml": ["init", "b.toml", "-o", "old.toml"],
}


@pytest.mark.parametrize("name", OTHERS)
def test_a_file_of_somebody_else_needs_force(name, cli, here):
    before = contents(here)
    code, err = cli(*OTHERS[name])
    assert code == 2
    assert err.startswith(f"electrovib: {name}: exists already")
    assert "--force" in err
    assert contents(here) == before
    assert cli(*OTHERS[name], "--force") == (0, "")
    changed = contents(here)
    assert changed[name] != before[name]
    assert {other for other in before if changed[other] != before[other]} == {name}
    assert cli(*OTHERS[name]) == (0, "")  # now it is ours


@pytest.mark.parametrize(("option", "name"), [("--report", "notes.html"), ("-o", "page.html")])
def test_pages_of_run_and_compare_keep_others_too(option, name, cli, here):
    (here / "page.html").write_text("mine")
    command = (
        ["run", "b.toml"] if option == "--report" else ["compare", "b.toml", "--models", "MaxwellStressInGap"]
    )
    code, err = cli(*command, option, name)
    assert code == 2
    assert f"{name}: exists already and is no HTML page" in err


def test_what_we_wrote_is_replaced_until_somebody_changes_it(cli, here):
    for arguments, name in (
        (["run", "b.toml", "-o", "a.nc"], "a.nc"),
        (["run", "b.toml", "-o", "a.csv"], "a.frequency.csv"),
        (["run", "b.toml", "-o", "a.mat"], "a.mat"),
        (["report", "t.nc", "-o", "a.html"], "a.html"),
        (["export", "b.toml", "a.cir"], "a.cir"),
        (["init", "b.toml", "-o", "a.toml"], "a.toml"),
    ):
        assert cli(*arguments) == (0, "")
        assert cli(*arguments) == (0, "")
        with (here / name).open("ab") as file:
            file.write(b"\n")
        code, err = cli(*arguments)
        assert code == 2
        assert f"{name}: exists already" in err
        assert "or it was changed since" in err


def test_the_parts_of_a_csv_are_told_apart(cli, here):
    """A main file called a.frequency.csv is not the second file of a.csv."""
    assert cli("run", "b.toml", "-o", "a.frequency.csv")[0] == 0
    code, err = cli("run", "b.toml", "-o", "a.csv")
    assert code == 2
    assert "a.frequency.csv: exists already and is no part of a Trace" in err


def test_every_form_is_known_from_its_content_and_not_from_its_name(here):
    written = {
        Form.NETCDF: "t.nc",
        Form.CSV: "t.csv",
        Form.CSV_PART: "t.frequency.csv",
        Form.MATLAB: str(ev.save(ev.open_trace("t.nc"), "t.mat")[0]),
        Form.PAGE: str(ev.report("t.nc", "t.html")),
        Form.NETLIST: str(ev.export("b.toml", "t.cir")),
    }
    ev.init("b.toml", output="t.toml")
    written[Form.SCENARIO] = "t.toml"
    ev.fit(
        "b.toml", "t.nc", free=["stack.insulator.thickness"], signals=["electrostatic_force"], output="fit"
    )
    written |= {Form.TABLE: "fit/parameters.csv", Form.SPACE: "fit/space.toml"}
    written[Form.CHECK] = str(write_check(ev.check("b.toml"), "check.json"))
    wanted = ev.design("b.toml", want="peak electrostatic_force = 1 mN", free="drive.high")
    write_design(wanted, "design.json")
    written[Form.DESIGN] = "design.json"
    limits = {"voltage": 1e4, "current": 1.0}
    written[Form.WAVEFORM] = str(ev.export("b.toml", "played.csv", limits=limits, ramp=1e-3, edge="line"))
    Path("study").mkdir()
    write_group(Path("study"), {})
    written[Form.STUDY] = "study/zarr.json"
    assert set(written) == set(Form)
    for form, name in written.items():
        moved = Path(name).rename("moved.txt")
        assert [other for other in Form if is_ours(moved, other)] == [form]


def test_a_trace_resaved_by_another_program_is_the_users(here):
    import xarray

    with xarray.open_dataset("t.nc") as opened:
        changed = opened.load().assign_attrs(note="mine")
    changed.to_netcdf("t.nc", engine="h5netcdf")
    with pytest.raises(InputError, match=r"t\.nc: exists already"):
        ev.save(changed, "t.nc")
    assert ev.open_trace("t.nc").attrs["note"] == "mine"
    assert "written_by" not in ev.open_trace("t.nc").attrs


def test_a_large_trace_has_its_mark_near_its_beginning(here):
    trace = ev.open_trace("t.nc")
    trace.attrs |= {f"note_{number}": "x" * 7000 for number in range(60)}
    for name in ("large.nc", "large.csv", "large.mat"):
        ev.save(trace, name)
        ev.save(trace, name)
