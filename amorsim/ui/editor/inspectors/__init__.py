"""The things of a scenario and their inspectors: forms, fields and places."""
