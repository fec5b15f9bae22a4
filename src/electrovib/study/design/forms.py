"""The forms in which a design is asked for. A form is added by one function and one row of `FORMS`."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from importlib import import_module
from typing import Any, Final

from electrovib.core.errors import InputError

_ALWAYS: Final = ("scenario", "progress")


@dataclass(frozen=True)
class DesignForm:
    """One form of the question; the first argument in `needs` decides that it is meant; `function` is ``module:name``."""

    name: str
    needs: tuple[str, ...]
    example: str
    function: str

    def load(self) -> Callable[..., Any]:
        """Return the function of the form."""
        module, _, name = self.function.partition(":")
        found: Callable[..., Any] = getattr(import_module(f"electrovib.study.design.{module}"), name)
        return found

    @property
    def accepts(self) -> tuple[str, ...]:
        """Names of the arguments of the form, the scenario and the report of progress omitted."""
        return tuple(name for name in inspect.signature(self.load()).parameters if name not in _ALWAYS)


FORMS: Final = (
    DesignForm(
        "a parameter",
        ("want", "free"),
        'want="mean electrostatic_force = 50 mN", free="drive.amplitude"',
        "parameter:design_parameter",
    ),
    DesignForm(
        "a drive",
        ("target", "method"),
        'target="sine 50 Hz 30 mN", method="carrier"',
        "drive:design_drive",
    ),
    DesignForm(
        "a parameter for a share of a population",
        ("share", "want", "free", "space", "seed"),
        'want="mean electrostatic_force = 50 mN", free="drive.amplitude", space="fingers", share=0.9, seed=1',
        "share:design_for_share",
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
