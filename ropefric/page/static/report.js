// Step 5: the report that `ropefric report` makes, shown in place.
import { $, enable, fail, refresh, state, step, token, work } from "./frame.js";

const WORDS = { "report.html": "the report", "summary.txt": "the short summary", "report.pdf": "the PDF" };

function show() {
  const which = $("p-which"), chosen = which.value;
  which.replaceChildren(...state.reports.map((name) => new Option(WORDS[name], name)));
  which.value = state.reports.includes(chosen) ? chosen : state.reports[0] ?? "";
  which.disabled = !state.reports.length;
  $("p-where").textContent = state.reports.length ? `The results are in ${state.out}.` : `The results will be written into ${state.out}.`;
  frame();
}
function frame() {
  const name = $("p-which").value, seen = $("p-frame"), link = $("p-link");
  seen.hidden = !name || name.endsWith(".pdf");  // a frame that may run nothing shows no PDF
  link.hidden = !name;
  // The frame can send no header, so its address holds the token; it has no script, and tells no other site from where it comes.
  if (name) link.href = `results/${name}?${new URLSearchParams({ token: token(), now: Date.now() })}`;
  if (!seen.hidden) seen.src = link.href;
}
$("p-make").onclick = async () => {
  enable($("p-make"), false);
  try {
    await work("report", { pdf: $("p-pdf").checked, short: $("p-length").value === "short" });
    await refresh();
    show();
  } catch (error) { fail(error); }
  enable($("p-make"), true);
};
$("p-which").onchange = frame;
step("report", async () => { await refresh(); show(); });
