"""Items of a long computation, one after the other, with a listener that is informed before each."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Any

ItemListener = Callable[[str, int, int], None]
"""Takes what is computed, the number of the item from 1 on, and the number of all items."""
_LISTENER: ContextVar[ItemListener | None] = ContextVar("item listener", default=None)


@contextmanager
def items_heard(listener: ItemListener) -> Iterator[None]:
    """Inform a listener of each item that is begun in the block, in this thread."""
    token = _LISTENER.set(listener)
    try:
        yield
    finally:
        _LISTENER.reset(token)


def each_item(names: Sequence[str]) -> Iterator[str]:
    """Yield the names of the items of a computation, and inform the listener before each."""
    for number, name in enumerate(names, 1):
        if (listener := _LISTENER.get()) is not None:
            listener(name, number, len(names))
        yield name


def computed(items: Sequence[tuple[str, Callable[[], Iterable[Any]]]]) -> list[tuple[Any, ...]]:
    """Compute items in their order, and inform the listener before each."""
    functions = [function for _, function in items]
    names = each_item([name for name, _ in items])
    return [tuple(function()) for _, function in zip(names, functions, strict=True)]
