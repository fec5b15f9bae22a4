"""Scenarios from files, names and Traces, files that they name in turn, and inputs that are none."""

import os

import pytest

import electrovib as ev
from electrovib.core.errors import InputError
from electrovib.core.files import inputs_noted
from electrovib.core.signals import make_trace
from electrovib.data.traces import load_nc, open_trace, save_nc
from electrovib.physics.drive.base import Drive
from electrovib.physics.material import Material
from electrovib.physics.stack import Stack
from electrovib.scenario import load, read_part, scenario_of, sweep_of
from electrovib.scenario.space import read_space
from electrovib.studies.check.result import limits_from

PAPER = load("vezzoli_2014/fig6")
RECORD = {"model": "Sampled", "file": "record.csv"}
SKIN = {"model": "Tabulated", "file": "skin.csv", "conductivity": 0}


def refusal(call, *arguments, **more):
    with pytest.raises(InputError) as caught:
        call(*arguments, **more)
    assert all("\n" not in problem for problem in caught.value.problems)
    return str(caught.value)


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ("x = " + "[" * 5000 + "]" * 5000, "not valid TOML: its tables and lists are nested more than 50"),
        ("x = " + "1" * 5000, "not valid TOML: it has a whole number of thousands of digits"),
        ("\nschema = " + "1" * 400, "schema = 1111"),
        ("load = { normal_force = " + "1" * 400 + " }", "must be a finite number; expected a force"),
        ("\ufeff".encode("utf-16"), "not a text in UTF-8; a scenario is TOML, saved as UTF-8"),
        ('\ufeffschema = 1\n[load]\nnormal_force = "2 V"', "normal_force = '2 V': expected a force"),
    ],
)
def test_toml_that_is_refused(tmp_path, content, words):
    path = tmp_path / "a.toml"
    if isinstance(content, str) and not content.startswith(("\ufeff", "\n")):
        content = f"schema = 1\n{content}"
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    said = refusal(load, path)
    assert words in said
    assert len(said.splitlines()[0]) < 400


def test_what_is_no_ordinary_file_is_not_opened(tmp_path):
    os.mkfifo(tmp_path / "pipe.toml")
    for path in (tmp_path / "pipe.toml", "/dev/zero"):
        assert "is not an ordinary file" in refusal(load, path)
    assert "is a folder" in refusal(load, tmp_path)
    assert "No such file" in refusal(load, tmp_path / "no.toml")
    assert "save it as a .toml file" in refusal(load, "-")


def test_a_table_of_another_kind_is_one_sentence_a_reason():
    kinds = {name: {} for name in ("drive", "force", "stack", "load", "circuit")}
    listed = "unknown parameters 'drive', 'force', 'stack', 'load', 'circuit' of Limits. Known: "
    assert refusal(limits_from, kinds).startswith(f"limits: {listed}")
    said = refusal(read_space, PAPER, {"space": {}, "drive": {}, "force": {}, "circuit": {}})
    assert "drive, force, circuit: unknown part of a space. Known: " in said
    missing = "missing: 'drive', 'force', 'friction', 'contact', 'load', 'circuit', 'stack' of Scenario"
    assert refusal(ev.load, {"title": "nothing"}) == missing
    assert "seed = -1: expected a whole number from 0" in refusal(ev.run_bench, PAPER, simulate=True, seed=-1)


def carrying(**attributes):
    return make_trace({"current": (("time",), [1.0, 2.0])}, {"time": [0.0, 1.0]}, attributes)


def test_what_a_trace_carries_is_given_back(tmp_path):
    over, quantities = '{"drive.rise": [1.0, 2.0]}', '["current.max"]'
    save_nc(carrying(scenario=PAPER.to_json(), over=over, quantities=quantities), tmp_path / "a.nc")
    found = load_nc(tmp_path / "a.nc")
    assert scenario_of(found) == PAPER
    assert sweep_of(found) == ({"drive.rise": [1.0, 2.0]}, ["current.max"])
    assert sweep_of(carrying()) == ({}, [])
    save_nc(carrying(scenario=7), tmp_path / "a.nc")
    for call, given in ((scenario_of, open_trace(tmp_path / "a.nc")), (load, tmp_path / "a.nc")):
        assert "is damaged: it is of type int, not a text" in refusal(call, given)


@pytest.mark.parametrize(
    ("scenario", "words"),
    [
        ("{", "is damaged: Expecting"),
        ("[1]", "is damaged: it holds a list"),
        ("[" * 10_000, "is damaged: its tables and lists are nested"),
        ('{"schema": 2}', "schema = 2"),
        ('{"schema": 1, "contact": 3}', "contact = 3"),
    ],
)
def test_a_damaged_scenario_of_a_trace(scenario, words):
    assert words in refusal(scenario_of, carrying(scenario=scenario))


OVER = ["{", "[1]", 7, "null", '{"drive.rise": 3}', '{"drive.rise": []}', "[" * 10_000]


