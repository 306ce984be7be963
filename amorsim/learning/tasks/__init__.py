"""The tasks that come with amorsim."""
