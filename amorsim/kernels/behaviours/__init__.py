"""What controllers and motions decide, row by row."""
