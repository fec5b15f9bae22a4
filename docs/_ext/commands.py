"""The page of the commands, written from the command line itself."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import typer.main
from rst import grid, joined, plain, title

from electrovib.apps.cli import app


def pages() -> dict[str, str]:
    """Return the page of all commands, by file name."""
    parts = [
        title("Commands"),
        "What ``electrovib COMMAND -h`` prints. Options of ``electrovib`` itself, such as ``--budget`` and ``--models``,"
        " stand before the command.",
        *described("electrovib", typer.main.get_command(app), "-"),
    ]
    for name, command in every(typer.main.get_command(app), "electrovib"):
        parts += [title(name, "-"), *described(name, command, "~")]
    return {"commands.rst": joined(parts)}


def every(group: Any, prefix: str) -> Iterator[tuple[str, Any]]:
    """Find all commands, those of groups included."""
    for name, command in group.commands.items():
        yield f"{prefix} {name}", command
        if hasattr(command, "commands"):
            yield from every(command, f"{prefix} {name}")


def described(name: str, command: Any, line: str) -> list[str]:
    """Return the help of one command and the table of its parameters."""
    del name, line
    rows = []
    for parameter in command.params:
        if parameter.name in {"help", "install_completion", "show_completion"} or getattr(
            parameter, "hidden", False
        ):
            continue
        if parameter.param_type_name == "argument":
            shown = parameter.name.upper()
        else:
            shown = ", ".join([*parameter.opts, *parameter.secondary_opts])
        rows.append((f"``{shown}``", plain(getattr(parameter, "help", "") or "")))
    paragraphs = [plain(text) for text in (command.help or "").split("\n\n")]
    return [*paragraphs, grid(("argument or option", "meaning"), rows, "30 70") if rows else ""]
