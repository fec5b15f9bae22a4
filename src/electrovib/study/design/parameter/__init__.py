"""The value of one parameter that gives a wanted quantity."""

from electrovib.study.design.parameter.function import design_parameter

__all__ = ["design_parameter"]
