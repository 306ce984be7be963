"""Reports: one HTML file for a run, a study or a comparison, which needs nothing but itself."""
