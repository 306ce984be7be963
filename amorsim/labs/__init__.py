"""The labs that come with amorsim: exercises of a course, found and copied for a student."""

from amorsim.labs.labs import Lab, find_lab, find_labs, own_lab, start_lab

__all__ = ["Lab", "find_lab", "find_labs", "own_lab", "start_lab"]
