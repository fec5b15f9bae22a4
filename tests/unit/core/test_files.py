"""Files named in a scenario are looked for beside it, and a bad one joins the other mistakes."""

from __future__ import annotations

import pytest
from pydantic_core import PydanticCustomError

from electrovib.core.files import read_columns, relative_to

WANTED = {"time_samples": ("time", "s"), "voltage_samples": ("voltage", "V")}


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "record.csv").write_text("time [ms],voltage [V]\n0,1\n1,2\n", encoding="utf-8")
    return tmp_path


def test_names_are_relative_to_the_scenario(folder):
    with relative_to(folder):
        columns = read_columns("record.csv", WANTED)
    assert columns["time_samples"].tolist() == [0.0, 1e-3]
    assert columns["voltage_samples"].tolist() == [1.0, 2.0]


def test_the_folder_is_forgotten_afterwards(folder, monkeypatch, tmp_path_factory):
    monkeypatch.chdir(tmp_path_factory.mktemp("elsewhere"))
    with pytest.raises(RuntimeError, match="stop"), relative_to(folder):
        raise RuntimeError("stop")
    with pytest.raises(PydanticCustomError):
        read_columns("record.csv", WANTED)


def test_a_missing_file_is_a_mistake_of_the_scenario(folder):
    with relative_to(folder), pytest.raises(PydanticCustomError, match=r"absent\.csv"):
        read_columns("absent.csv", WANTED)


def test_absolute_names_stay(folder):
    assert len(read_columns(str(folder / "record.csv"), WANTED)["time_samples"]) == 2
