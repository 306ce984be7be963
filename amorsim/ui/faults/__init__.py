"""The page of a faulty scenario: its faults, and what can be drawn, until the file is mended."""
