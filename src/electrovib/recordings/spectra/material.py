"""A dispersion fitted to a measured spectrum, its form chosen by criterion, with outliers named."""

from __future__ import annotations

import contextlib
import functools
import itertools
import math
import re
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from electrovib.core.constants import eps0
from electrovib.core.errors import ElectrovibError, InputError, nearest, refuse
from electrovib.core.paths import with_numbers
from electrovib.physics.kramers_kronig import kramers_kronig_residual
from electrovib.physics.material import ColeCole, Constant, ConstantPhase, Debye, HavriliakNegami, Prony
from electrovib.recordings.fit.identifiability import Stall
from electrovib.recordings.fit.least_squares import MOST_EVALUATIONS, FreeParameter, least_squares
from electrovib.recordings.interval import rough_noise
from electrovib.solve.population.columns import with_columns

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence

    from numpy.typing import ArrayLike, NDArray

    from electrovib.core.arrays import Complex, Real
    from electrovib.physics.material import Material
    from electrovib.recordings.fit.least_squares import LeastSquaresEstimate


_PLACES: Final = 5
"""Relaxation times, evenly on a logarithmic scale over the band, at which a search begins."""


def _levels(frequency: Real, permittivity: Complex) -> tuple[float, float, float]:
    """Relative permittivity at both ends of the band, and the least conductivity [S/m]."""
    order = np.argsort(frequency)
    real = permittivity.real[order]
    conductivity = -permittivity.imag * 2 * math.pi * frequency * eps0
    return max(float(real[-1]), 1.0), max(float(real[0]), 1.0), max(float(conductivity.min()), 1e-15)


def _times(frequency: Real) -> Real:
    shortest = 1 / (2 * math.pi * float(frequency.max()) * 3)
    longest = 1 / (2 * math.pi * float(frequency.min()) / 3)
    return np.geomspace(shortest, longest, _PLACES)


def _constant(frequency: Real, permittivity: Complex) -> Iterator[Material]:
    """A dielectric without dispersion, with the median of the permittivity and of the conductivity."""
    conductivity = -permittivity.imag * 2 * math.pi * frequency * eps0
    level = max(float(np.median(permittivity.real)), 1.0)
    yield Constant(permittivity=level, conductivity=max(float(np.median(conductivity)), 1e-15))


def _constant_phase(frequency: Real, permittivity: Complex) -> Iterator[Material]:
    """A power law, from the slope of the permittivity over the band."""
    middle = math.exp(float(np.mean(np.log(frequency))))
    slope = float(np.polyfit(np.log(frequency), np.log(np.maximum(permittivity.real, 1.0)), 1)[0])
    at_middle = float(np.exp(np.mean(np.log(np.maximum(permittivity.real, 1.0)))))
    least = _levels(frequency, permittivity)[2]
    for exponent in {min(max(1 + slope, 0.1), 0.99), 0.5, 0.8}:
        yield ConstantPhase(
            permittivity=at_middle, reference_frequency=middle, exponent=exponent, conductivity=least / 2
        )


_EACH: Final = functools.partial(itertools.combinations, r=1)
"""Every time by itself."""


def _relaxing(
    kind: type[Debye | HavriliakNegami | ColeCole | Prony],
    sets: Callable[[Real], Iterable[Any]],
    *,
    high: float = 1.0,
    **shape: float,
) -> Callable[[Real, Complex], Iterator[Material]]:
    """Make relaxations of equal strength, begun at `sets` of times, with a part of the permittivity at the highest frequency."""

    def starts(frequency: Real, permittivity: Complex) -> Iterator[Material]:
        above, below, least = _levels(frequency, permittivity)
        for times in sets(_times(frequency)):
            strength = max(below - above, 0.1 * above) / len(times)
            terms = [{"strength": strength, "relaxation_time": float(time), **shape} for time in times]
            own: dict[str, Any] = {"terms": terms} if "terms" in kind.model_fields else terms[0]
            yield kind(permittivity_high=max(above * high, 1.0), conductivity=least / 2, **own)

    return starts


def _cole_cole(count: int) -> Callable[[Real, Complex], Iterator[Material]]:
    """Make the sum of so many broadened relaxations, begun at several times."""
    return _relaxing(ColeCole, functools.partial(itertools.combinations, r=count), high=0.5, broadening=0.2)


def _prony(count: int) -> Callable[[Real, Complex], Iterator[Material]]:
    """Make the sum of so many relaxations of one time each, begun with times evenly over the band."""
    ends = (1.0, 3.0)
    return _relaxing(
        Prony, lambda band: (np.geomspace(band[0] * each, band[-1] / each, count) for each in ends)
    )


