"""The value of a parameter at which a quantity is as wanted for a share of a population."""

from electrovib.studies.design.share.function import value_for_share as value_for_share
from electrovib.studies.design.share.result import DesignedForShare as DesignedForShare
