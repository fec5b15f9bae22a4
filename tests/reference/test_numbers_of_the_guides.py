"""Numbers that a user reads along the guides, against equations that are written and solved here."""

import re
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import simpson
from scipy.interpolate import CubicSpline
from scipy.optimize import least_squares
from scipy.signal import lsim

import electrovib as ev
from electrovib.apps.cli.run import summary
from electrovib.core.constants import eps0
from electrovib.view.notebook.shown import trace_text
from electrovib.view.pages import html
from electrovib.view.report import document_of
from electrovib.view.summary import key_numbers

DOCS = Path(__file__).parents[2] / "docs"
AREA, LOAD, COEFFICIENT, RESISTANCE = 1e-4, 0.5, 0.5, 1e3
SKIN, PERMITTIVITY, CONDUCTIVITY = 200e-6, 1560.0, 1.7938354529828572e-06
FILM, FILM_PERMITTIVITY = 90e-6, 3.35
PRINTED = 6e-4
"""Rounding of four digits, and of the fine grids below."""


def block(page, kind, *, after=""):
    """Return the first block of a kind on a page of the documentation, after some words."""
    text = (DOCS / page).read_text(encoding="utf-8")
    return re.search(rf"```{kind}\n(.*?)```", text[text.index(after) :], re.DOTALL)[1]


def quantity(text):
    """Return the last number with a unit of force in a text [N]."""
    number, unit = re.findall(r"([\d.]+) (mN|µN|uN|N)\b", text)[-1]
    return float(number) * {"N": 1, "mN": 1e-3, "µN": 1e-6, "uN": 1e-6}[unit]


def attraction_of_fig6(time, voltage, *, film=FILM):
    """Law of Vezzoli et al. 2014 on film and skin behind a resistor, by exact steps of straight pieces [N]."""
    of_film, of_skin = film / (eps0 * FILM_PERMITTIVITY), eps0 * PERMITTIVITY
    charge = np.array([-of_film, -SKIN]) / (RESISTANCE * AREA)
    field = (charge - [0, CONDUCTIVITY]) / of_skin
    driven = np.array([[1.0], [1 / of_skin]]) / (RESISTANCE * AREA)
    system = np.array([charge, field]), driven, [[0.0, SKIN + of_skin * of_film]], [[0.0]]
    effective = lsim(system, voltage, time)[1]
    return eps0 * AREA / 2 * effective**2 / ((film / FILM_PERMITTIVITY + SKIN / PERMITTIVITY) * (film + SKIN))


def pulse(time, high=1000.0):
    return np.interp(time, [0, 0.036, 0.136, 0.172], [0, high, high, 0])


@pytest.fixture(scope="module")
def driven(tmp_path_factory):
    """The run of the page on waveforms of one's own, with the table that the page prints."""
    file = tmp_path_factory.mktemp("waveform") / "drive.csv"
    file.write_text(block("how_to/my_waveform.md", "csv"), encoding="utf-8")
    return ev.run("vezzoli_2014/fig6", set={"drive": {"model": "Sampled", "file": str(file)}})


@pytest.fixture(scope="module")
def expected():
    """Times of the same [s], and the attraction [N]."""
    time = np.linspace(0, 80e-3, 80_001)
    return time, attraction_of_fig6(time, np.interp(time, [0, 5e-3, 40e-3, 45e-3], [0, 300, 300, 0]))


def test_a_measured_drive_of_five_rows_draws_the_response_and_not_a_line_between_its_rows(driven, expected):
    line = np.interp(expected[0], driven.time, driven.electrostatic_force)
    assert np.max(np.abs(line - expected[1])) < 1e-3 * expected[1].max()
    assert "sampling" not in driven.attrs["validity"]


@pytest.mark.slow
def test_run_report_and_notebook_state_quantities_and_not_those_of_the_output_times(driven, expected):
    time, force = expected
    mean, peak = simpson(force, time) / time[-1], force.max()
    few = ev.simulate(ev.load(driven), time=np.array([0, 5, 40, 45, 80]) * 1e-3)
    told = {"electrostatic force": peak, "lateral force": COEFFICIENT * (LOAD + peak)}
    for trace in (driven, few):
        numbers = key_numbers(trace)
        assert quantity(numbers["mean electrostatic force"]) == pytest.approx(mean, rel=PRINTED)
        assert quantity(numbers["largest electrostatic force"]) == pytest.approx(peak, rel=PRINTED)
        for name, expected_ in told.items():
            line = next(line for line in summary(trace, None, None) if line.startswith(name))
            assert quantity(line) == pytest.approx(expected_, rel=PRINTED)
        page = html(document_of({"driven": trace}))
        assert numbers["mean electrostatic force"] in page
        assert f"Largest electrostatic force: {numbers['largest electrostatic force']}" in page
        assert f"mean electrostatic force: {numbers['mean electrostatic force']}" in trace_text(trace)


def test_a_part_of_a_run_states_that_its_numbers_are_those_of_its_times(driven):
    numbers = key_numbers(driven.isel(time=slice(0, 100)))
    assert numbers["largest electrostatic force"].endswith("at the output times")
    assert "mean electrostatic force" not in numbers


