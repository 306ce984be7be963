"""What is kept of a simulation while it runs: the folder of a run, its files, and the same run again."""
