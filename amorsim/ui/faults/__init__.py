"""The page of a scenario that has faults: what is wrong, and what can be drawn, until the file is mended."""
