"""Any rough contact at rest obeys the conditions of contact, and what it says of itself is so."""

import itertools
from itertools import pairwise

import numpy as np
import pytest

from electrovib.core.constants import eps0
from electrovib.core.errors import ElectrovibError, InputError
from electrovib.physics.half_space import Coated, Elastic
from electrovib.physics.topography import SelfAffine
from electrovib.solve.rough_contact import Loaded, Local, MaxwellStress, attracted, follow

SKIN = Coated(
    film=Elastic(modulus=5e6, poisson=0.45), thickness=2e-5, below=Elastic(modulus=2e5, poisson=0.5)
)
SPECTRUM = SelfAffine(rms=2e-6, hurst=0.8, longest=2e-4, roll_off=1e-4, shortest=2e-5)
PERIODS = (2e-4, 3e-4)


def rough(shape=(64, 96), pressure=2e4, seed=0, **other):
    heights = SPECTRUM.heights(shape, PERIODS, seed=seed)
    return Loaded(heights=heights, periods=PERIODS, compliance=SKIN.compliance, pressure=pressure, **other)


def pull(voltage):
    return MaxwellStress(voltage=voltage, electrical_thickness=1e-6)


def bent(pressure, periods):
    """Displacement under a pressure, by transforms of complex numbers."""
    q = [2 * np.pi * np.fft.fftfreq(n, period / n) for n, period in zip(pressure.shape, periods, strict=True)]
    wave = np.hypot(q[0][:, None], q[1][None, :])
    wave[0, 0] = 1
    waves = np.fft.fft2(pressure) * SKIN.compliance(wave)
    waves[0, 0] = 0
    return np.fft.ifft2(waves).real


VOLTAGES, SHAPES, PRESSURES = (None, 100.0, 200.0), ((64, 96), (36, 54), (128, 64)), (200.0, 2e4, 2e6)
LOADED = [
    pytest.param(VOLTAGES[i], SHAPES[j], PRESSURES[k], marks=pytest.mark.slow if (i + j + k) % 3 else ())
    for i, j, k in itertools.product(range(3), repeat=3)
]
"""Always nine, in which every two of the values meet."""


@pytest.mark.parametrize(("voltage", "shape", "pressure"), LOADED)
def test_places_touch_or_are_open_and_the_displacement_is_that_of_the_stress(voltage, shape, pressure):
    loaded = rough(shape, pressure)
    rest = loaded.rest() if voltage is None else loaded.rest(pull(voltage))
    assert rest.gap.min() >= 0
    assert rest.pressure.min() >= -1e-6 * pressure
    assert np.all(rest.gap * rest.pressure == 0)
    assert 0 < rest.contact_share <= 1
    assert rest.contact_share == np.mean(rest.gap == 0)
    net = rest.pressure - rest.attraction
    assert net.mean() == pytest.approx(pressure, rel=1e-5)
    expected = 0 if voltage is None else pull(voltage)(rest.gap).stress
    assert rest.attraction == pytest.approx(expected, rel=1e-12)
    wanted = bent(net, PERIODS) - loaded.heights
    offset = rest.gap - wanted
    assert np.ptp(offset) < 1e-5 * loaded.heights.std()
    assert rest.residual <= loaded.tolerance


@pytest.mark.parametrize("share", [0.0, 0.6])
def test_spots_with_a_share_of_the_field_are_the_limit_of_a_stress_that_falls_near_contact(share):
    """(1 - (1 - share^2) exp(-g/reach)) times the Maxwell stress is solved as it is, over a reach far below the gaps."""
    whole, reach = pull(200.0), 2e-10

    def falling(gap):
        local, rest = whole(gap), (1 - share**2) * np.exp(-gap / reach)
        slope = local.slope * (1 - rest) + local.stress * rest / reach
        return Local(local.energy + local.stress * rest * reach, local.stress * (1 - rest), slope)

    insulating = rough().rest(whole)
    found, expected = insulating.with_field_share(share), rough().rest(falling, start=insulating.gap)
    assert found.mean_attraction == pytest.approx(expected.mean_attraction, rel=3e-3)
    assert found.mean_attraction < 0.9 * insulating.mean_attraction
    assert found.contact_share == pytest.approx(expected.contact_share, rel=1e-2)
    assert found.gap == pytest.approx(expected.gap, abs=1e-2 * SPECTRUM.rms)


