"""The Kramers-Kronig residual: small for causal materials, large for tables that mix two."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from electrovib.core.constants import VACUUM_PERMITTIVITY
from electrovib.core.errors import InputError
from electrovib.physics.kramers_kronig import kramers_kronig_residual

# Measured floor for the materials below: 0.5 % with 51 points, 0.75 % with 11.
CONSISTENT = 0.02


def constant_phase(exponent, corner):
    shift = exponent - 1
    return lambda f: 1560 * (1j * f / corner) ** shift / np.cos(shift * np.pi / 2)


def cole_cole(high, *rows):
    return lambda f: (
        high + sum(step / (1 + (2j * np.pi * f * time) ** (1 - broad)) for step, time, broad in rows)
    )


DRY = cole_cole(4.0, (32, 7.234e-12, 0), (1100, 32.481e-9, 0.2))
WET = cole_cole(4.0, (39, 7.958e-12, 0.1), (280, 79.577e-9, 0), (3e4, 1.592e-6, 0.16), (3e4, 1.592e-3, 0.2))
SKINS = {
    "constant phase 0.7545": (constant_phase(0.7545, 50.9), 0.0),
    "constant phase 0.85": (constant_phase(0.85, 86.1), 0.0),
    # 2 and 20 uS through 1 cm2 and 200 um.
    "palmar 2 uS": (constant_phase(0.7545, 100.0), 4e-6),
    "palmar 20 uS": (constant_phase(0.8025, 100.0), 4e-5),
    "1963 admittance": (constant_phase(0.783, 100.0), 1.53e-5),
    "Gabriel dry": (DRY, 2e-4),
    "Gabriel wet": (WET, 4e-4),
    # Causal although no sum of non-negative Debye terms.
    "Havriliak-Negami 0.9, 1.5": (lambda f: 5 + 1000 / (1 + (2j * np.pi * f * 1e-4) ** 0.9) ** 1.5, 0.0),
}


def table(law, conductivity, count=51):
    frequency = np.geomspace(10, 1e6, count)
    values = law(frequency)
    loss = -values.imag * 2 * np.pi * frequency * VACUUM_PERMITTIVITY
    return frequency, values.real, loss + conductivity


@pytest.mark.parametrize("name", SKINS)
def test_shipped_skins_are_accepted_and_noise_comes_back_as_its_own_size(name):
    assert kramers_kronig_residual(*table(*SKINS[name], 11)) < CONSISTENT / 2
    for count in (51, 26):
        frequency, permittivity, conductivity = table(*SKINS[name], count)
        assert kramers_kronig_residual(frequency, permittivity, conductivity) < CONSISTENT / 2
        residuals = []
        for seed in range(10):
            noise = 1 + np.random.default_rng(seed).normal(0, 0.01, (2, count))
            noisy = permittivity * noise[0], conductivity * noise[1]
            residuals.append(kramers_kronig_residual(frequency, *noisy))
        # The mean of ten scatters by less than 10 %; the basis adds up to 0.5 % in square.
        assert 0.008 < np.mean(residuals) < 0.013


@settings(max_examples=30, deadline=None)
@given(
    steps=st.lists(st.tuples(st.floats(1, 1e5), st.floats(-7, -1)), min_size=1, max_size=4),
    broad=st.floats(0, 0.8),
    conductivity=st.floats(0, 1e-3),
)
def test_accepts_any_sum_of_relaxations(steps, broad, conductivity):
    law = cole_cole(4.0, *((step, 10.0**time, broad) for step, time in steps))
    assert kramers_kronig_residual(*table(law, conductivity)) < CONSISTENT


@pytest.mark.parametrize("count", [51, 26, 11])
def test_flags_an_inadmissible_pair(count):
    """Two power laws with eps''/eps' = 0.18 at 10 Hz, where causality demands tan(0.33 pi/2) = 0.57."""
    frequency = np.geomspace(10, 1e6, count)
    permittivity, conductivity = 1e4 * (frequency / 10) ** -0.33, 1e-6 * (frequency / 10) ** 0.66
    in_siemens = 2 * np.pi * frequency * VACUUM_PERMITTIVITY * permittivity
    assert (conductivity / in_siemens)[0] == pytest.approx(0.18, abs=0.005)
    assert kramers_kronig_residual(frequency, permittivity, conductivity) > 10 * CONSISTENT
    own = in_siemens * np.tan(0.33 * np.pi / 2)
    assert kramers_kronig_residual(frequency, permittivity, own) < CONSISTENT / 2
    # 10 % too much loss is seen, at the level that the limits of a finite band leave.
    assert kramers_kronig_residual(frequency, permittivity, 1.1 * own) > CONSISTENT


def test_constant_permittivity_with_rising_loss_is_flagged():
    # What a first-order filter with tau(f) put in point by point amounts to: dispersion in one part only.
    frequency, _, conductivity = table(*SKINS["constant phase 0.7545"])
    assert kramers_kronig_residual(frequency, np.full(51, 1560.0), conductivity) > 5 * CONSISTENT


def test_is_independent_of_order_and_of_scale():
    frequency, permittivity, conductivity = table(*SKINS["Gabriel wet"])
    straight = kramers_kronig_residual(frequency, permittivity, 1.3 * conductivity)
    back = kramers_kronig_residual(frequency[::-1], permittivity[::-1], 1.3 * conductivity[::-1])
    # Scaling eps and sigma alike cancels in the relative error, up to rounding.
    scaled = kramers_kronig_residual(frequency, 7 * permittivity, 7 * 1.3 * conductivity)
    assert back == pytest.approx(straight, rel=1e-9)
    assert scaled == pytest.approx(straight, rel=1e-6)


@pytest.mark.parametrize(
    ("columns", "message"),
    [
        (([1.0, 2.0], [3.0], [1.0, 1.0]), "equal length"),
        (([], [], []), "equal length"),
        (([1.0, np.nan], [3.0, 3.0], [1.0, 1.0]), r"frequency\[1\]: must be finite"),
        (([1.0, 2.0], [3.0, 3.0], [np.inf, 1.0]), r"conductivity\[0\]: must be finite"),
        (([0.0, 2.0], [3.0, 3.0], [1.0, 1.0]), "above 0 Hz"),
        (([2.0, 2.0], [3.0, 3.0], [1.0, 1.0]), "repeated"),
        (([1.0, 2.0], [3.0, 0.0], [1.0, 0.0]), "both 0"),
        (table(*SKINS["Gabriel wet"], 6), "too few to judge"),
    ],
)
def test_refuses_tables_that_are_none(columns, message):
    with pytest.raises(InputError, match=message):
        kramers_kronig_residual(*columns)
