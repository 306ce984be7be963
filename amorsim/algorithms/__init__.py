"""Methods of the field as plain mathematics over arrays: nothing here knows of a simulation or of a file of a run."""

from amorsim.algorithms import pose_graph

__all__ = ["pose_graph"]
