"""For other programs. The package can be called: it is the public function ``export`` too."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from electrovib.scenario import Source


class _Callable(ModuleType):
    """A package of the name of its main function: importing a part of it must not hide the function."""

    def __call__(
        self,
        scenario: Source,
        path: str | Path,
        *,
        set: Mapping[str, Any] | None = None,  # noqa: A002 - the name of the option
        force: bool = False,
    ) -> Path:
        """Write a scenario for a circuit simulator; see `electrovib.export.scenario.export`."""
        from electrovib.export.scenario import export

        return export(scenario, path, set=set, force=force)


sys.modules[__name__].__class__ = _Callable
