"""Review of picks in the browser: a person looks at recordings and decides, the campaign's own list keeps it.

In: a campaign. `session` holds its trials, says what a page shows of
them, puts decisions into the bytes of the trial list and computes anew what they change; `server` lets one browser on
this machine see and do it, with the page `page.html`.
Out: cells of the trial list; everything else follows from it the next time the campaign is run.

The server is Python's own `http.server` and the page plain HTML, script and canvas, in one file: ten addresses for one
person on the loopback address need no framework, so no package is installed for it (there is no extra), nothing is
fetched, and it works offline and unchanged with every version of anything else.
"""
