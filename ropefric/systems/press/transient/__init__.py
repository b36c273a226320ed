"""The start-up of a belt press: elastic belts, prescribed drivers, slip and slack."""
