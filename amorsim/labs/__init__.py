"""The labs that come with amorsim: exercises of a course, found and copied for a student."""

from amorsim.labs.labs import Lab, find_lab, find_labs, own_lab, start_lab
from amorsim.labs.notebook import NOTEBOOK, write_notebook

__all__ = ["NOTEBOOK", "Lab", "find_lab", "find_labs", "own_lab", "start_lab", "write_notebook"]
