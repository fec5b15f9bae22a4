"""Field between plate and finger, solved by finite elements without the assumption of layers in series.

A finger of finite width with a rounded edge stands over an infinite plate with a film on it; what lies outside is
air. Finite elements (scikit-fem) give the potential; the force follows from the Maxwell stress in the gap and from
virtual work, which must agree. In one dimension the same equation with complex permittivities, conduction included,
gives a leaky stack over frequency. The output is the deviation of the law MaxwellStressInGap, of the stack and of the
correction `fringe_factor` from these fields.

The laws of a stack in series give a pressure, and the force is this pressure times the contact area. At the rim the field
extends beyond the edge of the finger and adds to the attraction: on the film of Vezzoli et al. 2014, with a gap of 5 um and
an edge of 0.2 mm radius, 10.4 % for a strip of 2 mm, 4.2 % at 5 mm, 2.1 % at 10 mm, 1.0 % at 20 mm, and 4.2 % for a disc of
10 mm. `fringe_factor` is derived, with one fit to the field where no closed form is known.
"""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path
from typing import Any, Final, NamedTuple

import numpy as np
import skfem
from numpy.typing import ArrayLike
from skfem.helpers import dot, grad

import electrovib as ev
from electrovib.core.errors import InputError, refuse

EPS0 = 8.8541878128e-12
Real = np.ndarray[Any, np.dtype[np.float64]]


class Finger(NamedTuple):
    """A finger on a film: lengths in metres, permittivities relative, complex eps* for a leaky one at one frequency."""

    half_width: float  # of the flat contact
    edge_radius: float = 200e-6
    film: float = 90e-6
    film_permittivity: complex = 3.35
    gap: float = 5e-6
    gap_permittivity: complex = 1.0
    skin: float = 200e-6
    skin_permittivity: complex = 1560.0
    wall: float = 5.0  # height of the finger's wall and length of plate beside it: far away
    edge: bool = True  # False: symmetry on both sides
    round_contact: bool = False  # a disc instead of a strip

    @property
    def thicknesses(self) -> Real:
        """From the plate to the deep finger."""
        return np.array([self.film, self.gap, self.skin])

    @property
    def permittivities(self) -> Any:
        """The same, real where nothing is lost."""
        values = np.array([self.film_permittivity, self.gap_permittivity, self.skin_permittivity])
        return values.real if np.all(values.imag == 0) else values

    @property
    def area(self) -> float:
        """Contact area, per metre of length for half a strip."""
        return np.pi * self.half_width**2 if self.round_contact else self.half_width


class Field(NamedTuple):
    """A solved field, at 1 V on the plate."""

    finger: Finger
    grid: skfem.MeshQuad  # in the coordinates of `place`
    mesh: skfem.MeshQuad2
    potential: Any
    capacitance: complex  # per metre for half a strip


def graded(first: float, growth: float = 1.4) -> Real:
    """Nodes from 0 to 1 whose first distance is about this, each next one longer by a factor."""
    first = min(first, 0.3)
    count = int(np.ceil(np.log(1 + (growth - 1) / first) / np.log(growth)))
    nodes = np.cumsum(np.concatenate([[0.0], growth ** np.arange(count)]))
    return np.asarray(nodes / nodes[-1])


def grid_of(finger: Finger, halvings: int) -> skfem.MeshQuad:
    """Tensor grid in the two coordinates of `place`, fine at the edge of the contact."""
    radius, gap, flat = finger.edge_radius, finger.gap, finger.half_width
    fine = min(radius * np.pi / 16, gap / 2)
    along = [1 - graded(fine / flat)[::-1]]
    if finger.edge:
        turn = min(1 / 8, 0.35 * np.sqrt(2 * gap / radius))
        along += [1 + graded(turn)[1:], 2 + graded(fine / finger.wall)[1:]]
    film = 1 - graded(0.3 * gap / finger.film)[::-1]
    across = [film, 2 - graded(0.3 * min(1, radius / gap))[::-1][1:], 2 + np.linspace(0, 1, 4)[1:]]
    nodes = [np.concatenate(along), np.concatenate(across)]
    for _ in range(halvings):
        nodes = [np.sort(np.concatenate([n, (n[1:] + n[:-1]) / 2])) for n in nodes]
    return skfem.MeshQuad.init_tensor(*nodes)


