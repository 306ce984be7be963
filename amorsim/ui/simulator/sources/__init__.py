"""What windows show, moment by moment: simulations that run, with their past, and recorded runs."""
