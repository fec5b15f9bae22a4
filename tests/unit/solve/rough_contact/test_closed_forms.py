"""Contacts whose solution is known: sphere, wave, full contact, adhesion in both limits, plates that fall shut."""

import numpy as np
import pytest

from electrovib.core.constants import eps0
from electrovib.physics.half_space import Elastic
from electrovib.solve.rough_contact import Loaded, Local, MaxwellStress

BODY = Elastic(modulus=1.5e6, poisson=0.5)
MODULUS = 2e6
"""E/(1 - nu^2) [Pa]."""


def test_a_sphere_touches_within_the_radius_of_hertz():
    points, period, radius = 512, 4e-4, 1e-2
    load = 4e-6
    x = (np.arange(points) - points / 2) * period / points
    square = x[:, None] ** 2 + x[None, :] ** 2
    rest = Loaded(
        heights=-square / (2 * radius),
        periods=(period, period),
        compliance=BODY.compliance,
        pressure=load / period**2,
    ).rest()
    expected = (3 * load * radius / (4 * MODULUS)) ** (1 / 3)
    # p^2 = p0^2 (1 - r^2/a^2): away from the edge, where the grid is felt
    core = square < (0.8 * expected) ** 2
    slope, top = np.polyfit(square[core], rest.pressure[core] ** 2, 1)
    assert np.sqrt(-top / slope) == pytest.approx(expected, rel=1e-3)
    assert np.sqrt(top) == pytest.approx(2 * MODULUS * expected / (np.pi * radius), rel=1e-3)
    assert np.sqrt(rest.contact_share * period**2 / np.pi) == pytest.approx(expected, rel=3e-3)


PERIOD, AMPLITUDE = 1e-4, 1e-6
FULL = np.pi * MODULUS * AMPLITUDE / PERIOD
"""Mean pressure at which the trough of a wave closes [Pa]."""


def wave(points, pressure, axis=0, **other):
    """Return a wave of the amplitude along one axis."""
    along = AMPLITUDE * np.cos(2 * np.pi * np.arange(points) / points)
    heights = np.outer(along, np.ones(2)) if axis == 0 else np.outer(np.ones(2), along)
    periods = (PERIOD, PERIOD / 50) if axis == 0 else (PERIOD / 50, PERIOD)
    return Loaded(heights=heights, periods=periods, compliance=BODY.compliance, pressure=pressure, **other)


@pytest.mark.parametrize("share", [0.05, 0.2, 0.5, 0.9])
@pytest.mark.parametrize("axis", [0, 1])
def test_a_wave_touches_over_the_share_of_westergaard(share, axis):
    pressure = FULL * np.sin(np.pi * share / 2) ** 2
    rest = wave(1024, pressure, axis).rest()
    assert rest.contact_share == pytest.approx(share, rel=1e-2)
    assert rest.pressure.mean() == pytest.approx(pressure, rel=1e-12)


def test_above_the_pressure_that_closes_the_troughs_the_whole_wave_is_pressed_together():
    rest = wave(64, 1.3 * FULL, tolerance=1e-10).rest()
    expected = FULL * (1.3 + np.cos(2 * np.pi * np.arange(64) / 64))
    assert rest.contact_share == 1
    assert rest.pressure[:, 0] == pytest.approx(expected, rel=1e-9)
    assert np.all(rest.gap == 0)


def exponential(work, reach):
    """Return an attraction that fades over a reach [m] and takes this work of adhesion [J/m2]."""

    def attraction(gap):
        stress = work / reach * np.exp(-gap / reach)
        return Local(-stress * reach, stress, -stress / reach)

    return attraction


def test_short_attraction_holds_a_wave_as_johnson_kendall_and_roberts_have_it():
    """p = p* sin^2 psi - sqrt(2 E* w tan psi/L): the singular stress at the edge does the work w; psi = pi share/2."""
    share, work = 0.3, 2e-4
    angle = np.pi * share / 2
    pressure = FULL * np.sin(angle) ** 2 - np.sqrt(2 * MODULUS * work * np.tan(angle) / PERIOD)
    assert 0 < pressure < 0.9 * FULL * np.sin(angle) ** 2
    loaded = wave(4096, pressure)
    rest = loaded.rest(exponential(work, 4e-9))
    assert rest.contact_share == pytest.approx(share, rel=1e-2)