def place(finger: Finger, along: Real, across: Real) -> Real:
    """Return points of the cross-section, shape (2, ...).

    Along the finger's surface: 0 axis, 1 end of the flat part, 2 foot of the wall, 3 far. Across: 0 plate, 1 film, 2
    surface of the finger, 3 deep finger; in the air on circles that meet finger and film at right angles.
    """
    angle = np.pi / 2 * np.clip(along - 1, 0, 1)
    x = finger.half_width * np.clip(along, 0, 1) + finger.edge_radius * np.sin(angle)
    bend = finger.edge_radius * (1 - np.cos(angle))
    height = finger.gap + bend + finger.wall * np.clip(along - 2, 0, 1)
    share = np.clip(across - 1, 0, 1)
    sine = np.where(angle > 0, np.sin(angle), 1.0)
    out_x = x + height * np.where(angle > 0, (np.cos(share * angle) - np.cos(angle)) / sine, 0.0)
    out_y = finger.film + height * np.where(angle > 0, np.sin(share * angle) / sine, share)
    deep = finger.skin * np.clip(across - 2, 0, 1)
    inward_x, inward_y = np.sin(angle), np.cos(angle)
    if finger.edge_radius < finger.skin:  # the deep finger has a corner, towards which the lines run
        corner_x = finger.half_width + finger.edge_radius - finger.skin
        inward_x = np.maximum(x - corner_x, 0) / finger.skin
        inward_y = np.maximum(1 - (height - finger.gap) / finger.skin, 0)
    below = finger.film * (1 - np.clip(across, 0, 1))
    return np.array([out_x - deep * inward_x, out_y - below + deep * inward_y])


def poisson(basis: Any, permittivity: Any, plate: Any, finger: Any, weight: Any = 1.0) -> tuple[Any, Any]:
    """Potential with 1 V on the plate and 0 on the finger, and energy phi A phi."""

    def energy(u: Any, v: Any, w: Any) -> Any:
        return w.permittivity * w.weight * dot(grad(u), grad(v))

    everywhere = permittivity[:, np.newaxis] * np.ones(len(basis.W))
    form = skfem.BilinearForm(energy, dtype=np.result_type(permittivity, float))
    matrix = form.assemble(basis, permittivity=everywhere, weight=weight * np.ones(everywhere.shape))
    start = np.zeros(basis.N, matrix.dtype)
    start[plate] = 1
    potential = skfem.solve(*skfem.condense(matrix, x=start, D=np.concatenate([plate, finger])))
    return potential, potential @ (matrix @ potential)


def solve(finger: Finger, halvings: int = 0) -> Field:
    """Solve div(eps grad phi) = 0; no flux crosses the outer boundary."""
    grid = grid_of(finger, halvings)
    mesh = skfem.MeshQuad2.from_mesh(grid)
    mesh = replace(mesh, doflocs=place(finger, *mesh.doflocs))
    basis = skfem.Basis(mesh, skfem.ElementQuad2(), intorder=5)
    permittivity = finger.permittivities[grid.p[1][grid.t].mean(axis=0).astype(int)]
    ends = [grid.facets_satisfying(lambda p, end=end: np.abs(p[1] - end) < 1e-9) for end in (0, 3)]
    plate, deep = (basis.get_dofs(end).flatten() for end in ends)
    weight = circumference(finger, basis)
    potential, energy = poisson(basis, permittivity, plate, deep, weight)
    return Field(finger, grid, mesh, potential, EPS0 * energy)


def circumference(finger: Finger, basis: skfem.Basis) -> Any:
    return 2 * np.pi * basis.global_coordinates()[0] if finger.round_contact else 1.0


def stress_force(field: Field, *, across: float = 1.5) -> float:
    """Attraction [N/V2, per metre for half a strip] by the Maxwell stress on a surface in the gap.

    The surface lies in the middle of the gap; beside the contact it follows the edge and the wall, so that it
    encloses the finger. The stress T = eps0 (E E - 1 E^2/2) is taken with both components of the field. It is
    evaluated at Gauss points of the elements, where the gradient is more exact than elsewhere. The time mean is given
    for complex fields.
    """
    middles = field.grid.p[1][field.grid.t].mean(axis=0)
    in_gap = np.unique(middles[(middles > 1) & (middles < 2)])
    row = np.flatnonzero(middles == in_gap[np.argmin(np.abs(in_gap - across))])
    points = (1 + np.array([-1, 1]) / np.sqrt(3)) / 2
    force = 0.0
    for level in points:
        local = np.array([[level, level], points])
        rule = (local, np.full(2, 0.5))
        basis = skfem.Basis(field.mesh, skfem.ElementQuad2(), elements=row, quadrature=rule)
        x_field, y_field = basis.interpolate(field.potential).grad
        tangent = basis.mapping.DF(local, tind=row)[:, 1]
        normal = (tangent[1], -tangent[0])  # away from the finger, times length
        across_field = x_field * normal[0] + y_field * normal[1]
        squared = np.abs(x_field) ** 2 + np.abs(y_field) ** 2
        pull = squared * normal[1] / 2 - np.real(across_field * np.conj(y_field))
        force += EPS0 * float(np.sum(pull * circumference(field.finger, basis))) / 4  # two levels, two points
    return force / 2 if np.iscomplexobj(field.potential) else force


