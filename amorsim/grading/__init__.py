"""Grading of controllers in files: each in a process of its own that knows no truth, with limits of time and memory."""
