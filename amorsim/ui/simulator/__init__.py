"""The Simulator behind its window: a session, and the child process that simulates."""
