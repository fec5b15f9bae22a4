"""Inverse questions about a scenario: the value, the drive or the plate that gives what is wanted. Each is one function."""

from electrovib.studies.design.result import Designed as Designed
from electrovib.studies.design.share import value_for_share as value_for_share
from electrovib.studies.design.value import find_value as find_value