FORMS: Final[dict[str, Callable[[Real, Complex], Iterator[Material]]]] = {
    "Constant": _constant,
    "ConstantPhase": _constant_phase,
    "Debye": _relaxing(Debye, _EACH),
    "ColeCole, 1 term": _cole_cole(1),
    "ColeCole, 2 terms": _cole_cole(2),
    "HavriliakNegami": _relaxing(HavriliakNegami, _EACH, high=0.5, broadness=0.8, skewness=0.8),
    "ColeCole, 3 terms": _cole_cole(3),
    "ColeCole, 4 terms": _cole_cole(4),
    "Prony, 2 terms": _prony(2),
    "Prony, 3 terms": _prony(3),
    "Prony, 4 terms": _prony(4),
    "Prony, 6 terms": _prony(6),
}
"""Name to initial values; the search keeps the best of them."""
OFFERED: Final = tuple(FORMS)[:6]
"""Forms among which the criterion chooses unless others are named."""


GABRIEL: Final = "gabriel"


def short_name(form: str) -> str:
    """Return the name of a form at the command line, such as ``cole-cole-2``."""
    name, _, terms = form.partition(", ")
    return "-".join(
        filter(None, [re.sub(r"(?<=[a-z])(?=[A-Z])", "-", name).lower(), terms.partition(" ")[0]])
    )


def forms_of(name: str) -> tuple[str, ...]:
    """Return the names among `FORMS` that a short name stands for, between which the criterion of Akaike decides.

    It is ``auto``, the name of a form such as ``cole-cole``, with any number of terms, that with a number of
    terms such as ``cole-cole-2``, or ``gabriel`` for four Cole-Cole terms.
    """
    known: dict[str, tuple[str, ...]] = {"auto": OFFERED}
    for form in FORMS:
        short = short_name(form)
        of_any = short.rstrip("-0123456789")
        known[of_any] = (*known.get(of_any, ()), form)
        known.setdefault(short, (form,))
    known[GABRIEL] = known["cole-cole-4"]
    if name not in known:
        raise InputError(f"form = '{name}': no form of dispersion.{nearest(name, known)}")
    return known[name]


OUTLIER: Final = 5.0
"""Standard deviations from its neighbours beyond which a row is left out of the fit and named."""
_LEAST_OUTLIER: Final = 0.05
"""Relative deviation below which leaving a row out would change little."""
_NEAR: Final = 8
"""Rows on each side by which an outlier is judged, so that those of a band are those of the whole table."""
_MOST_ROUNDS: Final = 5
_ROUGH: Final = 1e-4
_CONVERGED: Final = 1e-9
_POLISHED: Final = 2
"""Of the rough fits, the best so many are continued."""
_FIRST_EVALUATIONS: Final = 60


@dataclass(frozen=True, kw_only=True)
class MaterialFit:
    """One form of dispersion, fitted.

    - `permittivity_error`, `conductivity_error`: relative root mean square, over the rows that were fitted;
      NaN of a conductivity that was not measured.
    - `outliers`: rows that were left out.
    - `loss`: one of `LOSSES`; unless it was measured, the real part alone was fitted, and the conductivity is
      0.
    """

    form: str
    material: Material
    estimate: LeastSquaresEstimate
    permittivity_error: float
    conductivity_error: float
    outliers: NDArray[np.bool_]
    loss: str = "measured"

    @property
    def error(self) -> float:
        """The larger of both relative errors that are known."""
        errors = (self.permittivity_error, self.conductivity_error)
        return max(each for each in errors if not math.isnan(each))


