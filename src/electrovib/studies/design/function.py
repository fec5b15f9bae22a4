"""The public function of all designs, and the forms of the question. A form is added by one function and one row of `FORMS`."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

from electrovib.core.errors import InputError
from electrovib.scenario import Source, read_scenario
from electrovib.studies.design.drive import design_drive
from electrovib.studies.design.parameter import design_parameter
from electrovib.studies.design.share import design_for_share

if TYPE_CHECKING:
    from electrovib.scenario.space import SpaceSource
    from electrovib.studies.check import LimitsSource
    from electrovib.studies.design.drive import TargetSource
    from electrovib.studies.design.result import Designed
    from electrovib.studies.design.wanted import BetweenSource, WantSource

_ALWAYS: Final = ("scenario", "progress")


def design(
    scenario: Source,
    *,
    want: WantSource | None = None,
    free: str | None = None,
    between: BetweenSource | None = None,
    target: TargetSource | None = None,
    method: str | None = None,
    carrier: float | str | None = None,
    rate: float | str | None = None,
    limits: LimitsSource | Sequence[LimitsSource] = None,
    space: SpaceSource | None = None,
    n: int | None = None,
    seed: int | None = None,
    linear: bool | None = None,
    share: float | None = None,
    band: str | Sequence[str | float] | None = None,
    set: Mapping[str, Any] | None = None,  # noqa: A002 - the name of the option
    progress: Callable[[int, int], None] | None = None,
) -> Designed:
    """Find the value of a parameter that gives a wanted quantity, or the drive that gives a wanted force.

    Parameters
    ----------
    scenario : str, Path, mapping, Scenario or xarray.Dataset
        As for `electrovib.load`.
    want : str or mapping, optional
        Quantity and value, ``"mean electrostatic_force = 50 mN"`` or ``{"mean electrostatic_force": 0.05}``; the quantity is
        named as for `electrovib.sweep`, or is a signal at one time, ``"electrostatic_force at 20 ms = 1 mN"``.
    free : str, optional
        Dotted path of the parameter that is sought, ``"drive.amplitude"``.
    between : str or sequence of two, optional
        Ends of the range in which it is sought, ``"10 V:400 V"``; by default the range of the parameter.
    target : str, Path, Target or pair of array_like, optional
        Force over time, which is never negative: ``"sine 50 Hz 30 mN"`` (between 0 and 30 mN), ``"sine 50 Hz 10 mN to 30 mN
        for 0.2 s"``, ``"constant 5 mN for 1 s"``, a file with the columns time and force, or times [s] and forces [N].
    method : str, optional
        Method of the drive: ``"dc"``, ``"carrier"``, ``"sqrt-am"`` or ``"current"``.
    carrier : float or str, optional
        Frequency of the carrier [Hz]; chosen if absent.
    rate : float or str, optional
        Samples of the drive per second [Hz]; chosen if absent.
    limits : str, Path, mapping, Limits, or a list of them, optional
        Further limits beside those of the scenario; the strictest counts.
    space : str, Path, mapping or Space, optional
        Distributions of uncertain parameters, as for `electrovib.read_space`: ``"fingers"``.
    n : int, optional
        Number of draws from the space, 200 by default.
    seed : int, optional
        Seed of the draws; needed with `space`.
    linear : bool, optional
        Whether the distribution of the result is computed by linear propagation instead of one solution for each draw.
    share : float, optional
        Share of the fingers of `space` [1] for which the quantity has to be at least the wanted value; needs `seed`.
    band : str or sequence of two, optional
        With `share`: the band in which the quantity has to lie, ``"20 mN:60 mN"``; `want` then names the quantity alone.
    set : mapping of str to value, optional
        Dotted path to value, put into the scenario.
    progress : callable, optional
        Function of the number of evaluations done and of all evaluations.

    Returns
    -------
    Designed
        The result: its sentences (`lines`), the scenario with the result in it (`scenario`), and all numbers.

    Raises
    ------
    InputError
        For every mistake in the arguments.
    BudgetError
        If the computation would take more time or memory than is allowed.
    """
    arguments = {
        "want": want,
        "free": free,
        "between": between,
        "target": target,
        "method": method,
        "carrier": carrier,
        "rate": rate,
        "limits": limits,
        "space": space,
        "n": n,
        "seed": seed,
        "linear": linear,
        "share": share,
        "band": band,
    }
    given = {name: value for name, value in arguments.items() if value is not None}
    form = form_of(given)
    found: Designed = form.function(read_scenario(scenario, changes=set), progress=progress, **given)
    return found


@dataclass(frozen=True)
class DesignForm:
    """One form of the question; the first argument in `needs` decides that it is meant."""

    name: str
    needs: tuple[str, ...]
    example: str
    function: Callable[..., Any]

    @property
    def accepts(self) -> tuple[str, ...]:
        """Names of the arguments of the form, the scenario and the report of progress omitted."""
        return tuple(name for name in inspect.signature(self.function).parameters if name not in _ALWAYS)


FORMS: Final = (
    DesignForm(
        "a parameter",
        ("want", "free"),
        'want="mean electrostatic_force = 50 mN", free="drive.amplitude"',
        design_parameter,
    ),
    DesignForm(
        "a drive",
        ("target", "method"),
        'target="sine 50 Hz 30 mN", method="carrier"',
        design_drive,
    ),
    DesignForm(
        "a parameter for a share of a population",
        ("share", "want", "free", "space", "seed"),
        'want="mean electrostatic_force = 50 mN", free="drive.amplitude", space="fingers", share=0.9, seed=1',
        design_for_share,
    ),
)
"""The last form whose deciding argument is given is the one that is meant."""


def form_of(given: Mapping[str, Any]) -> DesignForm:
    """Return the form that is meant by the given arguments, all that it needs and nothing else among them."""
    form = next((each for each in reversed(FORMS) if each.needs[0] in given), None)
    form = form or next((each for each in FORMS if set(each.needs) & given.keys()), None)
    if form is None:
        examples = "; or ".join(f"{each.name} by {each.example}" for each in FORMS)
        raise InputError(f"design: state what is wanted: {examples}")
    missing = [name for name in form.needs if name not in given]
    if missing:
        raise InputError(
            f"{missing[0]}: not given, but the design of {form.name} needs it, for instance {form.example}"
        )
    accepted = form.accepts
    foreign = [name for name in given if name not in accepted]
    if foreign:
        raise InputError(
            f"{name}: does not belong to the design of {form.name}, which takes {', '.join(accepted)}; omit it"
            for name in foreign
        )
    return form
