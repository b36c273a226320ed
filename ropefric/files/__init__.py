"""Files as such, whatever they hold: read without being held up or misled, written whole or not at all.

`read` opens what somebody named, regular files only, and gives hash and content of one and the same version. `text`
turns a text file into clean lines, `text_table` finds the layout of a table in it, `stamps` reads text time stamps.
`toml` reads TOML with the line of every key, `toml_model` its tables as pydantic models. `write` puts one file in place
of another, `folder` a command's results into a folder that is its own. `digits` says how many digits of a number are
worth writing, `plain_text` makes the text of others harmless for what shows it. `parquet` writes and reads tables so.
"""
