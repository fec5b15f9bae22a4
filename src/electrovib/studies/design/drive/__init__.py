"""Drives whose predicted electrostatic force is a target, within declared limits."""

from electrovib.studies.design.drive.function import DesignedDrive as DesignedDrive
from electrovib.studies.design.drive.function import drive_for_force as drive_for_force
from electrovib.studies.design.drive.target import TargetSource as TargetSource
from electrovib.studies.design.drive.target import read_target as read_target
