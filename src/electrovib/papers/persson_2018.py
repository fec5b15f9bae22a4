"""B. N. J. Persson, "The dependency of adhesion and friction on electrostatic attraction", 2018.

Journal of Chemical Physics 148, 144701; extended in "General theory of electroadhesion", 2021.

Claims: a mean-field theory of electrostatic attraction between rough elastic solids, with and without an
insulating layer between the conductors; with a layer, under a small nominal pressure, contact area and friction
rise sharply at a critical voltage. The later paper takes layers of finite conductivity and reduces to this one.
Does not claim: that one equivalent gap can stand for the distribution of gaps; numbers of a finger that could
be read here. Only the abstracts were read: the stress at one gap is that of plates in series, the paper's
distribution of gaps, contact and attraction found together, is not in this law, which takes a Gaussian.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Mapping
from typing import Annotated, Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from electrovib.core.checks import Check
from electrovib.core.constants import eps0
from electrovib.core.diagnostics import Diagnostic
from electrovib.core.errors import InputError
from electrovib.core.quantity import Number, Quantity
from electrovib.core.units import format_quantity
from electrovib.physics.force import ForceLaw
from electrovib.physics.roughness import (
    ContactSpots,
    GaussianGaps,
    PullingSpots,
    local_pull,
    mean_pull,
)
from electrovib.physics.stack import Layer, Linear, Section
from electrovib.scenario import Scenario, preset, sourced
from electrovib.solve.stack.extra_gap import field_in_gap

CITATION = (
    "B. N. J. Persson, The dependency of adhesion and friction on electrostatic attraction, J. Chem. Phys. 148, 144701"
    " (2018), doi:10.1063/1.5024038 (abstract); B. N. J. Persson, General theory of electroadhesion, J. Phys.: Condens."
    " Matter 33, 435001 (2021), doi:10.1088/1361-648x/abe797 (abstract)"
)
STATUS = "abstract"
NOT_READ = (
    "the paper's own distribution of gaps under load and attraction, solved together with the contact area: the law here"
    " takes a Gaussian whose mean and rms the user gives"
)
DEFECTS = (
    "Persson 2018 against one equivalent gap: averaged over gaps with its contact part, the pull on a coating of 1 um is 4.5"
    " to 571 times that at the mean gap for rms gaps of 5 to 22 um and mean gaps of 1 to 3 rms, and half to nearly all of it"
    " comes from where skin and coating touch. On a film of 90 um it is 1.0 to 1.4 times. A law with one gap states neither.",
)

COUNT, EXTENT = 32, 5.5
"""Gaps of the law's average and rms gaps they reach from the mean: 2e-4 of the pull at worst."""
TOUCHING = 1e-9
"""Gap at a spot that touches, over the thinnest layer: its finite size changes the pull by less than 1e-7."""
SCALE_FREQUENCY = 1.0
"""Where the electrical thickness is taken that places the gaps of the average [Hz]."""
PRINT_PERIOD = 0.45e-3
"""Distance of the ridges of a fingerprint [m]."""