@pytest.mark.parametrize("share", [0.0, 0.6, 1.0])
def test_what_spots_lose_of_the_field_is_theirs_alone(share):
    insulating = rough().rest(pull(200.0))
    found = insulating.with_field_share(share)
    whole = pull(200.0)(np.zeros(1)).stress[0]
    assert np.all(found.attraction[found.pressure > 0] == pytest.approx(share**2 * whole, rel=1e-12))
    assert np.all(found.attraction[found.gap > 0] == insulating.attraction[found.gap > 0])
    assert found.pressure.min() >= 0
    assert found.pressure - found.attraction == pytest.approx(
        insulating.pressure - insulating.attraction, abs=1e-9 * whole
    )
    assert np.all(found.gap == insulating.gap)


def test_a_smaller_tolerance_is_met():
    coarse, fine = (rough(tolerance=tolerance).rest(pull(150.0)) for tolerance in (1e-3, 1e-9))
    assert fine.residual <= 1e-9
    assert 0 < np.abs(coarse.gap - fine.gap).max() < 1e-2 * SPECTRUM.rms
    assert coarse.rounds < fine.rounds


def test_energy_over_voltage_is_the_charge():
    """dE/dV = -C V at rest: what the source does not deliver twice is stored once. By Gauss-Legendre over the voltage."""
    loaded = rough(tolerance=1e-9)
    nodes, weights = np.polynomial.legendre.leggauss(6)
    voltages = 60 + 60 * nodes
    rests = follow(loaded, pull, [0.0, *voltages, 120.0])
    assert not any(rest.fell for rest in rests)
    charges = [
        np.mean(eps0 / (rest.gap + pull(voltage).electrical_thickness)) * voltage
        for voltage, rest in zip(voltages, rests[1:-1], strict=True)
    ]
    assert rests[-1].energy - rests[0].energy == pytest.approx(-60 * np.dot(weights, charges), rel=1e-4)


def test_energy_over_load_is_the_mean_gap():
    low, middle, high = (rough(pressure=2e4 * factor, tolerance=1e-9).rest() for factor in (0.99, 1, 1.01))
    assert high.energy - low.energy == pytest.approx(400 * middle.mean_gap, rel=1e-4)


def test_energy_is_that_of_the_other_solver_at_no_voltage():
    loaded = rough(tolerance=1e-8)
    assert loaded.rest(pull(0.0)).energy == pytest.approx(loaded.rest().energy, rel=1e-7)


@pytest.mark.parametrize("pressure", [2e4, 5e4, 1.5e5, 4e5])
def test_a_stiff_film_on_a_soft_body_comes_to_rest(pressure):
    """Its places of contact return without end where every step is a whole one; the energy is that of the other solver."""
    stiff = Coated(film=Elastic(modulus=2e7), thickness=5e-5, below=Elastic(modulus=5e5))
    spectrum = SelfAffine(rms=2e-6, hurst=0.8, longest=1e-3, roll_off=2.5e-4, shortest=2.5e-4)
    heights = spectrum.heights((32, 32), (1e-3, 1e-3), seed=0)
    loaded = Loaded(
        heights=heights, periods=(1e-3, 1e-3), compliance=stiff.compliance, pressure=pressure, tolerance=1e-8
    )
    found = loaded.rest()
    assert found.rounds < 100
    assert loaded.rest(pull(0.0)).energy == pytest.approx(found.energy, rel=1e-7)


