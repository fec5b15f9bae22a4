"""An answer of a command: computed once it is known that it can be written, shown, then written."""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeVar

from electrovib.apps.cli.terminal import say, show_answer

if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import Any

    from electrovib.core.answer import Answer

Found = TypeVar("Found", bound="Answer")


def answered(
    kind: type[Found],
    compute: Callable[..., Found],
    *,
    words: str,
    output: str | None = None,
    force: bool = False,
    show: Callable[[Found], object] = show_answer,
    **options: Any,
) -> Found:
    """Compute, show and write an answer; the output is checked before the computation, and that it replaces no input after.

    `compute` takes `options`, and reports its progress if one of them is ``progress``; `words` say what it does.
    """
    from electrovib.apps.progress import tracked
    from electrovib.core.files import inputs_noted
    from electrovib.exports.save import save
    from electrovib.view.documents import check_answer

    if output:
        check_answer(kind, output, force=force)
    with inputs_noted() as inputs, tracked(words) as progress:
        found = compute(**options | ({"progress": progress} if "progress" in options else {}))
    if output:
        check_answer(kind, output, inputs=inputs, force=force)
    show(found)
    if output:
        save(found, output, force=force)
        say(f"written: {output}")
    return found
