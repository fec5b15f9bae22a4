"""Many scenarios: sweeps, populations, comparisons, inverse questions, what is felt."""
