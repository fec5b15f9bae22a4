"""Plots of a page, as the tables that Plotly draws; nothing here knows the page."""
