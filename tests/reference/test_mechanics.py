"""Mechanics by the recursion of the electrics: closed forms, and scipy's own integrator as a second route."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from electrovib.physics.drive.edges import Trapezium
from electrovib.physics.rig import LateralSensor, PiezoSensor, SensorCreep, Tribometer
from electrovib.solve.mechanics.filters import high_pass, of_stages, through_pieces
from electrovib.solve.mechanics.response import respond_mechanically
from electrovib.solve.mechanics.rig import measured

FOUNDING_TIME = 7.7e-3
"""Time constant of Vezzoli et al. 2014 [s]: v_e is the drive through a high-pass."""
STATIC = 56.55e-3 / 1000.0**2
"""Static force of the film of Vezzoli et al. 2014 [N/V2]."""


def effective_force(times):
    """The chain of Vezzoli et al. 2014 in closed form: pulse of 1 kV, 36 ms ramps, 100 ms hold; v_e by hand; f = c v_e^2."""
    corners, slopes = np.array([0.0, 0.036, 0.136, 0.172]), np.array([1, -1, -1, 1]) * 1000.0 / 0.036
    voltage = np.zeros(np.shape(times))
    for corner, slope in zip(corners, slopes, strict=True):  # a ramp through the high-pass
        since = np.maximum(times - corner, 0.0)
        voltage += slope * FOUNDING_TIME * -np.expm1(-since / FOUNDING_TIME)
    return STATIC * voltage**2


CORNERS = [0.036, 0.136, 0.172]


def test_the_closed_form_is_the_founding_drive():
    """The same v_e from the package's own trapezoidal pulse and its exact filter."""
    times = np.linspace(0.0, 0.2, 401)
    (part,) = Trapezium(low=0.0, high=1000.0, rise=0.036, hold=0.1, fall=0.036).parts()
    skin = high_pass(FOUNDING_TIME)
    voltage = through_pieces(skin, part, times, skin.state(0.0))
    assert STATIC * voltage**2 == pytest.approx(effective_force(times), abs=1e-12)
    assert 2e-3 < effective_force(times).max() < 3e-3  # the 2.5 mN of figure 6


def integrated(stages, force, times, corners):
    """Reading by scipy's adaptive integrator on equations written without poles, restarted at every corner."""
    mass, lag, creep = stages
    angular = 2 * np.pi * mass.natural_frequency

    def rates(time, state):
        place, speed, shown, crept = state
        pushed = angular**2 * (force(np.array([time]))[0] - place) - 2 * mass.damping_ratio * angular * speed
        follow = 2 * np.pi * lag.cut_off * (place - shown)
        return [speed, pushed, follow, (shown - crept) / creep.times[0]]

    state, found = np.zeros(4), []
    edges = [times[0], *corners, times[-1]]
    for begin, end in pairwise(edges):
        inside = times[(times >= begin) & (times < end)] if end < times[-1] else times[times >= begin]
        asked = np.unique(np.append(inside, end))
        result = solve_ivp(rates, (begin, end), state, "DOP853", asked, rtol=1e-11, atol=1e-16)
        state = result.y[:, -1]
        found.append((result.y[2] + creep.shares[0] * result.y[3])[np.isin(asked, inside)])
    return np.concatenate(found)


def test_lateral_sensor_under_the_founding_force_against_an_adaptive_integrator():
    creep = SensorCreep(share=-0.05, time=0.05)
    sensor = LateralSensor(natural_frequency=500.0, damping_ratio=0.05, bandwidth=2e3, creep=creep)
    times = np.unique(np.concatenate([np.linspace(0.0, 0.2, 200), CORNERS]))
    expected = integrated(sensor.stages(), effective_force, times, CORNERS)
    filters = {"reading": of_stages(sensor.stages())}
    given = {"corners": CORNERS, "held": 0.0, "tolerance": 1e-8}
    outputs, error = respond_mechanically(effective_force, filters, times, **given)
    scale = np.abs(expected).max()
    assert error <= 1e-8
    assert np.abs(outputs["reading"] - expected).max() < 3e-8 * scale  # the integrator's own 1e-11 a step
    assert np.abs(effective_force(times) - expected).max() > 1e-2 * scale  # the sensor is not transparent


def test_relaxation_of_the_sensor_makes_falling_edges_smaller():
    """What the paper suspects: the first pulse leaves creep behind, and the second is read on a lower base.

    It is a small effect: even a sensor that yields by 30 % in 0.1 s takes only some per cent off.
    """
    times = np.linspace(0.0, 0.2, 2001)
    quick = {"natural_frequency": 5e3, "damping_ratio": 0.7}
    normal = PiezoSensor(natural_frequency=5e3, damping_ratio=0.7, time_constant=1e3)

    def friction(time):
        return 0.4 * (0.5 + effective_force(time))

    def peaks(creep):
        rig = Tribometer(normal=normal, lateral=LateralSensor(**quick, creep=creep))
        shown = measured(rig, times, friction, friction, corners=CORNERS).signals["lateral_force_measured"]
        return shown[times < 0.13].max() - shown[0], shown[times > 0.13].max() - shown[0]

    rising, falling = peaks(None)
    assert falling == pytest.approx(rising, rel=1e-3)  # the law of Vezzoli et al. 2014 itself: equal edges
    rising, falling = peaks(SensorCreep(share=-0.3, time=0.1))
    assert 0.95 * rising < falling < 0.99 * rising
