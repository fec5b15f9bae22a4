"""An answer of a command: computed once it is known that it can be written, shown, then written."""

from __future__ import annotations

import inspect
from typing import TYPE_CHECKING, Any, TypeVar

from electrovib.apps.cli.terminal import say, show_answer

if TYPE_CHECKING:
    from collections.abc import Callable

    from electrovib.core.answer import Answer

Found = TypeVar("Found", bound="Answer")


def answered(
    kind: type[Found],
    compute: Callable[..., Found],
    words: str,
    given: dict[str, Any],
    show: Callable[..., object] = show_answer,
) -> Found:
    """Compute, show and write an answer; the output is checked before the computation, and that it replaces no input after.

    `given` has what `compute` takes, besides `output`, `force` and `all`; progress is reported if it can be, and `words` say
    what is done.
    """
    from electrovib.apps.progress import tracked
    from electrovib.core.files import inputs_noted
    from electrovib.exports.save import save
    from electrovib.view.documents import check_answer

    output, force, everything = (given.pop(name, None) for name in ("output", "force", "all"))
    if output:
        check_answer(kind, output, force=bool(force))
    with inputs_noted() as inputs, tracked(words) as progress:
        can_report = "progress" in inspect.signature(compute).parameters
        found = compute(**given, **({"progress": progress} if can_report else {}))
    if output:
        check_answer(kind, output, inputs=inputs, force=bool(force))
    show(found, everything=bool(everything))
    if output:
        save(found, output, force=bool(force))
        say(f"written: {output}")
    return found
