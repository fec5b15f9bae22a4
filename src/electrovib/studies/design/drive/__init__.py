"""Drives whose predicted electrostatic force is a target, within declared limits."""

from electrovib.studies.design.drive.function import DesignedDrive as DesignedDrive
from electrovib.studies.design.drive.function import HeldForce as HeldForce
from electrovib.studies.design.drive.function import design_drive as design_drive
from electrovib.studies.design.drive.function import held_force as held_force
from electrovib.studies.design.drive.target import TargetSource as TargetSource
from electrovib.studies.design.drive.target import read_target as read_target
