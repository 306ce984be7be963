"""Logs of real robots and of other programs: read, written, and replayed through estimators."""
