"""Quantities over what was swept."""

import numpy as np
import pytest

from electrovib.core.errors import InputError
from electrovib.studies.sweep import sweep
from electrovib.view import plots

FORCE = "peak electrostatic_force"


@pytest.fixture(scope="module")
def over_two(scenario):
    over = {"drive.high": [100.0, 200.0, 300.0, 400.0], "stack.gap.thickness": np.geomspace(1e-7, 1e-4, 6)}
    return sweep(scenario, over)


def texts(ax):
    return [text.get_text() for text in ax.texts]


def test_a_curve_over_one_parameter(swept, over_two):
    """A logarithmic axis where the values have decades between them."""
    ax = plots.quantity(swept, FORCE)
    (line,) = ax.lines
    np.testing.assert_array_equal(line.get_ydata(), swept[FORCE].values)
    assert (ax.get_xscale(), ax.get_yscale()) == ("log", "linear")
    assert (ax.get_xlabel(), ax.get_ylabel()) == (
        "thickness of the gap [µm]",
        "peak electrostatic force [mN]",
    )
    wide = swept.copy(deep=True)
    wide[FORCE][0] = 100 * float(swept[FORCE].max())
    assert plots.quantity(wide, FORCE).get_yscale() == "log"
    ax = plots.quantity(over_two.isel({"stack.gap.thickness": 2}), "swing lateral_force")
    assert (ax.get_xscale(), ax.get_yscale(), ax.get_xlabel()) == ("linear", "linear", "drive voltage [V]")
    wide[FORCE][:] = np.nan
    assert texts(plots.quantity(wide, FORCE)) == ["no numbers to draw"]


def test_a_map_over_two_parameters_has_labelled_lines(over_two):
    ax = plots.quantity(over_two, FORCE)
    assert (ax.get_xscale(), ax.get_yscale()) == ("log", "linear")
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("thickness of the gap [µm]", "drive voltage [V]")
    shown = texts(ax)
    assert len(shown) >= 3
    assert all(text.endswith("N") for text in shown)
    assert ax.get_title(loc="left") == "peak electrostatic force"
    ax.figure.canvas.draw()
    holed = over_two.copy(deep=True)
    holed[FORCE][0, 0] = np.nan
    assert plots.quantity(holed, FORCE).get_title(loc="left").endswith("white: unknown")
    for value, words in ((2e-3, "2 mN everywhere"), (np.nan, "no numbers to draw")):
        holed[FORCE][:] = value
        ax = plots.quantity(holed, FORCE)
        assert texts(ax) == [words]
        ax.figure.canvas.draw()


def test_what_cannot_be_drawn_is_refused(over_two, swept, trace, scenario):
    with pytest.raises(InputError, match="Did you mean 'peak electrostatic_force'"):
        plots.quantity(over_two, "peak electrostatic force")
    with pytest.raises(InputError, match="does not contain it"):
        plots.quantity(trace, FORCE)
    with pytest.raises(InputError, match="depends on nothing"):
        plots.quantity(swept.isel({"stack.gap.thickness": 0}), FORCE)
    over = {"drive.high": [1.0, 2.0], "drive.rise": [1e-3, 2e-3], "drive.fall": [1e-3, 2e-3]}
    with pytest.raises(InputError, match="Choose values of the others with isel"):
        plots.quantity(sweep(scenario, over), FORCE)