def virtual_work(finger: Finger, halvings: int = 0, step: float = 1e-3) -> float:
    """Attraction -(V^2/2) dC/dg at 1 V by moving the finger, units as `stress_force`."""
    gaps = finger.gap * (1 + step), finger.gap * (1 - step)
    further, nearer = (solve(finger._replace(gap=gap), halvings).capacitance.real for gap in gaps)
    return (nearer - further) / (4 * step * finger.gap)


def pressed(finger: Finger) -> float:
    """Return the pressure in the gap at 1 V as computed by electrovib [Pa]."""
    trace = ev.simulate(scenario(finger, {"model": "Step", "level": 1.0}))
    return float(trace.electrostatic_force[-1]) / 1e-4


def scenario(finger: Finger, drive: dict[str, Any], **materials: dict[str, Any]) -> ev.Scenario:
    """The planar stack of this finger; a material by layer name where it is not a constant."""
    names = ("insulator", "gap", "stratum_corneum")
    constants = [{"model": "Constant", "permittivity": float(eps.real)} for eps in finger.permittivities]
    stack = {
        name: {"thickness": thickness, "material": materials.get(name, constant)}
        for name, thickness, constant in zip(names, finger.thicknesses, constants, strict=True)
    }
    content = {
        "drive": drive,
        "force": {"model": "MaxwellStressInGap"},
        "friction": {"model": "Coulomb", "coefficient": 0.5},
        "contact": {"model": "FixedArea", "area": 1e-4},
        "load": {"normal_force": 0.5},
        "circuit": {"return_path": {"model": "Grounded", "resistance": 0.0}},
        "stack": stack,
    }
    found: ev.Scenario = ev.load(content)
    return found


def leaky_gap_field(finger: Finger, elements: int = 4) -> complex:
    """Field in the gap [V/m per volt] of the planar stack with complex permittivities, on a line of elements."""
    layer = np.repeat(np.arange(3), elements)
    nodes = np.concatenate([[0.0], np.cumsum(finger.thicknesses[layer] / elements)])
    basis = skfem.Basis(skfem.MeshLine(nodes), skfem.ElementLineP2())
    plate, deep = (basis.get_dofs(lambda p, x=x: np.abs(p[0] / nodes[-1] - x) < 1e-9) for x in (0, 1))
    potential, _ = poisson(basis, finger.permittivities[layer], plate.flatten(), deep.flatten())
    return complex(-np.mean(basis.interpolate(potential).grad[0][layer == 1]))


def palmar_skin(frequency: float, *, conductance: float = 2e-6, exponent: float = 0.7545) -> complex:
    """Relative eps* of 200 um of palmar skin: G0 + Q (j w)^n per cm2, 6.9 nF at 100 Hz, conduction included."""
    angular, anchor = 2 * np.pi * frequency, 2 * np.pi * 100.0
    scale = 6.9e-9 * anchor ** (1 - exponent) / np.sin(exponent * np.pi / 2)
    admittance = conductance + scale * (1j * angular) ** exponent
    return complex(admittance * 200e-6 / 1e-4 / (1j * angular * EPS0))


def leaky(finger: Finger, frequency: float, *, gap_conductivity: float = 1 / 8.7e8) -> Finger:
    """The same finger with palmar skin and a gap that conducts, at one frequency."""
    gap = 1 - 1j * gap_conductivity / (2 * np.pi * frequency * EPS0)
    return finger._replace(gap_permittivity=gap, skin_permittivity=palmar_skin(frequency))


