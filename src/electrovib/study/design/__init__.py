"""Inverse questions about a scenario: the parameter, or the drive, that gives a wanted quantity or force.

A form of the question is a function of its own, named in `electrovib.study.design.forms`; `design` selects it by the
arguments that are given.
"""

from electrovib.study.design.function import design
from electrovib.study.design.result import Designed

__all__ = ["Designed", "design"]
