"""What a number, a model and a result are."""
