"""Trial tables and friction laws -> fitted parameters with honest uncertainty."""
