"""When sensors read, and what happens to their readings."""
