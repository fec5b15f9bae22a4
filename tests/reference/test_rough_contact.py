"""Rough contact with attraction against the least energy with the dense matrix of Green's function, without transforms."""

import functools

import numpy as np
import pytest
from scipy.optimize import minimize

import electrovib as ev
from electrovib.core.constants import eps0
from electrovib.physics.half_space import Coated, Elastic
from electrovib.physics.topography import SelfAffine
from electrovib.recordings.fit import contact
from electrovib.solve.rough_contact import Loaded, MaxwellStress, follow

PERIOD, LAYER, LOAD = 2e-4, 8e-7, 5e3
SKIN = Coated(
    film=Elastic(modulus=4e6, poisson=0.45), thickness=2e-5, below=Elastic(modulus=3e5, poisson=0.5)
)


def stiffness(points):
    """Pressure of unit displacements, (n^2, n^2), summed wave by wave."""
    place = np.arange(points)
    wave = np.where(place > points // 2, place - points, place)
    q = 2 * np.pi / PERIOD * np.hypot(wave[:, None], wave[None, :])
    stiff = 1 / SKIN.compliance(np.where(q == 0, 1.0, q))
    stiff[0, 0] = 0.0
    cosines, sines = (f(2 * np.pi * np.outer(place, place) / points) for f in (np.cos, np.sin))
    green = (cosines @ stiff @ cosines - sines @ stiff @ sines) / points**2
    shift = (place[:, None] - place[None, :]) % points
    return green[shift[:, None, :, None], shift[None, :, None, :]].reshape(points**2, points**2)


def least_energy(heights, matrix, voltages, accuracy, load=LOAD):
    """Gaps that make the energy least at the last voltage, from those of the former one, by L-BFGS-B; a column each surface."""
    unit = heights.std()
    gap, weight = heights.max(0) - heights, 1 / (matrix[0, 0] * unit)

    def energy(scaled, voltage):
        gap = scaled.reshape(heights.shape) * unit
        elastic, reach = matrix @ (gap + heights), gap + LAYER
        half = eps0 * voltage**2 / 2
        value = np.vdot(gap + heights, elastic) / 2 + load * gap.sum() - np.sum(half / reach)
        return value * weight / unit, ((elastic + load + half / reach**2) * weight).ravel()

    for voltage in voltages:
        found = minimize(
            energy,
            gap.ravel() / unit,
            (voltage,),
            "L-BFGS-B",
            jac=True,
            bounds=[(0, None)] * heights.size,
            options={"maxiter": 20000, "maxfun": 40000, "ftol": 1e-15, "gtol": accuracy, "maxcor": 5},
        )
        gap = found.x.reshape(heights.shape) * unit
    return gap


def compare(points, shortest, accuracy, voltage=100.0):
    """Twenty surfaces whose attraction is several times the load."""
    spectrum = SelfAffine(rms=1e-6, hurst=0.8, longest=2e-4, roll_off=1e-4, shortest=shortest)
    drawn = [spectrum.heights((points, points), (PERIOD, PERIOD), seed=seed) for seed in range(20)]
    columns = np.stack([each.ravel() for each in drawn], axis=1)
    gaps = least_energy(columns, stiffness(points), (voltage / 2, voltage), accuracy)
    attractions = np.mean(eps0 * voltage**2 / (2 * (gaps + LAYER) ** 2), axis=0)
    assert attractions.min() > 0.3 * LOAD
    for heights, gap, attraction in zip(drawn, gaps.T, attractions, strict=True):
        loaded = Loaded(heights=heights, periods=(PERIOD, PERIOD), compliance=SKIN.compliance, pressure=LOAD)
        rest = follow(
            loaded,
            lambda v: MaxwellStress(voltage=v, electrical_thickness=LAYER),
            voltage * np.linspace(0, 1, 5),
        )[-1]
        assert rest.mean_attraction == pytest.approx(attraction, rel=1e-2)
        assert rest.contact_share == pytest.approx(np.mean(gap <= 0), abs=1.01 / points**2)
        assert rest.gap.ravel() == pytest.approx(gap, abs=1e-2 * heights.std())


def test_attraction_of_twenty_surfaces_is_that_of_the_least_energy():
    compare(16, 5e-5, 1e-7)


@pytest.mark.slow
def test_on_a_grid_of_64_by_64_too():
    compare(64, 2e-5, 2e-5)


def test_capacitances_of_the_least_energy_give_back_scale_and_modulus_of_a_map(monkeypatch):
    """Of a coated skin under a map of heights; of 30 with 2 % of noise most have both numbers in their intervals."""
    monkeypatch.setattr(contact, "solved", functools.cache(contact.solved))
    pad, loads = ev.load("bau_2010/sine"), np.geomspace(0.05, 5.0, 8)
    spectrum = SelfAffine(rms=1e-6, hurst=0.8, longest=1e-4, roll_off=1e-4, shortest=2.5e-5)
    values = spectrum.heights((16, 16), (PERIOD / 2, PERIOD / 2), seed=3)
    measured = ev.MeasuredHeights(values=values, spacing=PERIOD / 32)
    heights = measured.heights(measured.shape(), measured.periods, seed=0).reshape(-1, 1)
    matrix, capacitance = stiffness(32), []
    for load in loads:
        gap = least_energy(heights, matrix, (0.0,), 1e-9, load=load / pad.contact_area)
        film = pad.stack.layers["insulator"]
        reach = gap + film.thickness / film.material.permittivity
        capacitance.append(eps0 * pad.contact_area * np.mean(1 / reach))
    begin = {
        "roughness": ev.MeasuredHeights(values=3 * values, spacing=measured.spacing),
        "body": SKIN.replace({"film.modulus": 1e6, "below.modulus": 7.5e4}),
    }

    def fitted(noise):
        seen = capacitance * np.exp(noise)
        return ev.fit_contact(pad, load=loads, capacitance=seen, free=["modulus", "rms"], **begin)

    exact = fitted(np.zeros(8))
    assert exact.rms.value == pytest.approx(measured.rms, rel=0.02)
    assert exact.modulus.value == pytest.approx(SKIN.film.modulus, rel=0.02)
    assert exact.body.below.modulus / SKIN.below.modulus == pytest.approx(exact.modulus.value / 4e6)
    assert exact.roughness.rms == pytest.approx(exact.rms.value)
    rng = np.random.default_rng(7)
    many = [fitted(0.02 * rng.normal(size=8)) for _ in range(30)]
    for name, true in (("rms", measured.rms), ("modulus", SKIN.film.modulus)):
        numbers = [getattr(each, name) for each in many]
        assert sum(each.lower <= true <= each.upper for each in numbers) >= 26
        spread = np.std([each.value for each in numbers])
        assert np.mean([each.standard_error for each in numbers]) == pytest.approx(spread, rel=0.4)
