"""Pictures of runs, studies and comparisons, by Matplotlib."""
