"""Worlds of Player/Stage: ``.world`` files, with the ``.inc`` files and bitmaps that they name."""
