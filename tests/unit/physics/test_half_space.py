"""The compliance of a film on a half-space: limits, and the elastic equations solved anew."""

import numpy as np
import pytest

from electrovib.physics.half_space import Coated, Elastic

SKIN, TISSUE = Elastic(modulus=2e6, poisson=0.45), Elastic(modulus=5e4, poisson=0.5)
METAL = Elastic(modulus=2e11, poisson=0.3)
WAVES = np.geomspace(1e-3, 1e3, 13)


def test_a_homogeneous_body_has_twice_the_inverse_of_the_plane_strain_modulus_and_the_wave_number():
    body = Elastic(modulus=1.5e6, poisson=0.3)
    assert body.compliance(2.0) == pytest.approx(2 * (1 - 0.3**2) / (1.5e6 * 2.0), rel=1e-14)


@pytest.mark.parametrize("below", [TISSUE, METAL, Elastic(modulus=2e6, poisson=0.1)])
def test_short_waves_feel_the_film_and_long_ones_what_is_below(below):
    thickness = 1e-5
    coated = Coated(film=SKIN, thickness=thickness, below=below)
    short, long = np.array([20.0]) / thickness, np.array([1e-9]) / thickness
    assert coated.compliance(short) == pytest.approx(SKIN.compliance(short), rel=1e-12)
    assert coated.compliance(long) == pytest.approx(below.compliance(long), rel=2e-4)
    assert Coated(film=SKIN, thickness=0, below=below).compliance(WAVES) == pytest.approx(
        below.compliance(WAVES), rel=1e-12
    )


def test_a_film_of_the_same_material_changes_nothing():
    assert Coated(film=SKIN, thickness=0.3, below=SKIN).compliance(WAVES) == pytest.approx(
        SKIN.compliance(WAVES), rel=1e-12
    )


def test_an_incompressible_film_on_a_rigid_body_is_the_known_closed_form():
    film = Elastic(modulus=1e6, poisson=0.5)
    coated = Coated(film=film, thickness=1.0, below=Elastic(modulus=1e17, poisson=0.3))
    x = np.array([0.3, 1.0, 3.0])
    known = (np.sinh(2 * x) - 2 * x) / (1 + 2 * x**2 + np.cosh(2 * x))
    assert coated.compliance(x) == pytest.approx(known * film.compliance(x), rel=1e-8)


def solved(film, thickness, below, q):
    """Displacement per pressure from Airy's function (A + B z) e^-qz + (C + D z) e^qz, and (F + G z) e^-qz below.

    Plane strain: sigma_zz = -q^2 phi, sigma_xz ~ -q phi', and displacements by integration of Hooke's law.
    """

    def terms(body, z, sign):
        # phi = e^(sign q z) and z e^(sign q z): rows sigma_zz, sigma_xz, u_x, u_z for each
        s, e, nu = sign * q, np.exp(sign * q * z), body.poisson
        rows = []
        for phi, first, second, third in (
            (e, s * e, s**2 * e, s**3 * e),
            (z * e, (1 + s * z) * e, (2 * s + s**2 * z) * e, (3 * s**2 + s**3 * z) * e),
        ):
            # eps_xx = [(1-nu) sxx - nu szz]/(2 mu), sxx = phi'', szz = -q^2 phi; u_x = eps_xx/q (sine)
            across = ((1 - nu) * second + nu * q**2 * phi) / (2 * body.shear * q)
            # 2 eps_xz = sxz/mu = u_x' - q u_z with sxz = q phi' (sine)
            down = (
                ((1 - nu) * third + nu * q**2 * first) / (2 * body.shear * q) - q * first / body.shear
            ) / q
            rows.append([-(q**2) * phi, q * first, across, down])
        return rows

    top = [*terms(film, 0.0, -1), *terms(film, 0.0, 1)]
    bond = [*terms(film, thickness, -1), *terms(film, thickness, 1)]
    under = terms(below, 0.0, -1)
    matrix = np.zeros((6, 6))
    for column in range(4):
        matrix[:2, column] = top[column][:2]
        matrix[2:, column] = bond[column]
    for column in range(2):
        matrix[2:, 4 + column] = -np.array(under[column])
    scale = np.abs(matrix).max(axis=1)
    found = np.linalg.solve(matrix / scale[:, None], np.array([-1.0, 0, 0, 0, 0, 0]) / scale)
    return sum(found[column] * top[column][3] for column in range(4))


@pytest.mark.parametrize("below", [TISSUE, METAL])
@pytest.mark.parametrize("reach", [0.1, 0.7, 2.0])
def test_it_solves_the_equations_of_elasticity(below, reach):
    thickness = 3e-5
    q = reach / thickness
    found = Coated(film=SKIN, thickness=thickness, below=below).compliance(q)
    assert found == pytest.approx(solved(SKIN, thickness, below, q), rel=1e-9)


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: Elastic(modulus=0), r"modulus\n.*between"),
        (lambda: Elastic(modulus=np.inf), r"modulus\n.*finite"),
        (lambda: Elastic(modulus=1e6, poisson=0.6), r"poisson\n.*between 0 and 0.5"),
        (lambda: Elastic(modulus=1e6, poisson=-0.1), r"poisson\n.*between 0 and 0.5"),
        (lambda: Coated(film=SKIN, thickness=-1e-6, below=TISSUE), r"thickness\n.*between 0 m"),
    ],
)
def test_what_is_no_body_is_refused(make, said):
    with pytest.raises(ValueError, match=said):
        make()
