"""Many scenarios.

The package can be called: ``electrovib.study(...)`` runs a study of a population of fingers, because the package has the
name of that function (`electrovib.study.population.study`).
"""

from __future__ import annotations

import inspect
import sys
from types import ModuleType
from typing import Any


class _CallablePackage(ModuleType):
    """A package that runs a study when it is called."""

    def __call__(self, *arguments: Any, **options: Any) -> Any:
        from electrovib.study.population import study

        return study(*arguments, **options)

    @property
    def __signature__(self) -> inspect.Signature:
        """Signature of the function, for help and completion."""
        from electrovib.study.population import study

        return inspect.signature(study)


sys.modules[__name__].__class__ = _CallablePackage
