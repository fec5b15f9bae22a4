"""The result of a study as an answer: bands, exceedance probabilities, and the parameters that differ with their sources."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from typing import Any, ClassVar, Final

import xarray

from electrovib.core.answer import Answer, Document, Drawing, Page, Table, as_sentence
from electrovib.core.citation import UNVERIFIED, is_reference, status_text
from electrovib.core.diagnostics import diagnostics_of, warning_lines
from electrovib.core.signals import is_study_result
from electrovib.data.atomic import Form
from electrovib.studies.catalogue.found import HEADINGS, SHARE, distributions_in
from electrovib.studies.population import result

_SIZE: Final = (9.4, 3.8)
"""Width and height of a figure of the page [inch]."""


def study_document(found: xarray.Dataset, *, title: str | None = None) -> Document:
    """Say what a study has found."""
    names = [str(each) for each in found.attrs["signals"]]
    words = [line for name in names for line in result.signal_words(found, name)]
    words += result.width_words(found) + result.nominal_words(found)
    of = [f"Scenario: {found.attrs['title']}"] if found.attrs["title"] else []
    return Document(
        title=title or f"Study of {found.attrs['fingers']} fingers: {found.attrs['title'] or 'a scenario'}",
        sentences=[*map(as_sentence, words)],
        diagnostics=diagnostics_of(found),
        note="Of the scenario with its own values; the drawn fingers are not judged one by one.",
        figures=[each for name in names for each in _figures(found, name)],
        remarks=[
            *of,
            *result.method_words(found),
            result.NOT_JUDGED,
            *(f"note: {each}" for each in found.attrs["space_remarks"]),
        ],
        pages=[
            _parameters(found),
            _origin(found),
            Page("Scenario", (str(found.attrs["scenario_toml"]),), listing=True),
        ],
        references=_sources(found),
    )


def band_figures(found: xarray.Dataset, beside: Mapping[str, xarray.Dataset]) -> list[Drawing]:
    """Draw the bands of each signal of a study with the runs and recordings of a report over them."""
    lines = [*result.width_words(found), *result.nominal_words(found), *warning_lines(diagnostics_of(found))]
    caption = " ".join([_caption(found), *map(as_sentence, lines)])
    return [
        _drawing(found, str(name), "bands", caption=caption, beside=beside) for name in found.attrs["signals"]
    ]


def _figures(found: xarray.Dataset, name: str) -> list[Drawing]:
    drawn = [_drawing(found, name, "bands", caption=_caption(found))]
    if f"{name}_exceedance" in found:
        drawn.append(_drawing(found, name, "exceedance", more=": exceedance probability"))
    return drawn


def _drawing(
    found: xarray.Dataset, name: str, plot: str, *, more: str = "", caption: str = "", **options: Any
) -> Drawing:
    words = name.replace("_", " ")
    title = f"{words[0].upper()}{words[1:]} over the fingers{more}"
    return Drawing(
        id="-".join(title.lower().split()),
        title=title,
        caption=caption,
        plot=plot,
        of=found,
        options={"signal": name} | options,
        size=_SIZE,
    )


def _caption(found: xarray.Dataset) -> str:
    """State how many fingers, and which parameters differ; those with unverified values are marked."""
    rows = [each for each in distributions_in(_space(found)) if each.name != SHARE]
    names = dict.fromkeys(each.name for each in rows)
    doubtful = {each.name for each in rows if each.status == UNVERIFIED}
    listed = ", ".join(f"{path} ({status_text(UNVERIFIED)})" if path in doubtful else path for path in names)
    return f"{found.attrs['fingers']} fingers, seed {found.attrs['seed']}. Parameters that differ between them: {listed}."


def _space(found: xarray.Dataset) -> dict[str, Any]:
    return tomllib.loads(str(found.attrs["space_toml"]))


def _parameters(found: xarray.Dataset) -> Table:
    space = _space(found)
    relations = [f"{each}." for each in space.get("relations", [])]
    relations += [
        f"correlation of {pair}: {value:g}." for pair, value in space.get("correlation", {}).items()
    ]
    rows = tuple(each.row for each in distributions_in(space))
    return Table("Parameters that differ between fingers", HEADINGS, rows, caption=" ".join(relations))


def _origin(found: xarray.Dataset) -> Table:
    versions = ", ".join(f"{name} {each}" for name, each in found.attrs["versions"].items())
    caption = "Variance of the population, estimated over n - 1."
    return Table("Computation", ("", ""), (("Versions", versions),), caption=caption)


def _sources(found: xarray.Dataset) -> list[str]:
    listed = (each.source for each in distributions_in(_space(found)) if each.source)
    return list(dict.fromkeys(each for each in listed if is_reference(each)))


_OF_SIGNAL: Final = ("mean", "variance")
"""Arrays over time or frequency that each signal of a study has."""


class StudyResult(Answer, xarray.Dataset):  # type: ignore[no-untyped-call] # __init_subclass__ of xarray
    """Bands of a study over its fingers: an `xarray.Dataset` in all that it does, and an answer in what it shows.

    Notes
    -----
    What xarray derives from it is of this class again: over a part of the time it is an answer as well, and shown as
    xarray does it once a signal has lost its axis.
    """

    __slots__ = ()
    FILES: ClassVar[Mapping[str, str | None]] = {"bands.csv": Form.TABLE}

    @classmethod
    def of(cls, found: xarray.Dataset) -> StudyResult:
        """Return the Dataset of a study, such as one that xarray has read, as an answer."""
        kept = cls(dict(found.variables), attrs=found.attrs)  # in their order
        return kept.set_coords(list(found.coords))

    @property
    def document(self) -> Document:
        """Bands of each signal, its exceedance probabilities, and the parameters that differ between fingers."""
        return study_document(self)

    def content(self, name: str) -> str:
        """Write the bands as CSV."""
        del name
        return result.bands_csv(self)

    def __repr__(self) -> str:
        return super().__repr__() if self._is_whole else xarray.Dataset.__repr__(self)

    def _repr_html_(self) -> str:
        return super()._repr_html_() if self._is_whole else xarray.Dataset._repr_html_(self)

    @property
    def _is_whole(self) -> bool:
        """Whether every signal still has its bands over an axis."""
        arrays = [f"{name}_{each}" for name in self.attrs.get("signals", ()) for each in _OF_SIGNAL]
        return is_study_result(self) and all(name in self and self[name].ndim == 1 for name in arrays)
