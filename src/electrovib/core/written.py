"""The written form of a model: nested tables, canonical JSON, hash and equality."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Collection, Mapping
from typing import Any, ClassVar

from pydantic import BaseModel


class Written(BaseModel):
    """A model that is written as nested tables, and compared by them."""

    is_member: ClassVar[bool] = False
    """Whether it is one of a family, whose tables name it."""
    later_parameters: ClassVar[frozenset[str]] = frozenset()
    """Parameters that were added later: at their defaults they do not enter the hash, which older files carry."""

    def to_dict(self) -> dict[str, Any]:
        """Give the nested tables that build this model again, floats in SI.

        Returns
        -------
        dict
            Member of a family: with its ``model`` name first.
        """
        return self._tables(hashed=False)

    def opened(self, names: Collection[str]) -> dict[str, Any]:
        """Give the tables of some parts, and the other parts as the models that they are.

        Parameters
        ----------
        names : collection of str
            Parameters whose tables are given.

        Returns
        -------
        dict
            Builds this model again; parts that stay models are not validated again.
        """
        return {
            name: value if isinstance(value, Written) and name not in names else _plain(value, hashed=False)
            for name, value in self
        }

    def _tables(self, *, hashed: bool) -> dict[str, Any]:
        content = {"model": type(self).__name__} if self.is_member else {}
        fields, later = type(self).model_fields, self.later_parameters if hashed else ()
        kept = ((name, value) for name, value in self if name not in later or value != fields[name].default)
        return content | {name: _plain(value, hashed=hashed) for name, value in kept}

    def canonical(self) -> str:
        """Write the canonical JSON: what equality, hash and the scenario's hash are made of.

        Returns
        -------
        str
            Parameters in the order of their declaration, layers in that of the stack, which is physics.
        """
        return json.dumps(self._tables(hashed=True), separators=(",", ":"), default=_content)

    def digest(self) -> str:
        """Give the SHA-256 of the canonical JSON, hexadecimal."""
        return hashlib.sha256(self.canonical().encode()).hexdigest()

    def __eq__(self, other: object) -> bool:
        return (
            isinstance(other, Written) and type(self) is type(other) and self.canonical() == other.canonical()
        )

    def __hash__(self) -> int:
        return hash((type(self).__name__, self.canonical()))


def _plain(value: Any, *, hashed: bool) -> Any:
    if isinstance(value, Written):
        return value._tables(hashed=hashed)  # noqa: SLF001  # of its own kind
    if isinstance(value, (tuple, list)):
        return [_plain(item, hashed=hashed) for item in value]
    if isinstance(value, Mapping):
        return {key: _plain(item, hashed=hashed) for key, item in value.items()}
    return value


def _content(value: Any) -> Any:
    return value.canonical_content()
