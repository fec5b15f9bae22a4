"""Display of scenarios, Traces, sweeps, tables and plots in notebooks and IPython terminals."""

from electrovib.view.notebook.hooks import register

__all__ = ["register"]
