"""Poses, and where wheels lead them."""
