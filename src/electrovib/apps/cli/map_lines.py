"""What the terminal prints of a sweep over several parameters, whose sentences would fill a page."""

from __future__ import annotations

import math
import shlex
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Mapping


def is_map(trace: Any) -> bool:
    """Return whether a Trace is a sweep over two parameters or more."""
    return sum(path in trace.attrs.get("over", "") for path in trace.sizes) > 1


def judged(trace: Any, output: str | None, report: str | None) -> list[str]:
    """Write a line for each exceeded limit of a map, one for what was not judged, and one that names where the rest is.

    The last line is left out where nothing is exceeded or unknown.
    """
    from electrovib.core.parsing import read_json
    from electrovib.view.lines import swept_paths, swept_units

    found = read_json(trace.attrs["validity"])
    units, count = swept_units(trace), math.prod(trace.sizes[path] for path in swept_paths(trace))
    lines = [_exceeded(each, units, count) for each in found if each["state"] == "warning"]
    unknown = [_share(each, count) for each in found if each["state"] == "unknown"]
    if unknown:
        lines.append(f"not judged: {', '.join(unknown)}")
    if not lines:
        return []
    if report:
        return [*lines, f"reasons and advice: {report}"]
    how = (
        f"'electrovib report {shlex.quote(output)}'" if output else "the same command with --report map.html"
    )
    return [*lines, f"reasons and advice: {how}"]


def _exceeded(found: Mapping[str, Any], units: Mapping[str, str], count: int) -> str:
    """Write name, largest value with its place, and limit of an exceeded limit; its sentence where it has no number."""
    from electrovib.core.units import format_quantity

    if "value" not in found:
        return f"warning: {found['text']}"
    value, limit = (format_quantity(found[name], found["unit"], digits=3) for name in ("value", "limit"))
    return f"warning: {_share(found, count)}: up to {value} at {_place(found['at'], units)}, above {limit}"


def _share(found: Mapping[str, Any], count: int) -> str:
    return f"{found['name']} (in {found.get('cases', count)} of {count} cases)"


def _place(at: Mapping[str, Any], units: Mapping[str, str]) -> str:
    """Write the values of a case, in the order of the first line."""
    from electrovib.view.summary import swept_value

    return ", ".join(swept_value(value, units.get(path, ""), plain=True) for path, value in at.items())
