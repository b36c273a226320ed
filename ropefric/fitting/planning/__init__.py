"""Which conditions to test next, so that a prediction becomes as certain as it can."""
