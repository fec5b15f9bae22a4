"""One layer with non-ohmic conduction."""
