"""The estimators of a group, in a simulation: what they are fed, and what is made of it."""
