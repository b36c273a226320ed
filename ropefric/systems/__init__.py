"""Machines that live on friction between a rope, belt or blade and a wheel: their pure mechanics."""
