"""amorsim beside its peers: `python -m benchmarks` runs all in turn and writes a table. It installs nothing."""
