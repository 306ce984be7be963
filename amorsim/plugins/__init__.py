"""Plugins: what they are asked (hooks), what they register (registry), how they are found (manager)."""
