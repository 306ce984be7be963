"""The window's server: one door, pages, and a WebSocket for each window."""
