"""Who meets whom on the way, and where each stops."""
