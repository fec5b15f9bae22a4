"""No command replaces an input, and a file that electrovib did not write only with ``--force``."""

from pathlib import Path

import pytest
import xarray

import electrovib as ev
from electrovib.core.errors import InputError
from electrovib.data.atomic import Form, is_ours, write_text
from electrovib.exports.save import write_design
from electrovib.studies.evidence.files import import_measurement
from electrovib.studies.population.files import write_group
from electrovib.view import report

pytestmark = pytest.mark.usefixtures("blank_pictures")

QUICK = {"time.samples": 21, "frequency.samples": 3, "sources": {}, "drive.rise": "1 ms"}
PULSE = ev.load("vezzoli_2014/fig6", changes=QUICK | {"drive.hold": "1 ms", "drive.fall": "1 ms"})
MEASURED = {"model": "Sampled", "file": "drive.csv"}
FILES = {
    "drive.csv": "time [s],voltage [V]\n0,0\n1e-3,100\n2e-3,0\n",
    "meas.csv": "time,force\n0,1\n",
    "notes.html": "<p>mine</p>",
    "old.nc": "not HDF5",
    "old.mat": "MATLAB 5.0 MAT-file of somebody else",
    "old.cir": "* my circuit\n.end\n",
    "old.toml": "schema = 1\n",
}


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """Two scenarios, the second with a measured drive, a Trace and files of others."""
    folder = tmp_path_factory.mktemp("made")
    for name, text in FILES.items():
        (folder / name).write_text(text)
    ev.init(PULSE, output=folder / "b.toml")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        ev.init(PULSE.replace({"drive": MEASURED}), output="s.toml")
        ev.run("b.toml", output="t.nc")
    return {path.name: path.read_bytes() for path in folder.iterdir()}


@pytest.fixture
def files(made, here, monkeypatch):
    """Return a folder with them."""
    monkeypatch.setattr(report, "figures", lambda *_: [])  # which take the time, and are not the point here
    for name, content in made.items():
        (here / name).write_bytes(content)
    return here


@pytest.mark.parametrize(
    "line",
    [
        "run s.toml -o drive.csv",  # the drive of the scenario
        'run b.toml --set \'drive={ model = "Sampled", file = "drive.csv" }\' -o drive.csv',
        "run t.nc -o t.nc",  # the repeated Trace
        "init b.toml -o b.toml",
    ],
)
@pytest.mark.parametrize("force", ["", "--force"])
def test_an_input_stays_whatever_is_forced(line, force, files, refused):
    err = refused(f"{line} {force}")
    assert "is an input" in err
    assert err.count("\n") == 1


@pytest.mark.parametrize(
    ("name", "line"),
    [
        ("meas.csv", "run b.toml -o meas.csv"),
        ("old.nc", "run b.toml -o old.nc"),
        ("old.mat", "run b.toml -o old.mat"),
        ("notes.html", "report t.nc -o notes.html"),
        ("old.cir", "export b.toml old.cir"),
        ("old.toml", "init b.toml -o old.toml"),
    ],
)
def test_a_file_of_somebody_else_needs_force_and_ours_is_replaced_until_it_is_changed(
    name, line, made, files, cli, refused
):
    err = refused(line)
    assert err.startswith(f"electrovib: {name}: exists already")
    assert "--force" in err
    code, _, err = cli(f"{line} --force")
    assert (code, err) == (0, "")
    changed = {other for other in made if (files / other).read_bytes() != made[other]}
    assert changed == {name}
    assert cli(line)[0] == 0  # now it is ours
    with (files / name).open("ab") as file:
        file.write(b"\n")
    err = refused(line)
    assert f"{name}: exists already" in err
    assert "or it was changed since" in err


@pytest.mark.parametrize("line", ["run b.toml --report", "compare b.toml --models MaxwellStressInGap -o"])
def test_pages_of_run_and_compare_keep_others_too(line, files, refused):
    assert "notes.html: exists already and is no HTML page" in refused(f"{line} notes.html")


def test_every_form_is_known_from_its_content_and_not_from_its_name(files):
    limits, thickness = {"voltage": 1e4, "current": 1.0}, ["stack.insulator.thickness"]
    force = ev.Recordings(traces="t.nc", quantity=["electrostatic_force"])
    ev.fit("b.toml", force, free=thickness, output="fit")
    write_design(
        ev.find_value("b.toml", want="peak electrostatic_force = 1 mN", free="drive.high"), "design.json"
    )
    Path("study").mkdir()
    write_group(Path("study"), {})
    ev.init("b.toml", output="t.toml")
    Path("points.csv").write_text("u [V],f [N]\n1,1\n2,4\n", encoding="utf-8")
    said = {
        "title": "t",
        "source": "s",
        "group": "g",
        "scenario": "b.toml",
        "quantity": "peak electrostatic_force",
    }
    points = import_measurement(
        "points.csv", {"value": "f", "at": "u"}, **said, over="drive.high", spread=0.1, spread_of="repeats"
    )
    write_text(Path("m.toml"), points.to_toml(), Form.MEASUREMENT)
    written = {
        Form.MEASUREMENT: "m.toml",
        Form.NETCDF: "t.nc",
        Form.MATLAB: ev.save(ev.open_trace("t.nc"), "t.mat")[0],
        Form.PAGE: ev.report("t.nc", "t.html"),
        Form.NETLIST: ev.export("b.toml", "t.cir"),
        Form.SCENARIO: "t.toml",
        Form.TABLE: "fit/parameters.csv",
        Form.SPACE: "fit/space.toml",
        Form.CHECK: ev.save(ev.check("b.toml"), "check.json")[0],
        Form.DESIGN: "design.json",
        Form.WAVEFORM: ev.export("b.toml", "played.csv", limits=limits, ramp=1e-3, edge="line"),
        Form.STUDY: "study/zarr.json",
        Form.FIGURE: ev.save(ev.check("b.toml"), "check.pdf")[0],
        Form.LATEX: ev.save(ev.check("b.toml"), "check.tex")[0],
        Form.TEXT: "fit/fit.txt",
    }
    assert set(written) == set(Form)
    for form, name in written.items():
        moved = Path(name).rename("moved.txt")
        assert [other for other in Form if is_ours(moved, other)] == [form]


def test_a_trace_resaved_by_another_program_is_the_users_and_a_large_one_is_still_ours(files):
    with xarray.open_dataset("t.nc") as opened:
        changed = opened.load().assign_attrs(note="mine")
    changed.to_netcdf("t.nc", engine="h5netcdf")
    with pytest.raises(InputError, match=r"t\.nc: exists already"):
        ev.save(changed, "t.nc")
    with pytest.raises(InputError, match=r"t\.nc: is damaged.*without its attribute written_by"):
        ev.open_trace("t.nc")
    del changed.attrs["written_by"]
    changed.to_netcdf("t.nc", engine="h5netcdf")
    again = ev.open_trace("t.nc")
    assert "not verified: t.nc" in again.attrs["validity"]
    assert again.attrs["note"] == "mine"
    assert "written_by" not in again.attrs
    again.attrs |= {f"note_{number}": "x" * 7000 for number in range(60)}
    for name in ("large.nc", "large.csv", "large.mat"):  # whose mark is near the beginning
        ev.save(again, name)
        ev.save(again, name)