def leaky_error(finger: Finger, samples: int = 25) -> float:
    """Largest relative difference of the mean pressure, package against mesh, from 1 Hz to 1 MHz."""
    skin = {"model": "ConstantPhase", "exponent": 0.7545, "reference_frequency": 100.0, "conductivity": 4e-6}
    skin["permittivity"] = 6.9e-9 * 200e-6 / (EPS0 * 1e-4)
    gap = {"model": "Constant", "permittivity": 1.0, "conductivity": 1 / 8.7e8}
    sine = {"model": "Sine", "amplitude": 1.0, "frequency": 1e3}
    settled = {"frequency.samples": samples, "time.initial_state": {"model": "PeriodicState"}}
    trace = ev.simulate(scenario(finger, sine, gap=gap, stratum_corneum=skin).replace(settled))
    fields = np.array([leaky_gap_field(leaky(finger, f)) for f in trace.frequency.values])
    return float(np.max(np.abs(trace.mean_force.values / 1e-4 / (EPS0 * np.abs(fields) ** 2 / 4) - 1)))


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
            " so that the edges do not interact; below, solve the field as `solve` does"
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


def fringe(finger: Finger) -> float:
    """Return the correction `fringe_factor` for this finger, dimensionless."""
    return float(
        fringe_factor(
            width=2 * finger.half_width,
            electrical_thickness=np.sum(finger.thicknesses / finger.permittivities),
            film_thickness=finger.film,
            film_permittivity=finger.film_permittivity.real,
            edge_radius=finger.edge_radius,
            round_contact=finger.round_contact,
        )
    )


def draw(file: str | Path, finger: Finger | None = None) -> None:
    """Draw the potential at the edge, and the excess of the force over the width of the contact."""
    import matplotlib.pyplot as plt

    finger = finger or Finger(half_width=1e-3)
    figure, (left, right) = plt.subplots(1, 2, figsize=(10, 4), layout="constrained")
    field = solve(finger, 1)
    x, y = 1e6 * (field.mesh.doflocs - np.array([[finger.half_width], [0]]))
    basis = skfem.Basis(field.mesh, skfem.ElementQuad2())
    vertices = np.zeros(x.size, int)
    vertices[field.mesh.t] = basis.nodal_dofs[0][field.mesh.t]
    corners = np.concatenate([field.mesh.t[[0, 1, 2]].T, field.mesh.t[[0, 2, 3]].T])
    picture = left.tricontourf(x, y, corners, field.potential[vertices], levels=np.linspace(0, 1, 21))
    extent = 1e6 * (finger.film + finger.gap + finger.edge_radius)
    left.set(xlim=(-extent, 2 * extent), ylim=(0, 1.5 * extent), aspect="equal")
    left.set(xlabel="distance from the end of the flat contact (um)", ylabel="height over the plate (um)")
    left.axhline(1e6 * finger.film, color="white", linestyle="--", linewidth=0.8)
    left.text(1.95 * extent, 1e6 * finger.film, "film", ha="right", va="top")
    left.text(-0.5 * extent, 1.2 * extent, "deep finger\n(conductor)", ha="center", va="center")
    figure.colorbar(picture, ax=left, label="potential (V)", shrink=0.6)
    half_widths = np.geomspace(2 * extent, 100 * extent, 8) * 1e-6
    fingers = [finger._replace(half_width=half) for half in half_widths]
    forces = [stress_force(solve(one)) / (pressed(one) * one.area) for one in fingers]
    right.loglog(2e3 * half_widths, np.array(forces) - 1, "o", label="field")
    right.loglog(2e3 * half_widths, [fringe(one) - 1 for one in fingers], label="fringe_factor - 1")
    right.set(
        xlabel="width of the contact (mm)",
        ylabel="excess over the force of MaxwellStressInGap",
    )
    right.legend()
    figure.savefig(file)
    plt.close(figure)


def main() -> Real:
    """Return the relative differences of planar law, virtual work, correction and leaky stack."""
    finger = Finger(half_width=5e-3)
    planar = finger._replace(edge=False)
    law, force = pressed(finger), stress_force(solve(finger))
    errors = (
        stress_force(solve(planar)) / (law * planar.area) - 1,
        virtual_work(finger) / force - 1,
        fringe(finger) / (force / (law * finger.area)) - 1,
        leaky_error(finger),
    )
    return np.array(errors)


if __name__ == "__main__":
    if len(sys.argv) > 1:  # the name of a picture
        draw(sys.argv[1])
    share = fringe(Finger(half_width=5e-3)) - 1
    print(f"the edges of a contact of 10 mm add {100 * share:.2g} % to the force of layers in series")
    for error, name in zip(main(), ("planar law", "virtual work", "correction", "leaky stack"), strict=True):
        print(f"{name}: relative deviation {error:+.1e}")
