"""The text of TOML files and its edits: statements, where each path is, changes that keep all other lines."""
