"""Reading: from the tables of a file to checked values, with every fault at its place."""
