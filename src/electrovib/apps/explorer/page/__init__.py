"""The page itself: controls, plots and what connects them to a session."""

from electrovib.apps.explorer.page.build import build as build
