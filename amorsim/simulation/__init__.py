"""The engine: robots as rows, the phases of a step, and runs."""
