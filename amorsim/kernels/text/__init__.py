"""Numbers as text, and the fingerprint of results."""
