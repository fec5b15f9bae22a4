"""Formulas and models only: no files, no plots, no fits."""
