"""Results as text and HTML for people; nothing is computed here."""

__all__: list[str] = []
