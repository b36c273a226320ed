"""A rope on a wheel that lifts: from the end tension to the lift force."""
