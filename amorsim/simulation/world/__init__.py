"""The world in the engine: bodies, floor and lamps, and lines of sight."""
