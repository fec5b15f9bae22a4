"""Questions to many scenarios: sweeps, studies, comparisons, designs, limits, sensitivity, evidence."""
