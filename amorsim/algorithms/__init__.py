"""Methods of the field as plain mathematics over arrays: nothing here knows of a simulation or of a file."""
