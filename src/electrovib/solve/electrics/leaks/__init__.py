"""One layer that conducts out of proportion to its field."""
