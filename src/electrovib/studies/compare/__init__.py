"""Comparison of all force laws on one stack, how much they differ and why; and of materials in one stack."""

from electrovib.studies.compare.laws import compare as compare
from electrovib.studies.compare.materials import MaterialComparison as MaterialComparison
from electrovib.studies.compare.materials import compare_materials as compare_materials
from electrovib.studies.compare.result import Comparison as Comparison
