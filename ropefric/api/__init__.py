"""The functions of `import ropefric as rf`: what notebooks and scripts need, each a call into its room.

`recordings` goes from files to break-away forces and trial tables, `models` from there to laws, lift forces, designs and
scenes. Each is loaded on the first use of one of its functions, see `ropefric.__getattr__`.
"""
