"""A table of the attraction over the voltage, from a rough contact that was solved to the force of a run."""

import numpy as np
import pytest

import electrovib as ev
from electrovib.core.errors import InputError
from electrovib.physics.force import TabulatedAttraction

SINE = "bau_2010/sine"
ROUGH = ev.SelfAffine(rms=2e-6, hurst=0.8, longest=1e-3, roll_off=2.5e-4, shortest=1.25e-4)


def table(voltage=(0.0, 10.0, 20.0), attraction=(0.0, 200.0, 1000.0)):
    return TabulatedAttraction(voltage_samples=list(voltage), attraction_samples=list(attraction))


def test_the_attraction_over_the_squared_voltage_is_linear_in_that_square():
    """2 Pa/V^2 at 10 V, 2.5 at 20 V, between them linear in the square; below the first row that of the first."""
    volts = np.array([0.0, 3.0, -10.0, np.sqrt(250.0), 20.0, np.nan])
    expected = [0.0, 18.0, 200.0, 250 * 2.25, 1000.0, np.nan]
    np.testing.assert_allclose(table().pressure(V=volts), expected, rtol=1e-12)
    assert table([10.0, 20.0], [200.0, 1000.0]).pressure(V=3.0) == pytest.approx(18.0)


@pytest.mark.parametrize("largest", [20.1, -20.1])
def test_beyond_its_last_voltage_nothing_is_known(largest):
    with pytest.raises(
        InputError, match=r"the table ends at 20 V, but .* have 20.1 V; give a table up to there"
    ):
        table().pressure(V=np.array([1.0, largest]))
    with pytest.raises(InputError, match="the table ends at 20 V"):
        ev.run(SINE, set={"force": table(), "drive.amplitude": 25.0})


@pytest.mark.parametrize(
    ("voltage", "attraction", "said"),
    [
        ([], [], "there is no table; give a file"),
        ([0.0], [0.0], "no voltage besides 0"),
        ([1.0, 2.0], [1.0], "2 voltages and 1 attractions"),
        ([0.0, 2.0, 1.0], [0.0, 2.0, 1.0], "must rise"),
        ([1.0, 1.0], [1.0, 1.0], "must rise"),
        ([-1.0, 1.0], [1.0, 1.0], "must rise"),
        ([1.0, np.nan], [1.0, 1.0], "must rise"),
        ([1.0, 2.0], [1.0, 0.0], "above 0"),
        ([1.0, 2.0], [1.0, np.inf], "above 0"),
        ([0.0, 2.0], [-1.0, 1.0], "above 0"),
    ],
)
def test_what_is_no_table_is_refused(voltage, attraction, said):
    force = {"model": "TabulatedAttraction", "voltage_samples": voltage, "attraction_samples": attraction}
    with pytest.raises(InputError, match=said):
        ev.load(SINE, changes={"force": force})


def test_a_solved_contact_gives_the_force_of_a_run(tmp_path):
    """Under a constant voltage it is that of the contact; a sine has at each time that of the voltage across film and gap."""
    volts = [0.0, 10.0, 20.0, 30.0]
    solved = ev.rough_contact(SINE, roughness=ROUGH, body=ev.Elastic(modulus=1e7), voltage=volts, points=64)
    (path,) = ev.save(solved, tmp_path / "rough_contact.csv")
    force = {"model": "TabulatedAttraction", "file": str(path)}
    held = ev.run(SINE, set={"force": force, "drive": {"model": "Step", "level": 20.0}})
    assert held.electrostatic_force.values[-1] == pytest.approx(solved.force[2], rel=1e-3)
    run = ev.run(SINE, set={"force": force, "drive.amplitude": 25.0})
    layers = ev.load(SINE).stack.layers
    across = sum(layers[name].thickness * run.field.sel(layer=name).values for name in ("insulator", "gap"))
    law = TabulatedAttraction(voltage_samples=volts, attraction_samples=solved.attraction)
    expected = ev.load(SINE).contact_area * law.pressure(V=across)
    np.testing.assert_allclose(run.electrostatic_force, expected, rtol=1e-6, atol=1e-9)
    assert "table of the attraction" in run.attrs["validity"]


def test_columns_have_names_and_units_of_their_own(tmp_path):
    (tmp_path / "t.csv").write_text("U,p\n0.01,0.2\n0.02,1.0\n")
    force = {
        "model": "TabulatedAttraction",
        "file": str(tmp_path / "t.csv"),
        "voltage_unit": "kV",
        "attraction_unit": "kPa",
    }
    force |= {"voltage_column": "U", "attraction_column": 1}
    law = ev.load(SINE, changes={"force": force}).force
    assert law.pressure(V=20.0) == pytest.approx(1000.0)
    with pytest.raises(InputError, match="voltage_unit"):
        ev.load(SINE, changes={"force": force | {"voltage_unit": "Pa"}})
