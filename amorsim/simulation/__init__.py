"""The engine: robots as rows, and the phases of a step."""