@pytest.mark.parametrize(
    ("name", "value"),
    [("over", each) for each in OVER] + [("quantities", each) for each in ("{", "{}", 7, "[1]")],
)
def test_a_damaged_sweep_of_a_trace(name, value):
    said = refusal(sweep_of, carrying(**{"over": "{}"} | {name: value}))
    assert f"attribute '{name}' of this Trace is damaged" in said


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "record.csv").write_text("time [ms],voltage [V]\n0,1\n1,2\n", encoding="utf-8")
    return tmp_path


def test_names_are_relative_to_the_scenario_or_to_the_working_folder(folder, monkeypatch, tmp_path_factory):
    drive = read_part(Drive, RECORD, folder=folder)
    assert drive.time_samples.values.tolist() == [0.0, 1e-3]
    assert drive.voltage_samples.values.tolist() == [1.0, 2.0]
    assert drive.file == "record.csv"
    monkeypatch.chdir(folder)
    assert read_part(Drive, RECORD) == drive
    monkeypatch.chdir(tmp_path_factory.mktemp("elsewhere"))
    assert "record.csv: there is no such file" in refusal(read_part, Drive, RECORD)
    assert read_part(Drive, RECORD | {"file": str(folder / "record.csv")}).duration == 1e-3
    (folder / "record.csv").unlink()  # numbers that came along are not read again
    assert read_part(Drive, drive.to_dict(), folder=folder) == drive


def test_a_file_inside_a_list_inside_a_part_is_read(folder):
    drives = {"model": "Sum", "drives": [{"model": "Step", "level": 1}, RECORD]}
    content = PAPER.to_dict() | {"drive": drives}
    with inputs_noted() as inputs:
        assert read_part(type(PAPER), content, folder=folder).drive.drives[1].duration == 1e-3
    assert inputs == [folder / "record.csv"]
    assert "time_samples" not in RECORD, "what was given stays as it is"
    with pytest.raises(InputError) as caught:
        read_part(type(PAPER), content, folder=folder / "elsewhere")
    (problem,) = caught.value.problems
    assert problem.path == "drive.drives.1"
    assert problem.value == "{model = 'Sampled', file = 'record.csv', ...}"


def test_a_file_that_cannot_be_read_does_not_hide_the_other_mistakes(folder):
    insulator = {"thickness": "2 V", "material": {"model": "Constant", "permittivity": 3}}
    skin = {"thickness": "20 um", "material": SKIN | {"frequenzy_unit": "Hz"}}
    with pytest.raises(InputError) as caught:
        read_part(Stack, {"insulator": insulator, "stratum_corneum": skin}, folder=folder)
    found = {problem.path: problem.reason for problem in caught.value.problems}
    material = "stratum_corneum.material"
    assert set(found) == {"insulator.thickness", material, f"{material}.frequenzy_unit"}
    assert found[material].endswith("skin.csv: there is no such file.")


@pytest.mark.parametrize(
    ("heading", "values", "form"),
    [
        ("resistivity (ohm m)", [1e6, 9e5, 8e5, 7e5], "Resistivity"),
        ("conductivity [S/m]", [1e-6, 1.1e-6, 1.2e-6, 1.3e-6], "Conductivity"),
        ("loss_tangent", [2.0, 1.0, 0.5, 0.3], "LossTangent"),
        ("loss", [2e3, 1e3, 5e2, 3e2], "LossFactor"),
    ],
)
def test_the_column_of_a_table_tells_the_form_of_its_loss(folder, monkeypatch, heading, values, form):
    rows = "".join(f"{10.0**place},1000,{value}\n" for place, value in enumerate(values, 1))
    (folder / "skin.csv").write_text(f"frequency (Hz),permittivity,{heading}\n{rows}", encoding="utf-8")
    skin = read_part(Material, SKIN, folder=folder)
    assert type(skin.loss).__name__ == form
    assert skin.loss_samples.values == pytest.approx(values)
    other = SKIN | {"loss": {"model": "LossFactor" if form != "LossFactor" else "Resistivity"}}
    assert "there is no column" in refusal(read_part, Material, other, folder=folder)
    monkeypatch.chdir(folder)
    changed = load(PAPER, changes={"stack.stratum_corneum.material": SKIN})
    assert changed.stack.layers["stratum_corneum"].material == skin
    (folder / "skin.csv").write_text("frequency,permittivity\n1,2\n", encoding="utf-8")
    said = refusal(read_part, Material, SKIN)
    assert "no column 'loss'" in said
    assert 'loss = { model = "..." } with Conductivity, LossFactor, LossTangent, Resistivity' in said


def test_a_trace_holds_the_samples_of_its_record():
    record = {"model": "Sampled", "time_samples": [0, 1e-3, 3.1e-3], "voltage_samples": [0.0, 1 / 3, 1 / 3]}
    scenario = load(PAPER, changes={"drive": record})
    assert scenario_of(ev.simulate(scenario)).drive == scenario.drive
