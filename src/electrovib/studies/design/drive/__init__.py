"""Drives whose predicted electrostatic force is a target, within declared limits."""

from electrovib.studies.design.drive.function import METHODS, HeldForce, design_drive, held_force
from electrovib.studies.design.drive.result import DesignedDrive
from electrovib.studies.design.drive.target import Target, TargetSource, read_target

__all__ = [
    "METHODS",
    "DesignedDrive",
    "HeldForce",
    "Target",
    "TargetSource",
    "design_drive",
    "held_force",
    "read_target",
]
