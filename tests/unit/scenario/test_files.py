"""Names of files in a scenario are relative to it, and a file that cannot be read is one mistake among others."""

from __future__ import annotations

from typing import Annotated, Any, ClassVar

import pytest

from electrovib.core.errors import InputError
from electrovib.core.files import FileColumn, inputs_noted
from electrovib.core.model import Model
from electrovib.core.quantity import Number, Quantity
from electrovib.core.samples import Samples
from electrovib.physics.drive.base import Drive
from electrovib.physics.material import Material
from electrovib.physics.stack import Stack
from electrovib.scenario import load, read_part

RECORD = {"model": "Sampled", "file": "record.csv"}
SKIN = {"model": "Tabulated", "file": "skin.csv", "conductivity": 0}


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "record.csv").write_text("time [ms],voltage [V]\n0,1\n1,2\n", encoding="utf-8")
    return tmp_path


def test_names_are_relative_to_the_scenario(folder):
    drive = read_part(Drive, RECORD, folder=folder)
    assert drive.time_samples.values.tolist() == [0.0, 1e-3]
    assert drive.voltage_samples.values.tolist() == [1.0, 2.0]
    assert drive.file == "record.csv"


def test_names_are_relative_to_the_working_folder_otherwise(folder, monkeypatch, tmp_path_factory):
    monkeypatch.chdir(folder)
    assert read_part(Drive, RECORD).duration == 1e-3
    monkeypatch.chdir(tmp_path_factory.mktemp("elsewhere"))
    with pytest.raises(InputError, match=r"record\.csv: there is no such file"):
        read_part(Drive, RECORD)
    assert read_part(Drive, RECORD | {"file": str(folder / "record.csv")}).duration == 1e-3


def test_a_file_inside_a_list_inside_a_part_is_read(folder):
    drives = {"model": "Sum", "drives": [{"model": "Step", "level": 1}, RECORD]}
    scenario = load("vezzoli_2014/fig6", changes={"drive": {"model": "Step", "level": 1}})
    content = scenario.to_dict() | {"drive": drives}
    with inputs_noted() as inputs:
        assert read_part(type(scenario), content, folder=folder).drive.drives[1].duration == 1e-3
    assert inputs == [folder / "record.csv"]
    assert "time_samples" not in RECORD, "what was given stays as it is"
    with pytest.raises(InputError) as caught:
        read_part(type(scenario), content, folder=folder / "elsewhere")
    (problem,) = caught.value.problems
    assert problem.path == "drive.drives.1"
    assert problem.value == "{model = 'Sampled', file = 'record.csv', ...}"


def test_a_file_that_cannot_be_read_does_not_hide_the_other_mistakes(folder):
    layers = {
        "insulator": {"thickness": "2 V", "material": {"model": "Constant", "permittivity": 3}},
        "stratum_corneum": {"thickness": "20 um", "material": SKIN | {"frequenzy_unit": "Hz"}},
    }
    with pytest.raises(InputError) as caught:
        read_part(Stack, layers, folder=folder)
    found = {problem.path: problem.reason for problem in caught.value.problems}
    assert set(found) == {
        "insulator.thickness",
        "stratum_corneum.material",
        "stratum_corneum.material.frequenzy_unit",
    }
    assert found["stratum_corneum.material"].endswith("skin.csv: there is no such file.")


def test_numbers_that_came_along_are_not_read_again(folder):
    first = read_part(Drive, RECORD, folder=folder)
    (folder / "record.csv").unlink()
    assert read_part(Drive, first.to_dict(), folder=folder) == first


class Gauge(Model):
    """Model with one column of a file."""

    example: ClassVar[dict[str, Any]] = {}
    file: str = ""
    largest: Annotated[Number, Quantity("N", 0, 10, "largest force")] = 1.0
    force_samples: Samples = Samples([])

    @classmethod
    def file_columns(cls, table):
        return {"force_samples": FileColumn("force", "N", " Or give none.")} if table.get("file") else {}


def test_any_model_may_declare_columns_and_what_else_can_be_done(folder):
    (folder / "force.csv").write_text("force [mN],x\n1,1\n2,1\n", encoding="utf-8")
    gauge = read_part(Gauge, {"file": "force.csv"}, folder=folder)
    assert gauge.force_samples.values.tolist() == [1e-3, 2e-3]
    assert read_part(Gauge, {}, folder=folder) == Gauge()
    (folder / "force.csv").write_text("forse [mN],x\n1,1\n2,1\n", encoding="utf-8")
    with pytest.raises(
        InputError, match=r"no column 'force'. Did you mean 'forse'\? It has: forse, x\. Or give none\."
    ):
        read_part(Gauge, {"file": "force.csv"}, folder=folder)


@pytest.mark.parametrize(
    ("heading", "values", "form"),
    [
        ("resistivity (ohm m)", [1e6, 9e5, 8e5, 7e5], "Resistivity"),
        ("conductivity [S/m]", [1e-6, 1.1e-6, 1.2e-6, 1.3e-6], "Conductivity"),
        ("loss_tangent", [2.0, 1.0, 0.5, 0.3], "LossTangent"),
        ("loss", [2e3, 1e3, 5e2, 3e2], "LossFactor"),
    ],
)
def test_the_column_of_a_table_tells_the_form_of_its_loss(folder, heading, values, form):
    rows = "".join(f"{10.0**place},1000,{value}\n" for place, value in enumerate(values, 1))
    (folder / "skin.csv").write_text(f"frequency (Hz),permittivity,{heading}\n{rows}", encoding="utf-8")
    skin = read_part(Material, SKIN, folder=folder)
    assert type(skin.loss).__name__ == form
    assert skin.loss_samples.values == pytest.approx(values)
    other = "LossFactor" if form != "LossFactor" else "Resistivity"
    with pytest.raises(InputError, match="there is no column"):
        read_part(Material, SKIN | {"loss": {"model": other}}, folder=folder)


def test_a_table_without_any_form_of_loss_names_all_forms(folder):
    (folder / "skin.csv").write_text("frequency,permittivity\n1,2\n", encoding="utf-8")
    with pytest.raises(
        InputError, match=r"no column 'loss'.* Conductivity, LossFactor, LossTangent, Resistivity"
    ):
        read_part(Material, SKIN, folder=folder)


def test_a_measured_skin_is_set_in_a_scenario(folder, monkeypatch):
    monkeypatch.chdir(folder)
    rows = "".join(f"{10.0**place},1000,1e6\n" for place in range(5))
    (folder / "skin.csv").write_text(
        f"frequency (Hz),permittivity,resistivity (ohm m)\n{rows}", encoding="utf-8"
    )
    changed = load("vezzoli_2014/fig6", changes={"stack.stratum_corneum.material": SKIN})
    assert changed.stack.layers["stratum_corneum"].material.band == (1, 1e4)
