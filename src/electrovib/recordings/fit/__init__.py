"""Parameters from data: least squares with exact derivatives, intervals, and what the data do not determine."""
