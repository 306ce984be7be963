"""The commands about scenarios and their maps."""
