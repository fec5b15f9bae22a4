"""Files of foreign programs and instruments, one format a file."""
