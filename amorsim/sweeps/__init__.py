"""Studies: a scenario over axes, seeds and replicas, in as many processes and machines as there are."""
