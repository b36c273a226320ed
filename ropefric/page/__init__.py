"""The page in the browser for the whole job: recordings, picks, the law, wheels and machines, the report.

In: a folder of recordings, or a campaign. `desk` holds what one person works on, and what each address does;
`recordings` turns a folder into a campaign that can be corrected before it is written; `review` holds the trials, puts
decisions beside their list and computes anew what they change; `answers` say of a law and of machines what the commands
say; `server` lets one browser on this machine see and do it, with the page in `static/`.
Out: campaign.toml, trials.csv, decisions.csv and a folder of results, the very files that the commands write.

The server is Python's own `http.server`, the page plain HTML, script modules and canvas: a few addresses for one person
on the loopback address need no framework, so no package is installed for it, nothing is fetched, and it works offline.
"""