def test_long_attraction_adds_to_the_load_as_derjaguin_muller_and_toporov_have_it():
    work, reach = 1e-2, 1e-4
    loaded = wave(1024, 0.1 * FULL)
    rest = loaded.rest(exponential(work, reach))
    total = 0.1 * FULL + work / reach
    assert rest.mean_attraction == pytest.approx(work / reach, rel=0.02)
    assert rest.contact_share == pytest.approx(2 / np.pi * np.arcsin(np.sqrt(total / FULL)), rel=1e-2)


STIFFNESS, APART, LAYER = 1e9, 5e-6, 1e-6


def pull(voltage):
    return MaxwellStress(voltage=voltage, electrical_thickness=LAYER)


def punch(spring=STIFFNESS, heights=None, period=1e-3):
    """Return a flat punch on a spring, its gap `APART` without a voltage."""
    return Loaded(
        heights=np.zeros((8, 8)) if heights is None else heights,
        periods=(period, period),
        compliance=BODY.compliance,
        pressure=-spring * APART,
        spring=spring,
    )


def fall(loaded, pull, voltages, start=None):
    """Return the voltage beyond which a contact falls, to 1e-4 of it, and the rests before and after; None without a fall."""
    begin, before = voltages[0], loaded.rest(pull(voltages[0]), start=start)
    for voltage in voltages[1:]:
        end = voltage
        after = loaded.rest(pull(end), start=before.gap)
        while after.fell and abs(end - begin) > 1e-4 * max(begin, end):
            middle = (begin + end) / 2
            found = loaded.rest(pull(middle), start=before.gap)
            end, begin, before = (middle, begin, before) if found.fell else (end, middle, found)
        after = loaded.rest(pull(end), start=before.gap)
        if after.fell:
            return begin, before, after
        begin, before = end, after
    return None


@pytest.mark.parametrize("steps", [4, 5])
def test_a_flat_punch_on_a_spring_falls_shut_at_two_thirds_of_its_reach(steps):
    """One step of Newton's goes across all that is not stable where the voltage rises by a quarter of its range."""
    expected = np.sqrt(8 * STIFFNESS * (LAYER + APART) ** 3 / (27 * eps0))
    voltage, before, after = fall(punch(), pull, np.linspace(0, 1.7 * expected, steps))
    assert voltage == pytest.approx(expected, rel=1e-3)
    assert before.mean_gap + LAYER == pytest.approx(2 / 3 * (LAYER + APART), rel=1e-2)
    assert after.contact_share == 1
    assert after.pressure.mean() == pytest.approx(
        pull(voltage)(np.zeros(1)).stress[0] - STIFFNESS * APART, rel=2e-3
    )


def test_it_lets_go_at_a_lower_voltage_than_it_fell_shut():
    expected = np.sqrt(2 * STIFFNESS * APART * LAYER**2 / eps0)
    shut = np.zeros((8, 8))
    voltage, before, after = fall(punch(), pull, np.linspace(100.0, 0, 8), start=shut)
    assert voltage == pytest.approx(expected, rel=1e-3)
    assert (before.contact_share, after.contact_share) == (1, 0)


def test_below_the_thickness_of_the_layer_it_closes_without_a_fall():
    """No pull-in where the gap is at most half the electrical thickness."""

    def thick(voltage):
        return MaxwellStress(voltage=voltage, electrical_thickness=2.1 * APART)

    assert fall(punch(), thick, np.linspace(0, 400.0, 12)) is None


def test_an_even_gap_breaks_up_where_a_wave_of_the_period_is_no_longer_stiff_enough():
    """E* q/2 = eps0 V^2/(g + h0)^3 for a gap whose mean is held."""
    period = 1e-4
    expected = np.sqrt(MODULUS * np.pi / period * (LAYER + APART) ** 3 / eps0)
    seed = 1e-8 * APART * np.outer(np.cos(2 * np.pi * np.arange(16) / 16), np.ones(16))
    voltage, _, _ = fall(punch(1e14, seed, period), pull, np.linspace(0, 1.7 * expected, 4))
    assert voltage == pytest.approx(expected, rel=1e-3)
