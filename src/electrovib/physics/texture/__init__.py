"""Textures that a plate renders, and paths of the finger over them."""
