"""Signals of many fingers in arrays over fingers: linear layers, a fixed gap and one drive that all fingers share."""
