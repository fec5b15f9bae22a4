"""Textures as drives: of a whole path of the finger, and block by block while it moves."""
