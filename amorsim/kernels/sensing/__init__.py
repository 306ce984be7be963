"""When sensors read, and what becomes of what they read."""
