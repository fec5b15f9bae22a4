"""Methods that a model may override: how its tables are completed, read from files and changed."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from pydantic import BaseModel

from electrovib.core.tables import put

if TYPE_CHECKING:
    from electrovib.core.errors import Problem
    from electrovib.core.files import FileColumn


class Overridable(BaseModel):
    """Base of `Model` with the defaults of what a model may override."""

    @classmethod
    def file_columns(cls, table: Mapping[str, Any]) -> Mapping[str, FileColumn]:
        """Return the columns from which parameters are read if a table names a file.

        Parameters
        ----------
        table : mapping
            The model's own, not yet validated.

        Returns
        -------
        columns : mapping of str to FileColumn
            Columns by parameter; empty if nothing has to be read, or if the table is not valid.
        """
        del table
        return {}

    @classmethod
    def file_variants(cls, table: Mapping[str, Any]) -> tuple[Mapping[str, Any], ...]:
        """Return parameters with which to read the file of a table if it has not the columns of `file_columns`.

        Parameters
        ----------
        table : mapping
            The model's own, not yet validated.

        Returns
        -------
        variants : tuple of mapping
            The first whose columns are in the file is added to the table.
        """
        del table
        return ()

    @classmethod
    def complete(cls, content: dict[str, Any]) -> dict[str, Any]:
        """Add what follows from a table before it is validated."""
        return content

    @classmethod
    def put_into(cls, content: dict[str, Any], changes: Mapping[str, Any]) -> list[Problem]:
        """Put changes by dotted path into nested tables of this model, and return what is wrong with them."""
        return put(content, changes)

    @classmethod
    def how_to_add(cls, content: Mapping[str, Any], path: str) -> str:
        """Explain how to add the optional part that a dotted path leads into; empty where it leads into none."""
        del content, path
        return ""

    def stored(self, given: Mapping[str, Any]) -> dict[str, Any]:
        """Return given parameters as those that this model stores: a member may offer derived ones beside them."""
        return dict(given)
