"""The commands, found by themselves: functions that `@command` declares, those of one subject in one file.

`start` before a campaign, `campaign` from its recordings to its report, `laws` fitted and compared, `wheels` that a
fit answers for, `budget` of an uncertainty, `scenes` solved and explained, the papers behind
them, and what accuracy costs; `extend` tries plugins and hands fits on to simulators.
"""
