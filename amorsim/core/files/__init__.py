"""Files that a user names: read safely, and written whole or not at all."""
