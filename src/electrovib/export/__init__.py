"""Export for other programs. The package is callable: it is also the public function ``export``."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from electrovib.scenario import Source


class _Callable(ModuleType):
    """A package that has the name of its main function and can be called as that function."""

    def __call__(
        self,
        scenario: Source,
        path: str | Path,
        *,
        set: Mapping[str, Any] | None = None,  # noqa: A002 - the name of the option
        force: bool = False,
        **options: Any,
    ) -> Path:
        """Write a scenario for a circuit simulator, or its drive as a waveform; see `electrovib.export.scenario.export`."""
        from electrovib.export.scenario import export

        return export(scenario, path, set=set, force=force, **options)


sys.modules[__name__].__class__ = _Callable
