"""What is simulated: scenarios as Python objects, and their files."""
