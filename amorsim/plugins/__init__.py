"""Plugins: their hooks (hooks), what they register (registry), how they are found (manager)."""
