"""Files of scenarios, models and maps: found, read, written and copied."""
