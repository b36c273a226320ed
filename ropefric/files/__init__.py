"""Files as such, whatever they hold: read without being held up or misled, written whole or not at all.

`write.py` writes one file, or several new ones; `folder.py` keeps the folder a command writes into: its list of
files, its lock, and what of an earlier run still fits. Whoever writes results gives names and contents to a `Folder`.
"""
