"""What a notebook and an IPython terminal show of a Scenario, a Trace, a sweep and a plot."""

from electrovib.view.notebook.hooks import register

__all__ = ["register"]
