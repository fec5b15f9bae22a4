"""Which area the finger touches."""

from __future__ import annotations

from abc import abstractmethod
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

from electrovib.core.model import Model
from electrovib.core.quantity import Number, Quantity

if TYPE_CHECKING:
    from collections.abc import Mapping


class Contact(Model, family=True):
    """From load to contact."""

    @abstractmethod
    def gross_area(self) -> float:
        """Area of the outline of the contact [m2]."""


class FixedArea(Contact):
    """A contact area that does not depend on the load."""

    example: ClassVar[Mapping[str, Any]] = {"area": 1e-4}

    area: Annotated[Number, Quantity("m2", 1e-9, 1, "gross contact area")]

    def gross_area(self) -> float:
        """Area of the outline of the contact [m2]."""
        return self.area