def fit_material(
    frequency: ArrayLike,
    permittivity: ArrayLike,
    *,
    forms: Sequence[str] = OFFERED,
    noise: ArrayLike | None = None,
    loss: str = "measured",
) -> tuple[MaterialFit, ...]:
    """Fit forms of dispersion to a measured spectrum of one material, the best by the criterion of Akaike first.

    `noise` is the relative standard deviation of each row, or in two rows that of permittivity and that of
    conductivity; without it all rows count alike. Residuals are differences of the logarithms of permittivity
    and conductivity, so that all frequencies count alike. A row whose residual differs from the means of its
    neighbours by more than 5 standard deviations of such differences nearby, and by more than 5 %, is left
    out, and all forms are fitted again. The `loss` is ``measured``; ``none`` for a material without loss,
    which is without dispersion too; or ``unknown``: the real part alone is fitted, which holds
    no conductivity at zero frequency.
    """
    spectrum = FittedSpectrum.of(frequency, permittivity, noise, loss)
    _refuse(spectrum.frequency, spectrum.permittivity, forms, loss)
    outliers = np.zeros(spectrum.frequency.size, bool)
    before: dict[str, Material] = {}
    for _ in range(_MOST_ROUNDS):
        found: list[MaterialFit] = []
        refused: list[str] = []
        for form in forms:
            try:
                found.append(_best_of(form, spectrum, outliers, before.get(form)))
            except InputError as error:
                refused += error.problems
        if not found:
            raise InputError(refused)
        found.sort(key=lambda each: each.estimate.aicc)
        found_out = _outliers(found[0], spectrum)
        if (found_out == outliers).all():
            break
        outliers, before = found_out, {each.form: each.material for each in found}
    return tuple(found)


def _refuse(grid: Real, data: Complex, forms: Sequence[str], loss: str) -> None:
    unknown = [form for form in forms if form not in FORMS]
    problems = [f"forms = '{form}': no form of dispersion.{nearest(form, FORMS)}" for form in unknown]
    if grid.ndim != 1 or data.shape != grid.shape or grid.size < 4:
        problems.append("frequency, permittivity: expected two rows of the same length, 4 or more")
    elif not (np.isfinite(grid).all() and (grid > 0).all() and np.isfinite(data).all()):
        problems.append("frequency, permittivity: expected finite numbers, frequencies above 0")
    elif not (data.real > 0).all() or (loss == "measured" and data.imag.any() and not (data.imag < 0).all()):
        problems.append("permittivity: expected eps' - j eps'' with both above 0")
    elif loss not in LOSSES or data.imag.any() != (loss == "measured"):
        problems.append(_contradicted(loss))
    if loss == "none" and set(forms) - {"Constant"}:
        problems.append(
            "loss = 'none': by the Kramers-Kronig relations a material without loss is without dispersion; its form is constant."
            " For a permittivity that changes with the frequency state loss = 'unknown' (--loss unknown)"
        )
    refuse(problems)


def _contradicted(loss: str) -> str:
    """Write that what was stated of the loss is not so in the data."""
    if loss not in LOSSES:
        return f"loss = '{loss}': expected {', '.join(LOSSES)}.{nearest(loss, LOSSES)}"
    if loss != "measured":
        return f"loss = '{loss}': the data hold a loss, which is fitted too; omit the statement"
    return (
        "permittivity: the data hold no loss; state loss = 'none' for a material without loss, or loss = 'unknown' to fit the"
        " permittivity alone (--loss none, --loss unknown)"
    )


def _outliers(fit: MaterialFit, spectrum: FittedSpectrum) -> NDArray[np.bool_]:
    """Rows that differ from their two neighbours on each side more than the form differs from the data."""
    order, plain = np.argsort(spectrum.frequency), replace(spectrum, weights=None)
    left = (plain.target - plain.rows(fit.material)).reshape(-1, order.size)[:, order]
    padded = np.pad(left, ((0, 0), (2, 2)), mode="reflect", reflect_type="odd")
    beside = [padded[:, shift : shift + order.size] for shift in range(5)]
    nearest = np.stack([left - (beside[1] + beside[3]) / 2, left - (beside[0] + beside[4]) / 2])
    alone = np.min(np.abs(nearest), axis=0)  # from the pair of neighbours that holds no other outlier
    around = np.pad(alone, ((0, 0), (_NEAR, _NEAR)), mode="reflect")
    scatter = np.median(sliding_window_view(around, 2 * _NEAR + 1, axis=1), axis=2) / 0.6745
    far = alone > np.maximum(OUTLIER * scatter, _LEAST_OUTLIER)
    found = np.zeros(order.size, bool)
    found[order] = far.any(axis=0)
    return found


def shift_of(
    fit: MaterialFit,
    frequency: Real,
    permittivity: Complex,
    *,
    factor: complex | Complex,
    noise: ArrayLike | None,
) -> dict[str, float]:
    """Compute, to first order, the change of the estimates if all data are multiplied by a complex factor close to 1."""
    given = FittedSpectrum.of(frequency, permittivity, noise, fit.loss)
    whole, kept = replace(given, permittivity=given.permittivity * factor), ~fit.outliers
    spectrum = given.part(kept)
    inside = {name: value for name, value in fit.estimate.values.items() if name not in fit.estimate.on_bound}
    sloped = slopes_of(fit.material, inside, free_parameters(fit.material, fit.loss), spectrum.rows)
    scale = np.linalg.norm(sloped, axis=0)
    change = whole.part(kept).target - spectrum.target
    found, *_ = np.linalg.lstsq(sloped / scale, change, rcond=1e-10)
    shift = dict.fromkeys(fit.estimate.values, 0.0)
    return shift | {path: float(value) for path, value in zip(inside, found / scale, strict=True)}


