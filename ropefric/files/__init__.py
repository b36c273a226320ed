"""Files as such, whatever they hold: read without being held up or misled, written whole or not at all.

`disk` opens named files, regular ones only, gives hash and content of one and the same version, and puts one
file in place of another; `folder` puts a command's results into a folder that is its own. `text` turns a text file
into clean lines, `text_table` finds the layout of a table in it and reads time stamps, `head_facts` the lines above
it. `toml` reads TOML with the line of every key, `toml_model` its tables as pydantic models; `toml_edit` changes
single values in the text and keeps all else. `plain_text` is for output: numbers to their significant digits, text of
others made harmless, rows as CSV and Parquet.
"""
