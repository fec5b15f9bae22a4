"""Comparison of all force laws on one stack, how much they differ and why; and of materials in one stack."""

from electrovib.study.compare.laws import compare as compare
from electrovib.study.compare.materials import MaterialComparison as MaterialComparison
from electrovib.study.compare.materials import MaterialEntry as MaterialEntry
from electrovib.study.compare.materials import compare_materials as compare_materials
from electrovib.study.compare.result import Comparison as Comparison
from electrovib.study.compare.result import Entry as Entry
from electrovib.study.compare.static import static_force as static_force
