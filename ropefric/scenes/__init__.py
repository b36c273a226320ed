"""Scenes: one file that says what is to be solved and how exactly; what that takes is found out from it."""
