"""Figures 6 and 7 for a population of fingers, under law (1) and with the Maxwell stress in the gap."""

from electrovib.papers.vezzoli_2014.population.predicted import Predicted, predicted
from electrovib.papers.vezzoli_2014.population.shown import panels, rows, table

__all__ = ["Predicted", "panels", "predicted", "rows", "table"]
