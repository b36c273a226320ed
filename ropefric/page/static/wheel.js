// Step 4, first half: the lift force of a wheel by the law, and the wheel that lifts a load.
import { $, call, fail, make, plain, shown, state, step, unit, withEnds } from "./frame.js";
import { chart } from "./canvas.js";
import { showMachines } from "./machine.js";

const SLIDERS = {  // words of a slider, its unit on the page, and that unit in SI
  wheel_radius_m: ["Radius R_w", "mm", 1e-3], wrap_angle_rad: ["Wrap φ", "deg", Math.PI / 180],
  end_tension_N: ["End tension F_B", "N", 1],
};
const NAMES = { wrap: ["wrap_angle_rad", "wrap"], radius: ["wheel_radius_m", "radius"], end_tension: ["end_tension_N", "end tension"] };
export const W = { told: null, at: {}, lift: null };

async function load() {
  showMachines();
  $("w-own").hidden = !state.ready;
  if (!state.ready) return;
  const told = await call("law");
  $("w-computing").textContent = told.computing ? `computing (${told.computing})` : `by ${told.law}`;
  if (told.computing) { setTimeout(() => { if (shown() === "wheel") load().catch(fail); }, 400); return; }
  $("w-all").hidden = false;
  const tested = told.fit.validity, middle = ([low, high]) => (low + high) / 2;
  if (!W.told) {
    W.at = { rope_radius_m: told.rope_radius_m };
    for (const name of Object.keys(SLIDERS)) W.at[name] = told.prediction?.[name] ?? middle(tested[name]);
  }
  W.told = told;
  $("w-sliders").replaceChildren(...Object.entries(SLIDERS).map(([name, [words, own, factor]]) => {
    const [low, high] = tested[name].map((x) => x / factor), line = make("div", "", "slider"), label = make("label");
    const range = make("input"), number = make("input");
    Object.assign(range, { type: "range", min: 0.5 * low, max: 1.5 * high, step: (high + low) / 2000, id: `w-${name}-range` });
    Object.assign(number, { type: "number", step: "any", min: 0, id: `w-${name}` });
    number.setAttribute("aria-label", `${words} [${own}]`);
    range.setAttribute("aria-label", `${words} [${own}], tested from ${plain(low)} to ${plain(high)}`);
    range.value = number.value = plain(W.at[name] / factor, 5);
    const move = (event) => {
      const value = Number(event.target.value);
      if (!(value > 0)) return;
      if (event.target === range) number.value = plain(value); else range.value = value;
      W.at[name] = Number(number.value) * factor;
      answer();
    };
    range.oninput = number.oninput = move;
    label.append(make("span", `${words} [${own}]`), range, number);
    line.append(label);
    return line;
  }));
  answer();
}

let busy = false, again = false;
async function answer() {  // one after the other: only the newest setting counts
  if (busy) { again = true; return; }
  busy = true;
  try {
    const [lift] = await Promise.all([call("lift", W.at), inverse()]);
    W.lift = lift;
    $("w-lift").textContent = `F_A = ${withEnds(lift.lift_force_N, lift.interval_N)}`;
    const pull = lift.prediction_interval_N;
    $("w-notes").textContent = [`One pull with a new rope: ${unit(pull?.[0], "N")} to ${unit(pull?.[1], "N")}. Verdict: ${lift.verdict.word}. ${lift.verdict.reason}`,
      ...(lift.extrapolated ? ["Outside the tested range."] : []), ...lift.notes].join(" ");
    draw();
  } catch (error) { $("w-lift").textContent = error.message ?? String(error); }
  busy = false;
  if (again) { again = false; answer(); }
}

function draw() {
  if (!W.lift) return;
  chart($("w-plot"), { series: [{ color: "s0", line: W.lift.line, band: W.lift.band }], x: "wrap φ [deg]", y: "F_A [N]",
    tested: W.lift.tested_deg, mark: W.at.wrap_angle_rad * 180 / Math.PI });
  const range = W.lift.tested_deg.map((x) => plain(x)).join("° to "), tested = range ? `tested from ${range}°` : "none of it tested";
  $("w-plot").setAttribute("aria-label", `Lift force over the wrap, ${tested}: ${$("w-lift").textContent}`);
}

async function inverse() {
  const load_N = Number($("w-load").value), wanted = $("w-for").value, [name, words] = NAMES[wanted];
  if (!(load_N > 0)) return;
  try {
    const found = await call("inverse", { ...W.at, lift_N: load_N, solve_for: wanted, probability: $("w-sure").value });
    const [, own, factor] = SLIDERS[name], value = found[name];
    $("w-inverse").textContent = found.status === "ok" || found.status === "lower-limit"
      ? `${words} ${plain(value / factor)} ${own} lifts ${plain(load_N)} N${found.extrapolated ? " (outside the tested range)" : ""}` : found.explanation;
  } catch (error) { $("w-inverse").textContent = error.message ?? String(error); }
}
$("w-load").oninput = $("w-for").onchange = $("w-sure").onchange = () => { if (W.told) inverse(); };
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", draw);
new ResizeObserver(() => { if (shown() === "wheel") draw(); }).observe($("w-plot"));
step("wheel", load);
