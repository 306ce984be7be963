"""Search on cells: shortest paths, fields of distances, lines of sight, and the room around cells."""
