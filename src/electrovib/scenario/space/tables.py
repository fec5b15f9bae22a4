"""Tables of a space from a file, a name or nested tables."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

from electrovib.core.errors import LONGEST_QUOTED, InputError, nearest, shortened
from electrovib.data.toml_file import read_toml_file
from electrovib.scenario.space.shipped import read_shipped, shipped_names

PARTS: Final = ("schema", "title", "relations", "space", "correlation", "groups")
"""Tables and values at the top of the file of a space."""


def tables_of(source: object) -> tuple[Mapping[str, Any], Path]:
    """Return the tables of a TOML file or shipped population, and the folder to which their files are relative."""
    if isinstance(source, Mapping):
        whole = any(part in source for part in PARTS)
        return (source if whole else {"space": source}), Path()
    if not isinstance(source, (str, os.PathLike)):
        raise InputError(
            f"space = {shortened(repr(source), LONGEST_QUOTED)}: expected a .toml file, tables, a Space, or one of"
            f" {', '.join(shipped_names())}"
        )
    if str(source) in shipped_names():
        return read_shipped(str(source)), Path()
    path = Path(source)
    if path.suffix != ".toml" and not path.exists():
        raise InputError(
            f"'{source}' is neither a file nor a population of the package.{nearest(str(source), shipped_names())}"
        )
    return read_toml_file(path, kind="a space", advice="Give a .toml file of a space"), path.parent
