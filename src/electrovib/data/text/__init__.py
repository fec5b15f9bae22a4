"""How the text of an instrument is laid out: delimiter, headings, units, preamble, tables, dates."""
