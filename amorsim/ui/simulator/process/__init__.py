"""The child process that simulates: its commands, its threads, and its pipes."""
