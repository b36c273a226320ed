"""Results as text and HTML for people; nothing is computed here.

In come the results of the rooms below; out go sections for the terminal, summary.txt, report.html and cost.html.
- `parts`: a section for each kind of result: fit, comparison, diagnosis, prediction, plan of tests, uncertainty; and
  for what a scene's solution, plan, draws and sweep say
- `page`: a whole report as data, the one HTML page that shows any report, the same printed as PDF; the first two pages
  of a campaign's, which are handed over
- `campaign`: summary and report of a campaign or a trial table, written as files; `pictures`: its figures
- `cost_page`: what accuracy costs, as HTML and Markdown
"""
