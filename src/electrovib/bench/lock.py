"""One process at a time for each bench."""

from __future__ import annotations

import hashlib
import tempfile
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from electrovib.bench.faults import BenchError
from electrovib.data.lock import HeldError, held

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping


def lock_file(resources: Mapping[str, str]) -> Path:
    """Return the file of the lock of a bench with these addresses."""
    key = hashlib.sha256("\n".join(sorted(resources.values())).encode()).hexdigest()[:16]
    return Path(tempfile.gettempdir()) / f"electrovib-bench-{key}.lock"


@contextmanager
def one_process(resources: Mapping[str, str]) -> Iterator[str]:
    """Hold the lock of a bench; yield what a run that was killed left, or ""."""
    path = lock_file(resources)
    with ExitStack() as stack:
        try:
            left = stack.enter_context(held(path))
        except HeldError as error:
            who = f"{error}, " if str(error) else ""
            raise BenchError(
                f"another process uses this bench ({who}lock {path}); wait until it has ended, there is no option to override"
                " this"
            ) from None
        yield f"running, {left}" if left else ""
