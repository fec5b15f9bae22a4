"""Quantities of a scenario, requested by name."""

from electrovib.solve.quantities.answer import QuantityNumbers, answer, of_record
from electrovib.solve.quantities.names import DEFAULTS, Named, read_name
from electrovib.solve.quantities.resolve import solved
from electrovib.solve.quantities.together import Together

__all__ = ["DEFAULTS", "Named", "QuantityNumbers", "Together", "answer", "of_record", "read_name", "solved"]
