"""One file for each publication, found automatically: its laws, values, scenarios and checks."""
