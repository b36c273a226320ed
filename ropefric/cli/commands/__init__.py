"""The commands, found by themselves: functions that `@command` declares, those of one subject in one file.

`browser` opens the page for the whole job; `start` before a campaign, and plugins tried; `campaign` from its recordings
to its report;
`laws` fitted and compared, the wheels that a fit answers for, with what is uncertain of it, and the fit handed on;
`scenes` solved and explained, and what accuracy costs.
"""
