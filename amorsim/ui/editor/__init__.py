"""The Editor: a scenario's document and the walls of its map, changed by windows of the browser."""
