"""Users' programs: components in Python files, found, checked in a process of their own, and loaded."""
