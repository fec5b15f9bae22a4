"""Roughness and modulus of a contact from its capacitance over the load, so that its forces are predicted."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar, Final

import numpy as np
from numpy.typing import ArrayLike

from electrovib.core.answer import Answer, Curve, Document, Panel, Table
from electrovib.core.arrays import Real
from electrovib.core.budget import one_thread
from electrovib.core.diagnostics import Diagnostic, reasons
from electrovib.core.errors import InputError
from electrovib.data.atomic import Form, csv_text
from electrovib.physics.half_space import Coated, Elastic
from electrovib.physics.limits import held_voltages
from electrovib.physics.roughness import ContactSpots, PullingSpots, share_of_field
from electrovib.physics.topography import MeasuredHeights, SelfAffine
from electrovib.recordings.fit.contact_draws import (
    FREE,
    REDUCED_LOADS,
    ContactPrediction,
    FittedDraw,
    best_contact,
    intervals,
    over_draws,
    shown,
    solved,
    with_modulus,
    with_rms,
)
from electrovib.recordings.interval import Interval
from electrovib.scenario import Scenario, Source, read_scenario
from electrovib.solve.diagnostics.judge import declared_diagnostics
from electrovib.solve.equilibrium.of_scenario import closed_diagnostics
from electrovib.solve.rough_contact import refuse_beyond_budget
from electrovib.solve.stack.blocking import BlockingStack, uniform_stack

FEWEST: Final = 3
MOST_DRAWS: Final = 32


@dataclass(frozen=True, kw_only=True, repr=False)
class ContactFit(Answer):
    """Roughness and body of a contact, whose capacitances over the load agree best with measured ones.

    Parameters
    ----------
    draws : tuple of FittedDraw
        Of each draw of the phases its ``seed``, the ``roughness``, that which was declared with the fitted rms height, and the
        ``body``, that which was declared with the fitted modulus. All agree with the capacitances; forces are predicted with
        each. A measured map is one draw.
    free : tuple of str
        Which of ``"rms"`` and ``"modulus"`` were fitted.
    rms, modulus : Interval
        Rms height [m] and Young's modulus [Pa], of a coated body that of its film, with 95 % intervals; of several draws the
        geometric mean. One that was not fitted is as it was declared.
    load, capacitance, fitted : ndarray, shape (n,)
        Loads [N] in rising order, measured and fitted capacitances [F], the latter of the first draw.
    scatter : float
        Standard deviation of the logarithm of measured over fitted capacitances [1], of the first draw.
    scenario : Scenario
        Area and layers of the capacitance.
    points : int or None
        Points along a side of the grid, None for as few as the shortest wave takes.
    diagnostics : tuple of Diagnostic
        Of what the scenario declares.
    """

    FILES: ClassVar = {"contact.csv": Form.TABLE}
    draws: tuple[FittedDraw, ...]
    free: tuple[str, ...]
    rms: Interval
    modulus: Interval
    load: Real
    capacitance: Real
    fitted: Real
    scatter: float
    scenario: Scenario
    points: int | None
    diagnostics: tuple[Diagnostic, ...]

    @property
    def roughness(self) -> SelfAffine | MeasuredHeights:
        """Roughness of the first draw."""
        return self.draws[0].roughness

    @property
    def body(self) -> Elastic | Coated:
        """Body of the first draw."""
        return self.draws[0].body

    def predict(
        self,
        *,
        voltage: ArrayLike,
        load: float | None = None,
        measured: ArrayLike | None = None,
        spots: ContactSpots | None = None,
        frequency: float = 0.0,
    ) -> ContactPrediction:
        """Predict the attraction over voltage, with every draw of the phases and without a free number.

        Parameters
        ----------
        voltage : array_like, shape (n,)
            Constant voltages [V] that the contact goes through in this order, not 0; for a fast sine the root mean square.
        load : float, optional
            Load [N] above 0; that of the scenario if absent.
        measured : array_like, shape (n,), optional
            Measured attraction at each voltage [N], with which the prediction is compared.
        spots : ContactSpots, optional
            Field where faces touch, as for `rough_contact`: `PullingSpots`, the default, `LeakingSpots` or `IdleSpots`.
        frequency : float, optional
            Of a sine whose root mean square the voltages are [Hz], as there.

        Returns
        -------
        ContactPrediction
            The force at each voltage by each draw, and how far it is from the measured one.

        Raises
        ------
        InputError
            If a voltage is 0 or beyond 1 MV, a measured force is not above 0, or the contacts are beyond the budget.
        ElectrovibError
            If a contact does not come to rest, which the message explains.

        Notes
        -----
        Each draw is solved as `electrovib.rough_contact` does, on one grid. What spots do is declared here and not for the fit:
        a closed gap has no impedance, whatever they are. Limits are not judged before the force is predicted, as nothing is
        played; films, air and declared limits are in the diagnostics.
        """
        changes = {} if load is None else {"load.normal_force": load}
        known = self.scenario.replace(changes)
        stack = uniform_stack(known)
        voltages = held_voltages(voltage)
        seen = None if measured is None else np.atleast_1d(np.asarray(measured, dtype=float))
        _check_prediction(stack, voltages, seen)
        share = share_of_field(spots or PullingSpots(), frequency)
        shape = self.roughness.shape(self.points)
        refuse_beyond_budget(
            math.isqrt(math.prod(shape)), len(self.draws) * voltages.size, kept=voltages.size
        )
        found = [each.attractions(stack, voltages.tolist(), shape, share) for each in self.draws]
        return ContactPrediction(
            stack=stack,
            voltage=voltages,
            forces=stack.area * np.array([pulls for pulls, _ in found]),
            measured=seen,
            field_share=share,
            diagnostics=closed_diagnostics(
                known,
                stack,
                voltage=float(np.abs(voltages).max()),
                widest=max(widest for _, widest in found),
            ),
        )

    @property
    def document(self) -> Document:
        """Both numbers with their intervals, a row for each load, and the capacitance over the load."""
        columns = zip(self.load, self.capacitance, self.fitted, strict=True)
        rows = [
            (shown(load, "N"), shown(measured, "F"), shown(fitted, "F"), f"{measured / fitted:.3f}")
            for load, measured, fitted in columns
        ]
        return Document(
            title="A rough contact from its capacitance over the load",
            sentences=[
                self._number("rms", self.rms, "rms height of the roughness", "m"),
                self._number("modulus", self.modulus, "Young's modulus", "Pa"),
                f"the capacitances scatter by {100 * self.scatter:.2g} % about those of this contact",
            ],
            numbers=[Table("", ("load", "measured", "fitted", "measured over fitted"), tuple(rows))],
            diagnostics=self.diagnostics,
            figures=[
                Panel(
                    id="capacitance", title="Capacitance over the load", x=("load", "N"), y=("capacitance", "F"), log_x=True,
                    caption="Measured, and of the rough contact with the fitted rms height and modulus.",
                    curves=(
                        Curve(label="measured", x=self.load, y=self.capacitance, kind="points"),
                        Curve(label="fitted", x=self.load, y=self.fitted),
                    ),
                )
            ],
            remarks=[
                "the intervals are those of the declared body and roughness; loads of one run that err together make them wider",
                self._places(),
                *reasons(self.diagnostics),
            ],
        )  # fmt: skip

    def _number(self, name: str, found: Interval, words: str, unit: str) -> str:
        return f"{words} {found.in_words(unit) if name in self.free else f'{shown(found.value, unit)}, as declared'}"

    def _places(self) -> str:
        """Say how far the intervals hold for other places of the surface."""
        if isinstance(self.roughness, MeasuredHeights):
            return "the map is one place of the surface, and others give other numbers, which the intervals do not include"
        count = len(self.draws)
        return "the phases of the roughness are not known. " + (
            f"The intervals include what {count} draws of them differ by"
            if count > 1
            else "The intervals are those of one draw of them, and others give other numbers: ask for more draws"
        )

    def content(self, name: str) -> str:
        """Write loads, measured and fitted capacitances as CSV, in SI, below both numbers with their intervals."""
        del name
        rows = np.column_stack([self.load, self.capacitance, self.fitted]).tolist()
        return csv_text(("load", "capacitance", "fitted"), rows, remarks=self.document.sentences)


@one_thread(with_scipy=True)
def fit_contact(
    scenario: Source,
    *,
    load: ArrayLike,
    capacitance: ArrayLike,
    roughness: SelfAffine | MeasuredHeights,
    body: Elastic | Coated,
    free: Sequence[str] | None = None,
    points: int | None = None,
    draws: int | None = None,
    seed: int = 0,
) -> ContactFit:
    """Find rms height and modulus of a rough contact from its capacitance over the load.

    Parameters
    ----------
    scenario : str, Path, mapping, Scenario or xarray.Dataset
        As for `rough_contact`: contact area, and a stack with a gap that does not conduct. Load, drive and the thickness of the
        gap have no effect.
    load : array_like, shape (n,)
        Loads [N] above 0 at which the capacitance was measured, at least 3.
    capacitance : array_like, shape (n,)
        Capacitance of the contact at each [F], measured with a voltage that does not attract, without that of the leads;
        `contact_capacitance` gives it of an impedance.
    roughness : SelfAffine or MeasuredHeights
        Shape of the roughness of both faces together. The search begins with its rms height.
    body : Elastic or Coated
        What is bent. The search begins with its modulus; those of film and half-space keep their ratio.
    free : sequence of str, optional
        What is fitted of ``"rms"``, the rms height, and ``"modulus"``: by default both of a spectrum, and of a measured map the
        modulus alone. With ``"rms"`` a map is scaled.
    points : int, optional
        Points along a side of the grid, as for `rough_contact`.
    draws : int, optional
        Draws of the random phases of a spectrum, at most 32, each with a fit of its own: the intervals include what they
        differ by. With one they are too narrow. By default 4; a measured map has none.
    seed : int, optional
        Of the phases of the first draw; the others have the seeds that follow.

    Returns
    -------
    ContactFit
        The intervals of both numbers; roughness and body of each draw, which `rough_contact` takes; and `predict`, the force at
        other voltages.

    Raises
    ------
    InputError
        If a capacitance is above that of the layers alone, the data do not determine both numbers, the contacts are beyond the
        budget, or the scenario is one that `rough_contact` refuses.

    Notes
    -----
    Least squares of the logarithms, so that errors are taken as proportional to the capacitance. The capacitance is
    eps0 A mean(1/(g + K)) with the local gap g and the electrical thickness K of the layers. Gaps of 31 contacts are
    interpolated over the logarithm of the load, to 2 % of both numbers. Forces predicted from the contact depend on the
    ratios of the wavelengths alone; of a film's thickness to them too. Between draws the variance of a logarithm is
    s^2 (1 + 1/n), as the real contact is one draw more, to which that of the noise is added; Student's t has the degrees of
    freedom of Welch and Satterthwaite.

    Examples
    --------
    >>> rough = ev.SelfAffine(rms=2e-6, hurst=0.8, longest=1e-3, roll_off=2.5e-4, shortest=2.5e-4)
    >>> found = ev.fit_contact(
    ...     "bau_2010/sine", roughness=rough, body=ev.Elastic(modulus=1e6), load=[0.1, 0.3, 1.0, 3.0],
    ...     capacitance=[255e-12, 280e-12, 330e-12, 420e-12],
    ... )
    >>> found.predict(voltage=[25.0, 50.0]).forces.shape
    (4, 2)
    """
    known = read_scenario(scenario)
    stack = uniform_stack(known)
    loads, measured = _points(load, capacitance, stack)
    fitted = _free(roughness, free)
    shape, count = roughness.shape(points), _draws(roughness, draws)
    refuse_beyond_budget(math.isqrt(math.prod(shape)), count * REDUCED_LOADS.size)
    estimates, values, found = [], [], []
    for each in range(seed, seed + count):
        table = solved(roughness, body, shape, each)
        estimate, curve = best_contact(loads, measured, stack, table, roughness, body, fitted)
        rms, modulus = intervals(estimate, body, roughness)
        found.append(FittedDraw(each, with_rms(roughness, rms.value), with_modulus(body, modulus.value)))
        estimates.append((estimate, rms, modulus))
        values.append(curve)
    freedom = loads.size - len(fitted)
    return ContactFit(
        draws=tuple(found),
        free=fitted,
        rms=over_draws([rms for _, rms, _ in estimates], freedom),
        modulus=over_draws([modulus for *_, modulus in estimates], freedom),
        load=loads,
        capacitance=measured,
        fitted=values[0],
        scatter=math.sqrt(estimates[0][0].variance),
        scenario=known,
        points=points,
        diagnostics=tuple(declared_diagnostics(known)),
    )


def _free(roughness: SelfAffine | MeasuredHeights, asked: Sequence[str] | None) -> tuple[str, ...]:
    """Return what is fitted, in the order of `FREE`."""
    if asked is None:
        return FREE[1:] if isinstance(roughness, MeasuredHeights) else FREE
    if isinstance(asked, str) or not asked or not set(asked) <= set(FREE):
        raise InputError(f"free = {asked!r}: expected one or both of {', '.join(FREE)}")
    return tuple(name for name in FREE if name in asked)


def _draws(roughness: SelfAffine | MeasuredHeights, asked: int | None) -> int:
    """Return how many draws of the phases are fitted: a measured map is one."""
    if isinstance(roughness, MeasuredHeights):
        if asked not in (None, 1):
            raise InputError(f"draws = {asked}: a measured map has no phases that are drawn; omit them")
        return 1
    count = 4 if asked is None else asked
    if not 1 <= count <= MOST_DRAWS:
        raise InputError(f"draws = {count}: expected 1 to {MOST_DRAWS}, for instance 4")
    return count


def _check_prediction(stack: BlockingStack, voltages: Real, measured: Real | None) -> None:
    """Refuse voltages and measured forces that have no logarithm, and a contact without a load."""
    if not stack.pressure > 0:
        raise InputError(
            "load.normal_force = 0: a rough contact rests under a load; give for instance load=0.5"
        )
    if not voltages.all():
        raise InputError(
            f"voltage = {voltages.tolist()}: 0 V attracts nothing; expected voltages other than 0"
        )
    if measured is not None and (measured.shape != voltages.shape or not (measured > 0).all()):
        raise InputError(
            f"measured = {measured.tolist()}: expected a force above 0 for each of the {voltages.size} voltages; omit voltages"
            " without one"
        )


def _points(load: ArrayLike, capacitance: ArrayLike, stack: BlockingStack) -> tuple[Real, Real]:
    """Return loads in rising order and their capacitances, of at least three points, each below that without a gap."""
    loads, measured = (np.asarray(each, dtype=float) for each in (load, capacitance))
    if loads.ndim != 1 or loads.shape != measured.shape or loads.size < FEWEST:
        raise InputError(
            f"load, capacitance: expected two rows of the same length, at least {FEWEST}, not of the shapes {loads.shape} and"
            f" {measured.shape}"
        )
    for name, values, unit in (("load", loads, "N"), ("capacitance", measured, "F")):
        if wrong := [each for each in values.tolist() if not 0 < each < math.inf]:
            raise InputError(
                f"{name}: {wrong[0]:g} {unit} is not finite and above 0; omit the point, or subtract the zero"
            )
    closed = stack.capacitance(0.0)
    if measured.max() >= closed:
        raise InputError(
            f"capacitance: {shown(measured.max(), 'F')} is not below {shown(closed, 'F')}, that of {', '.join(stack.blocking)}"
            f" on {shown(stack.area, 'm2')} without a gap; check contact.area and stack, and subtract the leads"
        )
    order = np.argsort(loads)
    return loads[order], measured[order]