def _best_of(
    form: str, spectrum: FittedSpectrum, outliers: NDArray[np.bool_], before: Material | None
) -> MaterialFit:
    """Fit one form roughly from each of its initial values, or from the fit with other outliers, and continue with the best."""
    kept, loss = spectrum.part(~outliers), spectrum.loss
    rough: list[tuple[LeastSquaresEstimate, Material]] = []
    for start in FORMS[form](kept.frequency, kept.permittivity) if before is None else [before]:
        with contextlib.suppress(ElectrovibError):
            begin = start if loss == "measured" else start.conducting(0.0)
            rough.append(kept.fitted(begin, converged=_ROUGH, most=_FIRST_EVALUATIONS))
    if not rough:
        raise InputError(f"{form}: could not be fitted to this spectrum from any initial values")
    rough.sort(key=lambda each: each[0].sum_of_squares)
    fine: list[tuple[LeastSquaresEstimate, Material]] = []
    for _, each in rough[:_POLISHED]:
        with contextlib.suppress(ElectrovibError):  # ends at values that the material refuses together
            fine.append(kept.fitted(each, converged=_CONVERGED, most=MOST_EVALUATIONS))
    if not fine:
        raise InputError(f"{form}: no values that the form allows represent this spectrum best")
    estimate, material = min(fine, key=lambda each: each[0].sum_of_squares)
    model, target = material.complex_permittivity(kept.frequency), kept.permittivity
    missed = [float(np.sqrt(np.mean((model.real / target.real - 1) ** 2))), math.nan]
    if loss == "measured":
        missed[1] = float(np.sqrt(np.mean((model.imag / target.imag - 1) ** 2)))
    return MaterialFit(
        form=form, material=material, estimate=estimate, permittivity_error=missed[0], conductivity_error=missed[1],
        outliers=outliers, loss=loss,
    )  # fmt: skip


LOSSES: Final = ("measured", "none", "unknown")
"""What is known of the loss of a spectrum: it is among the data, it is 0, or the data say nothing of it."""
_CERTAIN: Final = 5.0
"""Standard errors of the least mean of some rows by which the conductivity may exceed it.

It exceeds more in 3 of 100 tables of 15 flat rows, in fewer of larger ones; with 3 standard errors in 1 of 5.
"""
_EXACT: Final = 1e-3
"""The same relative to the least where the rows have no noise, so that a bound does not decide between forms."""
_HELD: Final = frozenset({"reference_frequency"})
_LEAST_LOGARITHM: Final = 1e-18
_STEP: Final = 1e-7


