"""From a measuring campaign to its trial table.

In: campaign.toml, the trial list trials.csv, recordings. `campaign` reads and checks the two files, whose keys and rows
are `campaign_model` and `trial_list`, which also makes a list from the names of recordings; `proposal` begins both from
recordings; `decisions` reads and writes what people decided about trials. `extract` reads each
recording in the processes of `workers`; `result` groups them by condition and sets outliers aside by a rule of
`outliers`; the numbers of a trial, and where they are shown, are declared in `numbers`.
Out: an Extraction (`result`, also as CSV files), and from it, or from a CSV file or frame, the TrialTable (`table`) that
every fit starts from. `cells` is the reader of both tables, CSV or sheets.
"""
