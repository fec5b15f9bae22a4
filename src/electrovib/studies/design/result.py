"""What the answer to every inverse question offers: sentences, tables, numbers, and the scenario with the result in it."""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from electrovib.core.answer import Answer, Document
from electrovib.core.diagnostics import warning_lines
from electrovib.data.marks import Form, json_text

if TYPE_CHECKING:
    from electrovib.core.answer import Table
    from electrovib.core.diagnostics import Diagnostic
    from electrovib.scenario import Scenario
    from electrovib.studies.check import LimitsSource


@dataclass(frozen=True, kw_only=True, repr=False)
class Designed(Answer):
    """Result of a design; `limits` are the further ones that were given, which hold for all that is written of it too."""

    FILES: ClassVar[Mapping[str, str | None]] = {"design.json": Form.DESIGN}
    limits: tuple[LimitsSource, ...] = ()
    form: ClassVar[str]
    """What was sought, as a file of all numbers names it."""

    @property
    @abstractmethod
    def scenario(self) -> Scenario | None:
        """Scenario with the result in it, which can be simulated; None if there is none."""

    @property
    @abstractmethod
    def is_achieved(self) -> bool:
        """Whether the result gives what is wanted, within the limits."""

    @property
    @abstractmethod
    def diagnostics(self) -> Sequence[Diagnostic]:
        """Diagnostics of that scenario beyond those that the comparison with the limits states; `lines` ends with them."""

    @property
    @abstractmethod
    def sentences(self) -> Sequence[str]:
        """The sentences that are needed first: the answer, what else there is, and what the limits allow."""

    @abstractmethod
    def numbers(self) -> dict[str, Any]:
        """Return all numbers as nested tables, in SI."""

    @property
    def details(self) -> Sequence[str]:
        """Sentences on how the result was found and what it depends on."""
        return ()

    @property
    def tables(self) -> Sequence[Table]:
        """Numbers of the result in words, named and with units."""
        return ()

    @property
    def answer(self) -> str:
        """The sentences that are needed first, as one text."""
        return " ".join(self.sentences)

    @property
    def verdict(self) -> tuple[str, ...]:
        """The sentences among `lines` that are needed first, warnings included."""
        return (*self.sentences, *warning_lines(self.diagnostics, brief=True))

    @property
    def lines(self) -> tuple[str, ...]:
        """Sentences and numbers for people, the answer first."""
        return (*self.verdict, *self.details)

    @property
    def document(self) -> Document:
        """The sentences, the tables, and the details."""
        scenario = self.scenario
        return Document(
            title=f"Design: {scenario.title if scenario is not None and scenario.title else self.form}",
            sentences=self.sentences,
            diagnostics=self.diagnostics,
            tables=self.tables,
            remarks=self.details,
        )

    def content(self, name: str) -> str:
        """Write all numbers as JSON."""
        del name
        return json_text(Form.DESIGN, self.to_dict())

    def __repr__(self) -> str:
        return "\n".join(self.lines)

    def to_dict(self) -> dict[str, Any]:
        """Return everything as nested tables with numbers in SI; what is not known or infinite is None."""
        found = {"form": self.form, **self.numbers(), "is_achieved": self.is_achieved}
        told = {"diagnostics": [each.to_dict() for each in self.diagnostics], "text": list(self.lines)}
        return {name: plain(value) for name, value in found.items()} | told


def plain(value: Any) -> Any:
    """Return numbers and tables as JSON has them: lists, and None for a number that is not finite."""
    if isinstance(value, Mapping):
        return {str(name): plain(each) for name, each in value.items()}
    if isinstance(value, np.ndarray | list | tuple):
        return [plain(each) for each in (value.tolist() if isinstance(value, np.ndarray) else value)]
    return None if isinstance(value, float) and not math.isfinite(value) else value
