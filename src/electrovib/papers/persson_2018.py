"""B. N. J. Persson, "The dependency of adhesion and friction on electrostatic attraction", 2018.

Journal of Chemical Physics 148, 144701; extended in "General theory of electroadhesion", 2021.

Claims: a mean-field theory of electrostatic attraction between rough elastic solids, with and without an
insulating layer between the conductors; with a layer, under a small nominal pressure, contact area and friction
rise sharply at a critical voltage. The later paper takes layers of finite conductivity and reduces to this one.
Does not claim: that one equivalent gap can represent the distribution of gaps; numbers of a finger (none was read). Only
the abstracts were read: the stress at one gap is that of plates in series. The paper's distribution of gaps, solved
together with contact and attraction, is not part of this law, which takes a Gaussian.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Annotated, Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from electrovib.core.constants import eps0
from electrovib.core.diagnostics import Diagnostic
from electrovib.core.errors import InputError
from electrovib.core.quantity import Number, Quantity
from electrovib.core.units import format_quantity
from electrovib.papers import published
from electrovib.physics.force import ForceLaw
from electrovib.physics.roughness import ContactSpots, GaussianGaps, PullingSpots, local_pull, mean_pull
from electrovib.physics.stack import Layer, Linear, Section, roles_of

PAPER = published(__name__)
CITATIONS, CITATION, STATUS, NOT_READ, DEFECTS, PRESETS = PAPER.declared
scenarios = PAPER.scenarios

COUNT, EXTENT = 32, 5.5
"""Number of gaps in the law's average, and their range about the mean in rms gaps: the error is at most 2e-4 of the pull."""
TOUCHING = 1e-9
"""Gap at a spot that touches, over the electrical thickness of what does not conduct: it changes the pull by 2e-9."""
SCALE_FREQUENCY = 1.0
"""Frequency of the electrical thickness from which the gaps of the average are chosen [Hz]."""
PRINT_PERIOD = 0.45e-3
"""Distance of the ridges of a fingerprint [m]."""


