"""The window in the browser: a server, the Simulator's session behind it, forms, and the scripts that it shows."""
