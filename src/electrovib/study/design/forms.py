"""The forms in which a design is asked for. A form is added by one function here and one row of `FORMS`."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Final

from electrovib.core.errors import InputError
from electrovib.study.design.form import DesignForm


def _parameter() -> Callable[..., Any]:
    from electrovib.study.design.parameter import design_parameter

    return design_parameter


def _drive() -> Callable[..., Any]:
    from electrovib.study.design.drive import design_drive

    return design_drive


def _share() -> Callable[..., Any]:
    from electrovib.study.design.robust import design_for_share

    return design_for_share


FORMS: Final = (
    DesignForm(
        "a parameter",
        ("want", "free"),
        'want="mean electrostatic_force = 50 mN", free="drive.amplitude"',
        _parameter,
    ),
    DesignForm(
        "a drive",
        ("target", "method"),
        'target="sine 50 Hz 30 mN", method="carrier"',
        _drive,
    ),
    DesignForm(
        "a parameter for a share of a population",
        ("share", "want", "free", "space", "seed"),
        'want="mean electrostatic_force = 50 mN", free="drive.amplitude", space="fingers", share=0.9, seed=1',
        _share,
    ),
)
"""The last form whose deciding argument is given is the one that is meant."""


def form_of(given: Mapping[str, Any]) -> DesignForm:
    """Return the form that is meant by the given arguments, all that it needs and nothing else among them."""
    form = next((each for each in reversed(FORMS) if each.needs[0] in given), None)
    if form is None:
        form = next((each for each in FORMS if set(each.needs) & given.keys()), None)
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
