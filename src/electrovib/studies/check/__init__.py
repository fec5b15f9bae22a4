"""Check of a drive against limits, before it is written or played."""

from electrovib.studies.check.declared import (
    LINES_TO_ADD,
    NEEDED,
    DeclaredLimit,
    LimitsFrom,
    LimitsSource,
    limits_from,
    limits_of,
    refuse_unlimited,
    strictest,
)
from electrovib.studies.check.function import (
    DriveSource,
    check,
    checked,
    cleared_as_played,
    cleared_for_output,
    declared_limits,
    read_drive,
    sampled,
    with_drive,
    without_its_limits,
)
from electrovib.studies.check.result import CheckNumber, CheckResult, CheckRow

__all__ = [
    "LINES_TO_ADD",
    "NEEDED",
    "CheckNumber",
    "CheckResult",
    "CheckRow",
    "DeclaredLimit",
    "DriveSource",
    "LimitsFrom",
    "LimitsSource",
    "check",
    "checked",
    "cleared_as_played",
    "cleared_for_output",
    "declared_limits",
    "limits_from",
    "limits_of",
    "read_drive",
    "refuse_unlimited",
    "sampled",
    "strictest",
    "with_drive",
    "without_its_limits",
]
