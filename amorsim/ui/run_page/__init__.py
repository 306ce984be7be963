"""A recorded run as one HTML file, with the Simulator's own scripts: it plays without a server."""
