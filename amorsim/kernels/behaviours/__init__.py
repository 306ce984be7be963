"""The decisions of controllers and motions, row by row."""
