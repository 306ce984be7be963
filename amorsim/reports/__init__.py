"""Reports: one HTML file, complete in itself, for a run, a study or a comparison."""
