"""The world as the engine holds it: bodies, floor and lamps, and what is in sight of whom."""