def test_a_square_wave_with_edges_between_the_times_has_its_peak():
    """The response to an edge of a square wave is over before the next of 2001 times: 12 % of the peak was missed."""
    trace = ev.simulate("vardar_2017/square")
    fine = ev.simulate("vardar_2017/square", time=np.linspace(0, 0.1, 200_001)[:20_001])
    largest = float(fine.electrostatic_force.max())
    assert float(trace.electrostatic_force.max()) < 0.95 * largest
    assert quantity(key_numbers(trace)["largest electrostatic force"]) == pytest.approx(largest, rel=PRINTED)


def permittivity_of_skin(s):
    """Wet skin of Gabriel et al. 1996, as printed, with s in the place of j w; conduction apart."""
    terms = ((39, 7.958e-12, 0.1), (280, 7.9577e-8, 0), (30e3, 1.592e-6, 0.16), (30e3, 1.592e-3, 0.2))
    return 4 + sum(strength / (1 + (s * time) ** (1 - broadening)) for strength, time, broadening in terms)


def gap_field(s, insulator=1e-6):
    """Field in the gap of the screen of the guide per volt of the drive [1/m]."""
    silica, skin = s * eps0 * 3.9 + 1e-14, s * eps0 * permittivity_of_skin(s) + 4e-4
    return 1 / (s * eps0 * (insulator / silica + 3e-6 / (s * eps0) + SKIN / skin + RESISTANCE * AREA))


def screen_force(time, *, amplitude=100.0, frequency=120.0, insulator=1e-6, nodes=16):
    """Attraction from rest [N]: the sine in its steady state, and what decays, on Talbot's contour."""
    pulsation = 2 * np.pi * frequency
    steady = gap_field(1j * pulsation, insulator)
    angle = np.arange(1, nodes) * np.pi / nodes
    moments = np.geomspace(1e-9, time[-1], 300)
    s = 2 * nodes / 5 / moments[:, None] * np.append(1, angle * (1 / np.tan(angle) + 1j))
    bend = angle + (angle / np.tan(angle) - 1) / np.tan(angle)
    weights = np.exp(s * moments[:, None]) * np.append(0.5, 1 + 1j * bend)
    sine = (gap_field(s, insulator) * pulsation - (steady.imag * s + steady.real * pulsation)) / (
        s**2 + pulsation**2
    )
    decays = np.sum((weights * sine).real, axis=1) * 2 / (5 * moments)
    rest = np.where(time > moments[0], CubicSpline(moments, decays)(np.maximum(time, moments[0])), decays[0])
    field = amplitude * ((steady * np.exp(1j * pulsation * time)).imag + rest)
    return eps0 * AREA / 2 * field**2


def test_the_screen_of_the_guide_and_its_sweep_over_the_thickness(tmp_path):
    file = tmp_path / "screen.toml"
    file.write_text(block("how_to/my_screen.md", "toml", after="screen.toml"), encoding="utf-8")
    trace = ev.run(file)
    time = np.linspace(0, float(trace.time[-1]), 60_001)
    force = screen_force(time)
    numbers = key_numbers(trace)
    assert quantity(numbers["largest electrostatic force"]) == pytest.approx(force.max(), rel=PRINTED)
    mean = simpson(force, time) / time[-1]
    assert quantity(numbers["mean electrostatic force"]) == pytest.approx(mean, rel=PRINTED)
    name, path = "mean electrostatic_force", "stack.insulator.thickness"
    swept = ev.run(file, over=[f"{path}=0.3um:30um:3log"], quantity=[name])
    for case, insulator in enumerate([0.3e-6, 3e-6, 30e-6]):
        mean = simpson(screen_force(time, insulator=insulator), time) / time[-1]
        assert float(swept[name][case]) == pytest.approx(mean, rel=1e-4)


def test_the_forces_that_the_tutorial_prints():
    text = (DOCS / "tutorial.md").read_text(encoding="utf-8")
    time = np.linspace(0, 0.172, 17_201)
    peak = attraction_of_fig6(time, pulse(time)).max()
    about = float(re.search(r"maximum of about ([\d.]+) mN", text)[1]) * 1e-3
    assert about == pytest.approx(peak, rel=0.03)
    quarter = float(re.search(r"a quarter of the attraction, ([\d.]+) mN", text)[1]) * 1e-3
    assert quarter == pytest.approx(peak / 4, abs=5e-6)
    for high, wanted in ((1000, peak), (500, peak / 4)):
        numbers = key_numbers(ev.run("vezzoli_2014/fig6", set={"drive.high": high}))
        assert quantity(numbers["largest electrostatic force"]) == pytest.approx(wanted, rel=PRINTED)


def test_the_fit_that_the_tutorial_prints():
    """The recording of its script with this noise, and the film by least squares, from the equations here."""
    time = np.arange(0, 0.3, 0.5e-3)
    noise = 0.05 * np.random.default_rng(1).standard_normal(time.size)
    recorded = np.round(1e3 * attraction_of_fig6(time, pulse(time), film=75e-6) + noise, 4)

    def missed(film):
        return 1e3 * attraction_of_fig6(time, pulse(time), film=film[0] * 1e-6) - recorded

    found = least_squares(missed, [90.0], x_scale=10.0)
    error = np.sqrt(2 * found.cost / (time.size - 1) / float(np.sum(found.jac**2)))
    printed = block("tutorial.md", "text", after="<!-- output of the fit -->")
    value, low, high = (float(each) for each in re.findall(r"([\d.]+) um", printed))
    assert value == pytest.approx(found.x[0], abs=2e-3)
    assert (high - low) / 2 == pytest.approx(1.965 * error, rel=0.02)
