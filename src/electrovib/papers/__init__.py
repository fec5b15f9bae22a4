"""One file for each publication: its laws, values, scenarios and checks. Found, never listed."""
