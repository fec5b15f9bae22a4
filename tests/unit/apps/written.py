"""Files that a command has written, as tests read them."""

from pathlib import Path


def uncommented(file: Path) -> list[str]:
    """Return the lines of a table without its comments: the mark and the warnings."""
    return [line for line in file.read_text(encoding="utf-8").splitlines() if not line.startswith("#")]
