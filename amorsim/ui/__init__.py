"""The Simulator in the browser: a child process that simulates, a session that keeps it, a window that shows it."""
