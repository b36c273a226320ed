// Step 3: the law that the trials support, its fit, open questions, and conditions switched on and off.
import { $, call, calm, fail, fill, listed, make, plain, readAgain, shown, step, tableRow, unit, withStd, work } from "./frame.js";
import { chart } from "./canvas.js";

export const L = { told: null };
const COLORS = 6, SUPPORTED = { yes: "supported", no: "not supported", "cannot-tell": "undetermined" };

async function load() {
  const told = await call("law");
  $("l-computing").textContent = told.computing ? `computing (${told.computing})` : "";
  if (told.computing) {
    setTimeout(() => { if (shown() === "law") load().catch(fail); }, 400);
    return;
  }
  L.told = told;
  $("l-all").hidden = false;
  show();
}

function show() {
  const told = L.told;
  $("l-law").textContent = told.law;
  $("l-verdict").textContent = told.verdict.word;
  $("l-verdict").className = `badge${told.verdict.word === "supported" ? "" : " ask"}`;
  $("l-how").textContent = told.how;
  $("l-equation").textContent = told.equation;
  $("l-reason").textContent = told.verdict.reason;
  const series = $("l-series"), chosen = series.value;
  series.replaceChildren(new Option("all wheels and loads", ""), ...told.series.map((one, place) => new Option(one.name, place)));
  series.value = told.series[chosen] ? chosen : "";
  fill($("l-laws"), ["law", "verdict", "Δ AICc", "weight", "k", "error at unseen conditions", "note"], told.ranking.map((one) => {
    const button = make("button", one.law), cell = make("td");
    button.onclick = () => useLaw(one.law === told.asked ? "" : one.law);
    button.setAttribute("aria-pressed", String(one.law === told.law));
    button.title = one.law === told.asked ? "leave the choice to the comparison" : "use this law";
    cell.append(button);
    const error = one.loco_error === null ? "–" : `${plain(100 * one.loco_error, 3)} %`;
    const made = tableRow([cell, told.verdicts[one.law] ?? one.status, plain(one.delta_aicc, 3), plain(one.weight, 2), String(one.k), error, one.note]);
    if (one.law === told.law) made.className = "used";
    return made;
  }));
  fill($("l-parameters"), ["", "value", "95 % interval"], Object.entries(told.fit.parameters).map(([name, one]) =>
    [name, withStd(one.value, one.std, one.unit ?? ""), `[${plain(one.ci95?.[0])}, ${plain(one.ci95?.[1])}]`]));
  fill($("l-conditions"), ["condition", "kept", "mean", "s", ""], told.conditions.map((one) => {
    const button = make("button", one.off ? "Switch on" : "Switch off…"), cell = make("td");
    button.onclick = () => switchOf(one);
    button.setAttribute("aria-label", `${button.textContent} ${one.words}`);
    cell.append(button);
    const made = tableRow([one.words + (one.off ? ` (${one.off})` : ""), `${one.n_kept} of ${one.n}`, unit(one.mean_N, "N"), unit(one.std_N, "N", 2), cell]);
    if (one.off) made.className = "off";
    return made;
  }));
  $("l-summary").textContent = told.diagnosis.summary;
  $("l-causes").replaceChildren(...told.diagnosis.causes.flatMap((one) =>
    [make("dt", `${one.cause}: ${SUPPORTED[one.supported]}`), make("dd", `${one.evidence}. To decide: ${one.experiment}.`)]));
  listed($("l-doubts"), told.doubts);
  $("l-plan").hidden = !told.prediction;
  draw();
}
function draw() {
  if (!L.told) return;
  const chosen = $("l-series").value, some = L.told.series.map((one, place) => ({ ...one, color: `s${place % COLORS}` }))
    .filter((_, place) => chosen === "" || place === Number(chosen));
  chart($("l-plot"), { series: chosen === "" ? some.map((one) => ({ ...one, band: [] })) : some, x: "wrap φ [deg]", y: "F_A [N]" });
  chart($("l-residuals"), { series: some.map((one) => ({ color: one.color, points: one.residuals })), x: "wrap φ [deg]", y: "[%]", zero: true });
  const worst = Math.max(...some.flatMap((one) => one.residuals.map(([, off]) => Math.abs(off))));
  $("l-residuals").setAttribute("aria-label", `Residuals over the wrap, at most ${plain(worst, 2)} %`);
}

async function useLaw(law) {
  try { await call("use-law", {}, { law }); await load(); } catch (error) { fail(error); }
}

let asked = null;
function switchOf(one) {
  if (one.off) return send(one, "");
  asked = one;
  $("switch-what").textContent = `Why is ${one.words} switched off? All its trials are excluded.`;
  $("switch-text").value = "";
  return $("switch").showModal();
}
async function send(one, text) {
  calm();
  try { await call("switch", {}, { trial: one.trial, text }); await load(); } catch (error) { fail(error); }
}
$("switch-yes").onclick = () => {
  const text = $("switch-text").value.trim();
  if (!text) return $("switch-text").focus();
  $("switch").close();
  return send(asked, text);
};
$("switch-no").onclick = () => $("switch").close();
$("switch-text").onkeydown = (event) => { if (event.key === "Enter") { event.preventDefault(); $("switch-yes").click(); } };

$("l-plan").onclick = async () => {
  try {
    const told = await work("plan", {});
    $("l-planned").hidden = false;
    $("l-planned").textContent = told.text;
  } catch (error) { fail(error); }
};
$("l-series").onchange = draw;
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", draw);
new ResizeObserver(() => { if (shown() === "law") draw(); }).observe($("l-plot"));
step("law", load, readAgain);
