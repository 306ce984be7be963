"""Readers of map files: line worlds (``.wld``) and bitmaps (``.bmp``, ``.png``)."""