def test_what_is_followed_up_and_down_comes_back_along_another_path():
    """Between a fall and a release the contact of the way down is larger; away from both the paths are one."""
    loaded, voltages = rough(pressure=2e3), [20.0, 70.0, 100.0, 120.0]

    def thin(voltage):
        return MaxwellStress(voltage=voltage, electrical_thickness=3e-7)

    up = follow(loaded, thin, voltages)
    down = follow(loaded, thin, voltages[::-1], start=up[-1].gap)[::-1]
    assert not up[0].fell
    assert all(rest.fell for rest in up[2:])
    assert down[0].mean_attraction == pytest.approx(up[0].mean_attraction, rel=1e-5)
    assert down[2].mean_attraction > 1.02 * up[2].mean_attraction
    assert down[2].contact_share > up[2].contact_share
    assert down[0].energy == pytest.approx(up[0].energy, rel=1e-6)
    course = [*zip(voltages, up, strict=True), *zip(voltages[::-1], down[::-1], strict=True)]
    for (before, first), (after, second) in pairwise(course):
        # what moves from the gaps of the former rest loses energy, by a fall or not
        charge = np.mean(eps0 / (first.gap + thin(0.0).electrical_thickness))
        held = first.energy - charge * (after**2 - before**2) / 2
        assert second.energy <= held + 1e-9 * abs(held)


def test_the_mean_of_the_heights_does_not_matter_and_scales_do_not():
    plain = rough().rest(pull(150.0))
    shifted = Loaded(
        heights=rough().heights + 1e-3, periods=PERIODS, compliance=SKIN.compliance, pressure=2e4
    ).rest(pull(150.0))
    assert shifted.gap == pytest.approx(plain.gap, abs=1e-5 * SPECTRUM.rms)
    assert shifted.energy == pytest.approx(plain.energy, rel=1e-6)


def test_steepness_tells_whether_the_grid_holds_the_attraction():
    coarse, fine = (rough(shape).rest(pull(100.0)) for shape in ((64, 96), (128, 192)))
    assert coarse.steepness == pytest.approx(2 * fine.steepness, rel=0.02)


def test_what_does_not_come_to_rest_says_why(monkeypatch):
    monkeypatch.setattr(attracted, "ROUNDS", 3)
    with pytest.raises(
        ElectrovibError, match=r"did not come to rest: .* attraction is 0\.\d+ times as steep .* a finer grid"
    ):
        rough().rest(pull(200.0))


@pytest.mark.parametrize(
    ("other", "said"),
    [
        ({"heights": np.zeros(4)}, "two axes"),
        ({"heights": np.full((4, 4), np.nan)}, "finite heights"),
        ({"periods": (1e-3, 0.0)}, "periods"),
        ({"pressure": 0.0}, "pressure = 0.0"),
        ({"pressure": np.inf}, "pressure = inf"),
        ({"tolerance": 0.1}, "tolerance = 0.1"),
    ],
)
def test_what_cannot_be_pressed_is_refused(other, said):
    given = {"heights": np.zeros((4, 4)), "periods": PERIODS, "compliance": SKIN.compliance, "pressure": 1.0}
    with pytest.raises(InputError, match=said):
        Loaded(**given | other)


def test_potentials_are_refused_where_they_are_infinite():
    for given in ({"electrical_thickness": 0.0}, {"voltage": np.nan}):
        with pytest.raises(InputError, match=f"{next(iter(given))} = "):
            MaxwellStress(**{"voltage": 1.0, "electrical_thickness": 1e-6} | given)


def test_flat_surfaces_share_the_load():
    rest = Loaded(heights=np.zeros((8, 8)), periods=PERIODS, compliance=SKIN.compliance, pressure=3e3).rest(
        pull(10.0)
    )
    assert rest.contact_share == 1
    assert rest.pressure == pytest.approx(3e3 + pull(10.0)(np.zeros(1)).stress[0])
