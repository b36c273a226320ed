"""Files as such, whatever they hold: read without being held up or misled, written whole or not at all."""
