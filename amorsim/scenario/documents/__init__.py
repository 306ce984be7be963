"""Documents: scenarios' files as their authors wrote them, changed in places and saved."""
