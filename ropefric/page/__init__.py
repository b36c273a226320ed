"""The page in the browser for the whole job: recordings, picks, the law, wheels and machines, the report.

In: a folder of recordings, or a campaign. `desk` holds the job of one person, and the function of each address;
`recordings` makes a campaign of a folder, or changes the settings of an existing one, checked before it is written;
`review` holds the trials, writes decisions beside their list and computes their effects; `answers` have the numbers of
the commands for a law and for machines; `work` runs what takes long in a thread; `server` serves one browser on this
machine, with the page in `static/`.
Out: campaign.toml, trials.csv, decisions.csv and a folder of results, the same files as the commands write.

The server is Python's own `http.server`; the page is plain HTML, script modules and canvas. A few addresses for one
person on the loopback address need no framework: no package is installed, nothing is fetched, and it works offline.
"""
