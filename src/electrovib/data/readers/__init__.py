"""Readers of foreign files: one format a file, found by its ``FORMAT``."""
