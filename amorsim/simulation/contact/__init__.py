"""Contact: which bodies meet in a step, and where each stops."""