@dataclass(frozen=True, kw_only=True)
class FittedSpectrum:
    """A measured spectrum, as what is fitted of it: logarithms of its parts.

    `weights` are one over the relative standard deviation of permittivity and conductivity, shape (2, n).
    """

    frequency: Real
    permittivity: Complex
    weights: Real | None
    loss: str

    @classmethod
    def of(
        cls, frequency: ArrayLike, permittivity: ArrayLike, noise: ArrayLike | None, loss: str
    ) -> FittedSpectrum:
        """Collect the rows of a table."""
        grid, data = np.asarray(frequency, dtype=float), np.asarray(permittivity, dtype=complex)
        if noise is None:
            return cls(frequency=grid, permittivity=data, weights=None, loss=loss)
        try:
            given = np.broadcast_to(np.asarray(noise, dtype=float), (2, grid.size))
        except ValueError:
            raise InputError(
                f"noise: expected one number, {grid.size} numbers or two rows of {grid.size}"
            ) from None
        if not (np.isfinite(given).all() and (given > 0).all()):
            raise InputError("noise: expected relative standard deviations above 0")
        return cls(frequency=grid, permittivity=data, weights=1 / given, loss=loss)

    def part(self, kept: NDArray[np.bool_]) -> FittedSpectrum:
        """Return some of its rows."""
        weights = None if self.weights is None else self.weights[:, kept]
        return replace(
            self, frequency=self.frequency[kept], permittivity=self.permittivity[kept], weights=weights
        )

    def _logarithms(self, permittivity: Complex) -> Real:
        """Weighted logarithms of permittivity and, if the loss was measured, of conductivity [S/m], one after the other."""
        parts = [permittivity.real]
        if self.loss == "measured":
            parts.append(-permittivity.imag * 2 * math.pi * self.frequency * eps0)
        with np.errstate(all="ignore"):
            found = np.log(np.concatenate(parts, axis=-1))
        return found if self.weights is None else found * self.weights[: len(parts)].ravel()

    def free(self, start: Material) -> dict[str, FreeParameter]:
        """Return the parameters that are searched, the conductivity of a form up to the least of the rows and its noise."""
        free = free_parameters(start, self.loss)
        if own := free.get("conductivity"):
            most = 2 * math.pi * eps0 * math.exp(self._most())
            free["conductivity"] = replace(own, start=min(own.start, most), upper=min(most, own.upper))
        return free

    def _most(self) -> float:
        """Return the logarithm of the most loss times frequency [Hz] at frequency 0 that the rows allow.

        No row of a passive material is below it, so that neither is the mean of any neighbouring rows.
        """
        rows = np.log(-self.permittivity.imag * self.frequency)[np.argsort(self.frequency)]
        noise = rough_noise(rows) if self.weights is None else 1 / float(self.weights[1].min())
        sizes = [2**power for power in range(rows.size.bit_length())]
        means = (sliding_window_view(rows, size).mean(axis=1).min() for size in sizes)
        return float(
            min(
                mean + max(_CERTAIN * noise / size**0.5, _EXACT)
                for size, mean in zip(sizes, means, strict=True)
            )
        )

    @property
    def target(self) -> Real:
        """What is fitted, shape (n,) or, with the loss, (2 n,)."""
        return self._logarithms(self.permittivity)

    def rows(self, material: Material) -> Real:
        """Return the same of a material."""
        return self._logarithms(material.complex_permittivity(self.frequency))

    def fitted(
        self, start: Material, *, converged: float, most: int
    ) -> tuple[LeastSquaresEstimate, Material]:
        """Search from one material, and return the best one of its form."""
        target, free = self.target, self.free(start)

        def residual(values: Mapping[str, float]) -> Real:
            try:
                return self.rows(with_numbers(start, values)) - target
            except ElectrovibError:
                return np.full(target.shape, np.nan)

        found = least_squares(
            residual,
            free,
            derivatives=lambda values: slopes_of(start, values, free, self.rows),
            noise_is_known=self.weights is not None,
            converged=converged,
            most_evaluations=most,
            stall=Stall(None if self.weights is None else 1.0),
        )
        return found, with_numbers(start, found.values)


def slopes_of(
    start: Material,
    values: Mapping[str, float],
    free: Mapping[str, FreeParameter],
    rows: Callable[[Material], Real],
) -> Real:
    """Compute the derivatives, shape (n, parameters), of the numbers `rows` of a material after its parameters.

    `rows` gets one material whose parameters are columns: the values first, then each moved by a step.
    """
    at = np.array(list(values.values()))
    steps = _STEP * np.array(
        [max(abs(value), 0.0 if free[path].logarithmic else 1e-3) for path, value in values.items()]
    )
    moved = np.vstack([at, at + np.diag(steps)])
    found = rows(with_columns(start, {path: moved[:, [k]] for k, path in enumerate(values)}))
    return np.asarray((found[1:] - found[0]).T / (moved[1:].diagonal() - at))


def free_parameters(start: Material, loss: str) -> dict[str, FreeParameter]:
    """Every number of a material that the data hold, within its range, by its logarithm where it may change by decades."""
    held = _HELD if loss == "measured" else _HELD | {"conductivity"}
    free = {}
    for path, value, quantity in start.parameters():
        if value is None or path in held or quantity is None:
            continue
        decades = quantity.high / max(quantity.low, _LEAST_LOGARITHM) > 1e3
        lower = max(quantity.low, _LEAST_LOGARITHM) if decades else quantity.low
        begin = min(max(float(value), lower), quantity.high)
        free[path] = FreeParameter(start=begin, lower=lower, upper=quantity.high, logarithmic=decades)
    return free


def consistency(frequency: Real, permittivity: Complex) -> float:
    """Compute the deviation of a permittivity from the Kramers-Kronig relations; NaN where the rows do not allow it."""
    loss = -permittivity.imag * 2 * math.pi * frequency * eps0
    try:
        return kramers_kronig_residual(frequency, permittivity.real, loss)
    except InputError:
        return math.nan
