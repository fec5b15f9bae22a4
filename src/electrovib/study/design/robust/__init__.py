"""Value of one parameter for a share of a population."""

from electrovib.study.design.robust.function import design_for_share
from electrovib.study.design.robust.result import DesignedForShare, ShareAt

__all__ = ["DesignedForShare", "ShareAt", "design_for_share"]
