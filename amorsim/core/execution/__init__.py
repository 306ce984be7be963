"""Threads, processes, memory, and how work is shown and interrupted."""
