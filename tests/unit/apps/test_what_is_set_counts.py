"""A parameter that is set has an effect, or is refused."""

from __future__ import annotations

import json
import sys

import numpy as np
import pytest

import electrovib as ev
from electrovib.apps.cli import main
from electrovib.core.errors import InputError

QUICK = {"time.samples": 51, "frequency.samples": 3}


@pytest.fixture(scope="module")
def swept(tmp_path_factory):
    """Return the file of a sweep of two values."""
    path = tmp_path_factory.mktemp("swept") / "swept.nc"
    ev.run(
        set=QUICK, over={"drive.high": [500.0, 1000.0]}, quantities=["mean electrostatic_force"], output=path
    )
    return path


def test_a_parameter_is_set_or_swept(tmp_path, capsys, monkeypatch):
    command = [
        "run",
        "--set",
        "drive.high=5 V",
        "--over",
        "drive.high=1V:10V:3",
        "-o",
        str(tmp_path / "a.nc"),
    ]
    monkeypatch.setattr(sys, "argv", ["electrovib", *command])
    with pytest.raises(SystemExit, match="2"):
        main()
    err = capsys.readouterr().err
    assert err.startswith("electrovib: drive.high: is set, but swept with --over as well")
    assert len(err.splitlines()) == 1
    assert list(tmp_path.iterdir()) == []


def test_a_parameter_that_a_repeated_sweep_goes_over_is_not_set(swept):
    with pytest.raises(
        InputError, match=r"drive\.high: is set, but swept in .*swept\.nc as well.*electrovib init"
    ):
        ev.run(swept, set={"drive.high": "5 V"})


def test_another_parameter_of_a_repeated_sweep_counts(swept):
    thick = ev.run(swept, set={"stack.insulator.thickness": "180 um"})
    first = ev.open_trace(swept)
    name = "mean electrostatic_force"
    assert np.all(thick[name].values < first[name].values)
    np.testing.assert_array_equal(thick["drive.high"], first["drive.high"])
    again = ev.scenario_of(thick)
    assert again.stack.insulator.thickness == pytest.approx(180e-6, rel=1e-12)


def test_a_further_parameter_joins_a_repeated_sweep(swept):
    both = ev.run(swept, over=["stack.insulator.thickness=90um:180um:2"])
    assert dict(both.sizes) == {"drive.high": 2, "stack.insulator.thickness": 2}
    assert list(json.loads(both.attrs["over"])) == ["drive.high", "stack.insulator.thickness"]
    name = "mean electrostatic_force"
    np.testing.assert_allclose(both[name].values[:, 0], ev.open_trace(swept)[name].values, rtol=1e-9)


def test_a_parameter_swept_again_goes_over_the_new_values(swept):
    again = ev.run(swept, over=["drive.high=100V:300V:3"])
    np.testing.assert_allclose(again["drive.high"], [100, 200, 300])


def test_new_values_of_a_repeated_sweep_are_not_set_either(swept):
    with pytest.raises(InputError, match=r"drive\.high: is set, but swept"):
        ev.run(swept, set={"drive.high": 1.0}, over=["drive.high=100V:300V:3"])


FILM = {"thickness": "50 um", "material": {"model": "Constant", "permittivity": 2}}


@pytest.mark.parametrize("order", [1, -1])
def test_a_table_and_what_is_set_in_it_both_count_in_any_order(order):
    changes = {"stack.insulator": FILM, "stack.insulator.initial_charge": 1e-6}
    changed = ev.load("vezzoli_2014/fig6").replace(dict(list(changes.items())[::order]))
    assert changed.stack.insulator.thickness == pytest.approx(50e-6, rel=1e-12)
    assert changed.stack.insulator.initial_charge == 1e-6
    assert "initial_charge" not in FILM


@pytest.mark.parametrize("order", [1, -1])
def test_what_is_set_by_itself_counts_before_the_same_in_a_table(order):
    changes = {"stack.insulator": FILM, "stack.insulator.material.permittivity": 3}
    changed = ev.load("vezzoli_2014/fig6").replace(dict(list(changes.items())[::order]))
    assert changed.stack.insulator.material.permittivity == 3
    assert changed.stack.insulator.thickness == pytest.approx(50e-6, rel=1e-12)
    assert FILM["material"]["permittivity"] == 2


@pytest.mark.parametrize("order", [1, -1])
def test_another_model_does_not_drop_a_table_in_silence(order):
    scenario = ev.load("vezzoli_2014/fig6")
    table = {"model": "Step", "level": 5}
    for changes in (
        {"drive": table, "drive.model": "Square"},
        {"stack.insulator": FILM, "stack.insulator.material.model": "ConstantPhase"},
    ):
        with pytest.raises(InputError, match=r"model: is set beside the table .*give one of the two"):
            scenario.replace(dict(list(changes.items())[::order]))
    assert scenario.replace({"drive": table, "drive.model": "Step"}).drive.level == 5
    part = {"stack.insulator": {"thickness": 5e-5}, "stack.insulator.material": FILM["material"]}
    assert scenario.replace(dict(list(part.items())[::order])).stack.insulator.material.permittivity == 2


@pytest.mark.parametrize("number", ["00", "²", "+0", "1" * 5000])
def test_an_entry_of_a_list_has_one_path(number):
    parts = [{"model": "Step", "level": level} for level in (1, 2)]
    scenario = ev.load("vezzoli_2014/fig6").replace({"drive": {"model": "Sum", "drives": parts}})
    assert scenario.replace({"drive.drives.0.level": 3}).drive.drives[0].level == 3
    with pytest.raises(InputError, match="has entries 0 to 1"):
        scenario.replace({f"drive.drives.{number}.level": 3})


@pytest.mark.parametrize(
    "use",
    [
        ev.perceive,
        lambda path: ev.perceive(path, set={"load.normal_force": 1.0}),
        ev.compare,
        lambda path: ev.load(path, changes={"load.normal_force": 1.0}),
    ],
)
def test_a_sweep_is_not_taken_for_the_scenario_it_began_from(swept, use):
    with pytest.raises(InputError, match="sweep"):
        use(swept)
    assert "[load]" in ev.init(swept)
