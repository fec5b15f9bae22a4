"""Fringe field at the edge of a finite contact: its addition to the attraction of the Maxwell stress in the gap.

The laws of a stack in series give a pressure, and the force is this pressure times the contact area. At the rim the field
extends beyond the edge of the finger and adds to the attraction: on the film of Vezzoli et al. 2014, with a gap of 5 um and
an edge of 0.2 mm radius, 10.4 % for a strip of 2 mm, 4.2 % at 5 mm, 2.1 % at 10 mm, 1.0 % at 20 mm, and 4.2 % for a disc of
10 mm. No law applies it by default. Status: derived, with one fit to a field solution where no closed form is known
(`examples/field_solution.py`, `tests/reference/test_field_solution.py`).
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, TypeAlias

import numpy as np

from electrovib.core.errors import InputError, refuse

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

Real: TypeAlias = "NDArray[np.float64]"

STATUS: Final = "derived"
"""How the correction was found."""
PERMITTIVITIES: Final = (1.0, 10.0)
"""Relative permittivity of the film over which the correction was compared with the field [1]."""
LARGEST_SHARE: Final = 0.99
"""Largest share of the film in the electrical thickness for which it was compared [1]."""
NARROWEST_STRIP, NARROWEST_DISC = 2.0, 10.0
"""Smallest width over film and gap [1]: below it the edges interact, or the curvature of the rim matters."""
ROUNDING: Final = 1e-9
# Fitted to the field of a square edge on a film, over the ranges above.
SHARE_POWER, SPREAD, SPREAD_POWER = 1.5, 1.23, 0.2
# Fitted to the passage from a square to a well rounded edge.
SHARPNESS, SHARPNESS_POWER = 1.05, 4


def fringe_factor(
    *,
    width: ArrayLike,
    electrical_thickness: ArrayLike,
    film_thickness: ArrayLike = 0.0,
    film_permittivity: ArrayLike = 1.0,
    edge_radius: ArrayLike = 0.0,
    round_contact: bool = False,
) -> Real:
    r"""Force on a finite contact over the Maxwell stress in the gap times the contact area.

    Parameters
    ----------
    width : array_like
        Width of the flat part of a long strip, or diameter of a disc [m]; at least 2 times film and gap together, for a
        disc 10 times.
    electrical_thickness, film_thickness, film_permittivity, edge_radius : array_like
        As in `edge_excess`; all are broadcast.
    round_contact : bool
        A disc instead of a long strip.

    Returns
    -------
    factor : ndarray
        Ratio of forces, dimensionless, at least 1.

    Raises
    ------
    InputError
        As `edge_excess`, or the contact is so narrow that its edges interact.

    Notes
    -----
    With the excess length e of one edge, electrical thickness d and radius of the edge R

    .. math:: 1 + \frac{2e}{w} \text{ (strip)}, \qquad
        1 + \frac{4e}{w} + \frac{8 d^2}{w^2}\left[\frac{R}{d} - \ln\left(1 + \frac{R}{d}\right)\right] \text{ (disc)}

    the last term accounts for the length of the rim, which grows with its distance from the axis. Deviation from the field
    solution over the ranges of `edge_excess`: for a strip at most 2 % from 2 times film and gap up, 1 % from 10 times up;
    for a disc at most 6 % from 10 times up, 3 % from 20, 1 % from 50.
    The factor holds for the force only. The capacitance has no such limit: it grows with the logarithm of the height of the
    wall of the finger, on which the attraction is lateral.
    """
    excess = edge_excess(
        electrical_thickness=electrical_thickness,
        film_thickness=film_thickness,
        film_permittivity=film_permittivity,
        edge_radius=edge_radius,
    )
    breadth, total, film, permittivity, radius = _broadcast(
        width, electrical_thickness, film_thickness, film_permittivity, edge_radius
    )
    times = NARROWEST_DISC if round_contact else NARROWEST_STRIP
    least = times * (film + total - film / permittivity)
    if not np.all(breadth > least * (1 - ROUNDING)):
        raise InputError(
            f"width = {np.min(breadth):.4g} m: must be at least {np.max(least):.4g} m, {times:g} times film and gap,"
            " so that the edges do not interact; below, solve the field as in examples/field_solution.py"
        )
    factor = 1 + (4 if round_contact else 2) * excess / breadth
    if round_contact:
        ratio = radius / total
        factor = factor + 8 * (total / breadth) ** 2 * (ratio - np.log1p(ratio))
    return np.asarray(factor)


def edge_excess(
    *,
    electrical_thickness: ArrayLike,
    film_thickness: ArrayLike = 0.0,
    film_permittivity: ArrayLike = 1.0,
    edge_radius: ArrayLike = 0.0,
) -> Real:
    r"""Length by which one straight edge widens a contact in terms of its attraction.

    Parameters
    ----------
    electrical_thickness : array_like
        d = K + g, sum of thickness over permittivity of all layers between plate and finger, gap included
        [m], above 0.
    film_thickness : array_like
        Of the dielectric on the plate, which extends beyond the finger [m]; 0 for none.
    film_permittivity : array_like
        Of that film, 1 to 10. The film may be at most 99 % of the electrical thickness.
    edge_radius : array_like
        Of the quarter circle between the flat contact and the vertical wall of the finger [m]; 0 for a square edge.

    Returns
    -------
    excess : ndarray
        Excess length [m], of the broadcast shape of the arguments.

    Raises
    ------
    InputError
        A length is negative or not finite, or the film is outside the range that was compared with the field.

    Notes
    -----
    In units of d, with rho = R/d, permittivity eps and share kappa = (T/eps)/d of the film,

    .. math:: \frac{e}{d} = \underbrace{\frac{\rho}{s^2} + \frac{2\rho^2 \arctan s}{s^3}}_{\text{wedge}}
        + \left[c^{-p} + \left(\frac{a}{\sqrt\rho}\right)^{-p}\right]^{-1/p}, \qquad s^2 = 1 + 2\rho

    The wedge is the Maxwell stress in the local gap, integrated under the round edge. The rest is the lateral field. Its limit
    for a square edge without a film is the conformal map of a step, c = 2/pi: the field on the finger is
    E0/sqrt(1 - u) with dx = (d/pi) sqrt(1 - u) du/u. Its limit for a large radius is the next order of a slowly varying
    gap, :math:`C/\varepsilon_0 = \int [1 + (g'^2/3)(1 + (\varepsilon^2-1)(T/\varepsilon)^3/d^3)]/d\;dx`, so

    .. math:: a = \frac{\pi\sqrt2}{6}\left[1 + \frac{5}{16}(\varepsilon^2 - 1)\kappa^3\right]

    With a film the square limit is

    .. math:: c = \frac2\pi + \frac{\varepsilon - 1}{\pi} \kappa^{3/2} \frac{1 - x^{-m}}{m}, \quad
        x = 1 + 1.23\,\varepsilon^{0.2} \frac{\kappa}{1 - \kappa}, \quad
        m = \frac4\pi \arctan\sqrt{1 + 2/\varepsilon} - 1

    where D^2 at the corner on a film without a gap goes as r^(m - 1), and (eps - 1)/pi is the weight of its
    logarithm for eps to infinity; 3/2, 1.23, 0.2 and p = 2 - 1.05 kappa (1 - 1/eps)^4 are fitted.

    Validity: within 4 % of the field solution for eps 1 to 10, kappa up to 0.99 and every radius; within 2 % without a film.
    The skin is taken as a uniform part of d: 200 um of permittivity 1560 changed the force on a contact 10 mm wide by at
    most 0.3 %. The plate is infinite, the finger is tall, and the air outside does not conduct.
    """
    total, film, permittivity, radius = _broadcast(
        electrical_thickness, film_thickness, film_permittivity, edge_radius
    )
    share = _checked_share(total, film, permittivity, radius)
    ratio = radius / total
    square = _square_edge(permittivity, share)
    rounded = np.pi * np.sqrt(2) / 6 * (1 + 5 / 16 * (permittivity**2 - 1) * share**3)
    power = 2 - SHARPNESS * share * (1 - 1 / permittivity) ** SHARPNESS_POWER
    lateral = square * (1 + (square * np.sqrt(ratio) / rounded) ** power) ** (-1 / power)
    return np.asarray(total * (_wedge(ratio) + lateral))


def _square_edge(permittivity: Real, share: Real) -> Real:
    """Excess of a square edge over the electrical thickness, c."""
    power = 4 / np.pi * np.arctan(np.sqrt(1 + 2 / permittivity)) - 1
    spread = 1 + SPREAD * permittivity**SPREAD_POWER * share / (1 - share)
    film = (permittivity - 1) / np.pi * share**SHARE_POWER * (1 - spread**-power) / power
    return np.asarray(2 / np.pi + film)


def _wedge(ratio: Real) -> Real:
    """Integral of d0^2/d(x)^2 under a quarter circle of this radius over d0, over d0."""
    root = np.sqrt(1 + 2 * ratio)
    return np.asarray(ratio / root**2 + 2 * ratio**2 * np.arctan(root) / root**3)


def _broadcast(*values: ArrayLike) -> tuple[Real, ...]:
    return tuple(np.broadcast_arrays(*[np.asarray(value, dtype=float) for value in values]))


def _checked_share(total: Real, film: Real, permittivity: Real, radius: Real) -> Real:
    lengths = {"electrical_thickness": total, "film_thickness": film, "edge_radius": radius}
    problems = [
        f"{name} = {np.min(value):.4g} m: must be finite and not negative"
        for name, value in lengths.items()
        if not np.all(np.isfinite(value) & (value >= 0))
    ]
    low, high = PERMITTIVITIES
    if not np.all((permittivity >= low) & (permittivity <= high)):
        problems.append(
            f"film_permittivity = {np.max(permittivity):.4g}: compared with the field from {low:g} to {high:g} only"
        )
    refuse(problems)
    within = film <= LARGEST_SHARE * (1 + ROUNDING) * total * permittivity
    if not np.all(within & (total > 0)):
        raise InputError(
            f"electrical_thickness = {np.min(total):.4g} m: it is that of film and gap together, and the"
            f" {np.max(film / permittivity):.4g} m of the film may be at most {LARGEST_SHARE:.0%} of it"
        )
    return np.asarray(film / permittivity / total)
