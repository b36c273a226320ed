"""The commands, found by themselves: functions that `@command` declares, those of one subject in one file.

`browser` opens the page for the whole job; `start` before a campaign, and plugins tried; `campaign` from its recordings
to its report; `laws` fitted and compared, lift forces by a fit with their uncertainty; `scenes` solved and
explained, and the studies of accuracy.
"""
