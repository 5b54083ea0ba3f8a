// What the page of the toy has of its own: the tour, the numbers, and the clock of the motion.
"use strict";
const clock = {
  at: 0, playing: !matchMedia("(prefers-reduced-motion: reduce)").matches, last: 0, lit: { 1: 0, 2: 0, 3: 0 }, frames: 0, skipped: 0,
  model(name) { return explorer.model(name); },
  // The state at a part of the motion, between its samples.
  state(part) {
    const data = sketch.data(this.model("motion")), t = data.t, n = t.length;
    if (!n) return null;
    const time = part * t[n - 1];
    let low = 0, high = n - 1;
    while (high - low > 1) { const middle = (low + high) >> 1; if (t[middle] <= time) low = middle; else high = middle; }
    const w = t[high] > t[low] ? (time - t[low]) / (t[high] - t[low]) : 0;
    const value = (name) => data[name][low] + w * (data[name][high] - data[name][low]);
    return { time, low, value, closed: data.closed[low], end: t[n - 1], drop: data.y[n - 1], data };
  },
  // Contacts are lit while they are closed, and an impact for a while after it, in time of the eye.
  light(s, before, elapsed) {
    let bits = s.closed;
    for (let k = before + 1; k <= s.low; k++) bits |= s.data.closed[k];
    for (const k of [1, 2, 3]) this.lit[k] = bits >> (k - 1) & 1 ? 1 : Math.max(0, this.lit[k] - elapsed / toy.LIGHT);
  },
  frame(now) {
    requestAnimationFrame((next) => this.frame(next));
    if (!explorer.doc || !explorer.answer.shape) return;
    if (dragging && this.skipped++ % 4) return; // the slider comes first
    const elapsed = Math.min(100, now - this.last), before = this.row ?? -1;
    this.last = now;
    const s = this.state(this.at);
    if (!s || document.hidden) return;
    const lit = this.lit[1] + this.lit[2] + this.lit[3];
    const still = !this.playing && this.drawn === `${this.at} ${lit}` && this.fitted === s.data;
    if (still) return;
    if (this.playing && s.end > 0) {
      this.at += elapsed / (+$("#speed").value) / s.end;
      if (this.at > 1) { this.at %= 1; this.row = -1; }
    }
    this.show(elapsed, before);
  },
  show(elapsed, before) {
    const s = this.state(this.at);
    if (this.fitted !== s.data) { this.fitted = s.data; toy.fit(explorer.answer.shape, s.data); }
    this.light(s, s.low >= before ? before : -1, elapsed);
    const q = [s.value("y") / 1000, s.value("phi_m"), s.value("phi_s")];
    toy.draw($("#toy-canvas"), explorer.answer.shape, q, this.lit, toy.height(s.data, s.time, q[0]));
    this.row = s.low;
    this.drawn = `${this.at} ${this.lit[1] + this.lit[2] + this.lit[3]}`;
    // The cursors in other views follow more slowly, and slower still while a slider moves.
    if (this.frames++ % (dragging ? 3 : 2) === 0 || !this.playing) this.mark(s);
  },
  mark(s) {
    const rate = { phi_s: ["phi_s", "dphi_s"], phi_m: ["phi_m", "dphi_m"], fall: ["phi_s", "dy"] }[explorer.answer.portrait ?? "phi_s"];
    const times = sketch.data(this.model("events")).time ?? [];
    let k = 0; while (k < times.length && times[k] <= s.time) k++;
    sketch.put(this.model("instant"), { t: [s.time] });
    sketch.put(this.model("now"), { x: [s.value(rate[0])], y: [s.value(rate[1])] });
    sketch.put(this.model("word_now"), { x: [k - 0.5] });
    if (document.activeElement !== $("#instant") || this.playing) $("#instant").value = this.at;
  },
};
requestAnimationFrame((now) => clock.frame(now));
new ResizeObserver(() => { clock.drawn = ""; }).observe($("#toy-canvas")); // even where nothing moves
const play = (on) => { clock.playing = on; $("#play").textContent = on ? "❚❚" : "▶"; $("#play").setAttribute("aria-pressed", on); };
play(clock.playing);
$("#play").addEventListener("click", () => play(!clock.playing));
$("#instant").addEventListener("input", () => { play(false); clock.at = +$("#instant").value; });

const go = (step) => explorer.ask({ do: "tour", value: step });
$("#tour-begin").addEventListener("click", () => go(explorer.answer.tour?.step || 1));
$("#tour-back").addEventListener("click", () => go(Math.max(1, explorer.answer.tour.step - 1)));
$("#tour-next").addEventListener("click", () => go(explorer.answer.tour.step % explorer.answer.tour.of + 1));
$("#tour-end").addEventListener("click", () => go(0));

function show_tour(tour) {
  $("#tour").hidden = !tour.step;
  const lit = new Set(tour.views ?? []);
  for (const view of $$(".view")) view.classList.toggle("lit", lit.has(view.id.slice(5)));
  $("#law").classList.toggle("lit", lit.has("law"));
  if (!tour.step) return;
  $("#tour h2").textContent = `${tour.title} (${tour.figure})`;
  $("#tour p").textContent = tour.text;
  $("#tour-step").textContent = `${tour.step} of ${tour.of}`;
}
const NUMBERS = [
  ["multiplier", "multiplier", (v) => v.toFixed(5)], ["period", "period", (v) => (1e3 * v).toFixed(4) + " ms"],
  ["drop", "fall", (v) => (1e3 * v).toFixed(4) + " mm"],
];
$("#numbers").replaceChildren(...NUMBERS.flatMap(([name, text]) => {
  const term = document.createElement("dt"), value = document.createElement("dd");
  term.textContent = text;
  value.id = "number-" + name;
  return [term, value];
}));
function show_numbers(numbers) {
  for (const [name, , written] of NUMBERS) write("#number-" + name, numbers[name] == null ? "none" : written(numbers[name]));
}
explorer.heard.push((told) => {
  if (told.numbers) show_numbers(told.numbers);
  if (told.law) for (const each of $$("input[name=law]")) each.checked = each.value === told.law;
  if (told.tour) show_tour(told.tour);
});