class Persson2018RoughGap(ForceLaw):
    """Attraction of a rough skin: the average of the pull over all local gaps, contact spots included.

    Notes
    -----
    <p> = eps0/2 [phi E(0)^2 + integral over u > 0 of P(u) E(u)^2 du], E(u) = V/(u + h0), h0 = sum T/eps* over
    the layers, P a Gaussian of `mean_gap` and `rms_gap`, phi = A_real/A0 the share of it at or below 0. Each
    amplitude is the field at one gap times the root of its share. The fields are those of the layers in series
    with that gap, exact in time and in frequency for layers as declared, dispersive or conducting; the average
    takes 32 gaps, with an error within 2e-4.

    The distribution replaces the layer ``gap``, which the stack must not have, and at least one layer must not
    conduct. V is the voltage of the stack without a gap, in which a series impedance takes more of the voltage than with
    rough skin; the body should therefore be grounded, and its resistance times the capacitance of the layers short. Valid
    for wavelengths of the roughness that are long compared with 2 pi T_i. The form is cited from memory, unverified; at
    one gap it is the Maxwell stress of `MaxwellStressInGap`. A `power` of 4/3 corrects it towards contacts that were solved:
    `electrovib.equilibrium` states the gaps of a `FittedSurface` in this form.
    """

    reference: ClassVar[str] = "doi:10.1063/1.5024038, doi:10.1088/1361-648x/abe797"
    status: ClassVar[str] = "unverified"
    equation: ClassVar[Mapping[str, str]] = {"pressure": "eps0*E**2/2"}
    evaluation_surface: ClassVar[str] = "rough gap"
    replaces: ClassVar[tuple[str, ...]] = ("gap",)
    example: ClassVar[Mapping[str, Any]] = {"mean_gap": 10e-6, "rms_gap": 5e-6}

    mean_gap: Annotated[Number, Quantity("m", 0, 1e-2, "mean of the Gaussian of the gaps under load")]
    rms_gap: Annotated[Number, Quantity("m", 1e-10, 1e-2, "standard deviation of the gaps under load")]
    spots: ContactSpots = PullingSpots()
    power: Annotated[
        Number, Quantity("1", 1, 2, "power of the Gaussian that the gaps follow; 1 is the Gaussian itself")
    ] = 1.0

    def gaps(self) -> GaussianGaps:
        """Return the distribution of the gaps."""
        return GaussianGaps(mean=self.mean_gap, rms=self.rms_gap, power=self.power)

    def amplitudes(self, section: Section) -> dict[str, Linear]:
        """Return the field at each gap of the average times the root of its share of the area."""
        from electrovib.solve.stack.section import field_in_gap, fields_in_gaps

        _refuse_a_gap(section, self.replaces)
        layers = {name: section[name] for name in section.names}
        gaps, shares = self.gaps().rule(_near(layers), count=COUNT, reach=EXTENT)
        fields = {
            f"gap_{index:02d}": field * np.sqrt(shares[..., index])
            for index, field in enumerate(fields_in_gaps(section, gaps))
        }
        phi, leak = self.gaps().contact_fraction, self.spots.leak
        if leak is not None and np.any(phi > 0):
            touching = TOUCHING * _near(layers)
            at_spots = field_in_gap(section, thickness=touching, conductivity=leak)
            fields["spots"] = at_spots * np.sqrt(phi)
        return fields

    def pressure(self, **E: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the attraction per area [Pa], summed over the fields [V/m] of all gaps, each times the root of its share."""
        parts = [eps0 * np.asarray(field, dtype=float) ** 2 / 2 for field in E.values()]
        total: NDArray[np.float64] = sum(parts[1:], start=parts[0])
        return total

    def diagnostics(self, layers: Mapping[str, Layer]) -> tuple[Diagnostic, ...]:
        """Return diagnostics of contact spots, the form of the distribution, the wavelength of the roughness, and the voltage."""
        return (self._carried_by(layers), self._form(), _wavelengths(layers), _voltage())

    def _form(self) -> Diagnostic:
        """Return how much a distribution of this form attracts beside contacts that were solved."""
        text = f"gaps that follow a power of {self.power:.3g} of a Gaussian were not compared with contacts solved"
        if self.power == 1:
            text = (
                "Gaussian gaps with mean gap and contact share of a contact that was solved attract 0.7 to 1 times as much"
                " (median 0.88), less where fewer places touch; force.power = 1.333 corrects that within 15 % where 1 % touches"
            )
        elif math.isclose(self.power, 4 / 3, rel_tol=1e-2):
            return Diagnostic(
                "form of the gaps", "ok", f"force.power = {self.power:.4g} is that of contacts solved"
            )
        return Diagnostic("form of the gaps", "unknown", text)

    def _carried_by(self, layers: Mapping[str, Layer]) -> Diagnostic:
        pull = mean_pull(1.0, electrical_thickness=_near(layers), gaps=self.gaps(), spots=PullingSpots())
        share = float(pull.spots / pull.total)
        carried = share > 0.5 and self.spots.leak is not None
        text = (
            f"{100 * self.gaps().contact_fraction:.3g} % of the area touches; if those spots insulate, they carry"
            f" {100 * share:.3g} % of the pull (force.spots is {type(self.spots).__name__})"
        )
        return Diagnostic("contact spots", "warning" if carried else "ok", text)


def _refuse_a_gap(section: Section, replaced: tuple[str, ...]) -> None:
    for name in replaced:
        if name in section.names:
            raise InputError(
                f"stack.{name}: the gaps of Persson2018RoughGap are force.mean_gap and force.rms_gap; omit the layer,"
                " or use force.model = MaxwellStressInGap, which has one gap"
            )


def _near(layers: Mapping[str, Any]) -> Any:
    """Return the electrical thickness of the layers that do not conduct [m], over which the field changes near contact."""
    near = sum(
        layer.thickness
        / abs(layer.material.bound_permittivity(SCALE_FREQUENCY))
        * (np.asarray(layer.material.conductivity) == 0)
        for layer in layers.values()
    )
    if np.any(near == 0):
        raise InputError(
            "stack: every layer conducts, so the field of a constant voltage grows without bound where skin and plate touch;"
            " Persson2018RoughGap needs a layer whose material has conductivity 0"
        )
    return near


def _wavelengths(layers: Mapping[str, Layer]) -> Diagnostic:
    blocking = [layer for layer in layers.values() if layer.material.conductivity == 0]
    roles = roles_of(layers)
    film = sum(layer.thickness for name, layer in layers.items() if roles[name] == "plate")
    length = 2 * math.pi * (film or sum(layer.thickness for layer in blocking))
    state = "warning" if length > PRINT_PERIOD else "unknown"
    text = (
        "an average over local gaps is valid only if the wavelengths of the roughness are long compared with 2 pi T_i ="
        f" {format_quantity(length, 'm', digits=3)}; the period of a fingerprint is {format_quantity(PRINT_PERIOD, 'm')}"
    )
    return Diagnostic("roughness wavelength", state, text)


def _voltage() -> Diagnostic:
    text = (
        "the voltage is that of the layers without a gap; with rough skin a series impedance takes less of it"
    )
    return Diagnostic("stack voltage", "unknown", text)


COATING = 0.378e-6
"""Electrical thickness [m] of 1 um of permittivity 3.9 under 200 um of skin of 1650 (cited from memory, unverified)."""


def over_the_mean_gap(*, electrical_thickness: float, rms: float, in_rms: float) -> float:
    """Return the averaged pull, contact spots included, over the pull at the mean gap of `in_rms` rms gaps; lengths in m."""
    gaps = GaussianGaps(mean=in_rms * rms, rms=rms)
    pull = mean_pull(1.0, electrical_thickness=electrical_thickness, gaps=gaps, spots=PullingSpots())
    alone = local_pull(1.0, electrical_thickness=electrical_thickness, gap=gaps.mean)
    return float(pull.total / alone)


def sine_pull(*, amplitude: float, gap: float) -> float:
    """Return the mean pull [Pa] of a sine of this amplitude [V] on the coating at one gap [m]."""
    return float(local_pull(amplitude / math.sqrt(2), electrical_thickness=COATING, gap=gap))


CHECKS = PAPER.checks(sine_pull, over_the_mean_gap)