class Persson2018RoughGap(ForceLaw):
    """Attraction of a rough skin: the pull of every local gap, averaged, with the spots that touch.

    Notes
    -----
    <p> = eps0/2 [phi E(0)^2 + integral over u > 0 of P(u) E(u)^2 du], E(u) = V/(u + h0), h0 = sum T/eps* over
    the layers, P a Gaussian of `mean_gap` and `rms_gap`, phi = A_real/A0 what of it lies at or below 0. Each
    amplitude is the field at one gap times the root of its share. The fields are those of the layers in series
    with that gap, exact in time and in frequency for layers as declared, dispersive or conducting; the average
    takes 32 gaps, within 2e-4.

    The distribution replaces the layer ``gap``, which the stack must not have, and at least one layer must not
    conduct. V is the voltage of the stack without a gap: what is in series takes more of it than behind rough
    skin, so keep the body grounded and resistance times capacitance of the layers short. Valid for roughness
    long along the surface against 2 pi T_i. The form is cited from memory, unverified; at one gap it is the Maxwell
    stress of `MaxwellStressInGap`.
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

    def gaps(self) -> GaussianGaps:
        """Give the distribution of the gaps."""
        return GaussianGaps(mean=self.mean_gap, rms=self.rms_gap)

    def amplitudes(self, section: Section) -> dict[str, Linear]:
        """Give the field at each gap of the average times the root of its share of the area."""
        _refuse_a_gap(section, self.replaces)
        layers = {name: section[name] for name in section.names}
        gaps, shares = self.gaps().rule(_near(layers), count=COUNT, reach=EXTENT)
        fields = {
            f"gap_{index:02d}": field_in_gap(section, thickness=float(gap)) * math.sqrt(share)
            for index, (gap, share) in enumerate(zip(gaps, shares, strict=True))
        }
        phi, leak = self.gaps().contact_fraction, self.spots.leak
        if leak is not None and phi > 0:
            touching = TOUCHING * min(layer.thickness for layer in layers.values())
            at_spots = field_in_gap(section, thickness=touching, conductivity=leak)
            fields["spots"] = at_spots * math.sqrt(phi)
        return fields

    def pressure(self, **E: NDArray[np.float64]) -> NDArray[np.float64]:
        """Attraction per area, summed over the fields [V/m] of all gaps, each times the root of its share."""
        parts = [eps0 * np.asarray(field, dtype=float) ** 2 / 2 for field in E.values()]
        total: NDArray[np.float64] = sum(parts[1:], start=parts[0])
        return total

    def diagnostics(self, layers: Mapping[str, Layer]) -> tuple[Diagnostic, ...]:
        """Say what carries the pull, how rough the skin may be, and which voltage is meant."""
        return (self._carried_by(layers), _wavelengths(layers), _voltage())

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
                f"stack.{name}: the gaps of Persson2018RoughGap are force.mean_gap and force.rms_gap; take the layer away,"
                " or use force.model = MaxwellStressInGap, which has one gap"
            )


def _near(layers: Mapping[str, Any]) -> float:
    """Electrical thickness of what does not conduct [m]: over it the field changes near contact."""
    blocking = [layer for layer in layers.values() if layer.material.conductivity == 0]
    if not blocking:
        raise InputError(
            "stack: every layer conducts, so where skin and plate touch the field of a held voltage grows without bound;"
            " Persson2018RoughGap needs a layer whose material has conductivity 0"
        )
    parts = [layer.thickness / abs(layer.material.bound_permittivity(SCALE_FREQUENCY)) for layer in blocking]
    return float(sum(parts))


def _wavelengths(layers: Mapping[str, Layer]) -> Diagnostic:
    blocking = [layer for layer in layers.values() if layer.material.conductivity == 0]
    length = 2 * math.pi * layers.get("insulator", blocking[0]).thickness
    state = "warning" if length > PRINT_PERIOD else "unknown"
    text = (
        "gaps count one by one only if the roughness is long along the surface against 2 pi T_i ="
        f" {format_quantity(length, 'm', digits=3)}; a print repeats after {format_quantity(PRINT_PERIOD, 'm')}"
    )
    return Diagnostic("roughness wavelength", state, text)


def _voltage() -> Diagnostic:
    text = "the voltage is that of the layers without a gap: a series impedance takes less of it behind rough skin"
    return Diagnostic("stack voltage", "unknown", text)


COATING, FILM = 0.378e-6, 27e-6
"""Electrical thickness [m]: 1 um of 3.9 and 200 um of skin of 1650, cited from memory, unverified; film of Vezzoli et al."""


def over_the_mean_gap(*, electrical_thickness: float, rms: float, in_rms: float) -> float:
    """Averaged pull, spots pulling, over the pull at the mean gap, which is `in_rms` rms gaps; lengths in m."""
    gaps = GaussianGaps(mean=in_rms * rms, rms=rms)
    pull = mean_pull(1.0, electrical_thickness=electrical_thickness, gaps=gaps, spots=PullingSpots())
    alone = local_pull(1.0, electrical_thickness=electrical_thickness, gap=gaps.mean)
    return float(pull.total / alone)


def sine_pull(*, amplitude: float, gap: float) -> float:
    """Mean pull of a sine on the coating at one gap [Pa], from volts and metres."""
    return float(local_pull(amplitude / math.sqrt(2), electrical_thickness=COATING, gap=gap))


_APART = "computed apart from this code by adaptive quadrature"
_SERIES = "plates in series with recalled inputs, computed apart from this code"


def _derived(name: str, expect: float, rtol: float, source: str, compute: Callable[[], float]) -> Check:
    return Check(name, expect=expect, rtol=rtol, source=source, compute=compute, status="derived")


def _ratio(electrical: float, rms: float, in_rms: float, expect: float) -> Check:
    where = "coating" if electrical == COATING else "film"
    return _derived(
        f"pull over that at the mean gap, {where}, rms {rms * 1e6:g} um, mean {in_rms:g} rms",
        expect,
        1.2e-2,  # two digits
        _APART,
        lambda: over_the_mean_gap(electrical_thickness=electrical, rms=rms, in_rms=in_rms),
    )


CHECKS = (
    _derived(
        "pull at 100 V, no gap", 155e3, 1e-3, _SERIES, functools.partial(sine_pull, amplitude=100.0, gap=0.0)
    ),
    _derived(
        "pull at 100 V, 3 um", 1.94e3, 2e-3, _SERIES, functools.partial(sine_pull, amplitude=100.0, gap=3e-6)
    ),
    _derived(
        "pull at 100 V, 10 um", 206.0, 3e-3, _SERIES, functools.partial(sine_pull, amplitude=100.0, gap=1e-5)
    ),
    _ratio(COATING, 5e-6, 1, 36),
    _ratio(COATING, 5e-6, 2, 22),
    _ratio(COATING, 5e-6, 3, 4.5),
    _ratio(COATING, 22e-6, 1, 571),
    _ratio(COATING, 22e-6, 2, 329),
    _ratio(COATING, 22e-6, 3, 46),
    _ratio(FILM, 22e-6, 1, 1.4),
)

_UNVERIFIED = "recalled as the touch screen of this line of papers, not read"
_CHOICE = "not read; a choice"


FORMER_NAMES = {"coat": "coating"}
"""What its scenarios were called in files written earlier, and what they are called now."""


def scenarios() -> dict[str, Scenario]:
    """Give a rough finger on a coated screen; no value of it was read in the paper.

    Returns
    -------
    dict of str to Scenario
        ``coating``.
    """
    coating = preset(
        title="Rough finger on a coated touch screen: recalled screen, gaps of a choice",
        changes={
            "drive": {"model": "Sine", "amplitude": 100.0, "frequency": 125.0},
            "time.initial_state.model": "PeriodicState",
            "force": {"model": "Persson2018RoughGap", "mean_gap": 10e-6, "rms_gap": 5e-6},
            "stack.insulator": {"thickness": 1e-6, "material": {"model": "Constant", "permittivity": 3.9}},
            "stack.stratum_corneum.material": {"model": "Constant", "permittivity": 1650.0},
        },
        unchanged=_CHOICE,
    )
    return {"coating": sourced(coating, {"": _CHOICE, "stack": _UNVERIFIED, "time": ""})}
