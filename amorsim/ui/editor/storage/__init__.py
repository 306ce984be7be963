"""Files of the Editor: texts, maps and pictures that are edited, and where they are kept."""
