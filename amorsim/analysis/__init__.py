"""What to make of a run: its files as arrays, plots of them, and the reference pages of components."""
