"""Design of a plate: insulator and drive within breakdown, current and perception."""
