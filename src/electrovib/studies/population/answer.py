"""The result of a study as an answer that is a Dataset too."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar, Final

import xarray

from electrovib.core.answer import Answer
from electrovib.core.signals import is_study_result
from electrovib.data.marks import Form
from electrovib.studies.population.document import study_document
from electrovib.studies.population.result import bands_csv

if TYPE_CHECKING:
    from collections.abc import Mapping

    from electrovib.core.answer import Document

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
        return bands_csv(self)

    def __repr__(self) -> str:
        return super().__repr__() if self._is_whole else xarray.Dataset.__repr__(self)

    def _repr_html_(self) -> str:
        return super()._repr_html_() if self._is_whole else xarray.Dataset._repr_html_(self)

    @property
    def _is_whole(self) -> bool:
        """Whether every signal still has its bands over an axis."""
        arrays = [f"{name}_{each}" for name in self.attrs.get("signals", ()) for each in _OF_SIGNAL]
        return is_study_result(self) and all(name in self and self[name].ndim == 1 for name in arrays)
