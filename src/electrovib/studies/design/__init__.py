"""Inverse questions about a scenario: the parameter, or the drive, that gives a wanted quantity or force.

A form of the question is a function of its own, named in `electrovib.studies.design.forms`; `design` selects it by the
arguments that are given.
"""

from electrovib.studies.design.function import design as design
from electrovib.studies.design.result import Designed as Designed
