"""Files of instruments as Traces and materials: columns as signals, calibrated, on one time axis, with their history."""
