"""Short names of the forms of dispersion, for commands."""

from __future__ import annotations

import re
from typing import Final

from electrovib.core.errors import InputError, nearest
from electrovib.recordings.spectra.forms import FORMS, OFFERED

GABRIEL: Final = "gabriel"


def _command_name(form: str) -> tuple[str, str]:
    """Return the name of a form for a command, ``cole-cole``, and its number of terms as text."""
    name, _, terms = form.partition(",")
    kebab = re.sub(r"(?<=[a-z])(?=[A-Z])", "-", name).lower()
    return kebab, terms.strip().partition(" ")[0]


def forms_of(name: str) -> tuple[str, ...]:
    """Return the names among `FORMS` that a short name stands for, between which the criterion of Akaike decides.

    It is ``auto``, the name of a form such as ``cole-cole``, with any number of terms, that with a number of
    terms such as ``cole-cole-2``, or ``gabriel`` for four Cole-Cole terms.
    """
    known: dict[str, tuple[str, ...]] = {"auto": OFFERED}
    for form in FORMS:
        kebab, terms = _command_name(form)
        known[kebab] = (*known.get(kebab, ()), form)
        if terms:
            known[f"{kebab}-{terms}"] = (form,)
    known[GABRIEL] = known["cole-cole-4"]
    if name not in known:
        raise InputError(f"form = '{name}': no form of dispersion.{nearest(name, known)}")
    return known[name]
