"""Files: measured tables and Traces."""
