// The tour without a server: recorded states, drawn as the explorer draws them. Each step is a script of
// its own, which is loaded when it is first shown; toy.js, which draws the toy, is that of the explorer.
"use strict";
const $ = (selector) => document.querySelector(selector);
const make = (name, text, more = {}) => Object.assign(document.createElement(name), { textContent: text }, more);
const INK = "#252525", GREY = "#969696", PALE = "#d9d9d9", STABLE = "#006096", UNSTABLE = "#d95f0e", JUMP = "#238b45", NOW = "#6a51a3";
const STRUCK = { 1: "#d95f0e", 2: "#238b45", 3: "#6a51a3" }, BOTH = "#cb181d", SHARES = { I: "50%", J: "12%", S: "12%", D: "12%" };
const sign = (text) => text.replace("-", "−");
const colour = (contacts) => contacts.length > 1 ? BOTH : STRUCK[contacts[0]];

// --- Figures: axes on a canvas, drawn once; what moves is put on top ------------------------------------
class Figure {
  constructor(canvas) { this.canvas = canvas; this.still = document.createElement("canvas"); }
  // Axes over intervals x and y; paint draws into them. Names of axes have subscripts in braces.
  set(told, x, y, names, paint) { Object.assign(this, { x, y, names, paint }); this.canvas.setAttribute("aria-label", told); this.wide = 0; }
  lay() {
    const scale = devicePixelRatio || 1, box = this.canvas.getBoundingClientRect();
    const wide = Math.round(box.width * scale), tall = Math.round(box.height * scale);
    if (wide === this.wide && tall === this.tall) return;
    Object.assign(this, { wide, tall, scale });
    for (const each of [this.canvas, this.still]) { each.width = wide; each.height = tall; }
    this.frame = { left: 60 * scale, right: wide - 20 * scale, top: 10 * scale, bottom: tall - 40 * scale };
    this.pen = this.still.getContext("2d");
    this.axes(); this.inside(this.pen, () => this.paint(this));
  }
  at(p, q) {
    const { left, right, top, bottom } = this.frame, [x0, x1] = this.x, [y0, y1] = this.y;
    return [left + (right - left) * (p - x0) / (x1 - x0), bottom - (bottom - top) * (q - y0) / (y1 - y0)];
  }
  inside(pen, draw) {
    const { left, right, top, bottom } = this.frame;
    pen.save(); pen.beginPath(); pen.rect(left, top, right - left, bottom - top); pen.clip(); draw(); pen.restore();
  }
  ticks([low, high], most) {
    const rough = (high - low) / most, unit = 10 ** Math.floor(Math.log10(rough));
    const step = unit * [1, 2, 5, 10].find((k) => k * unit >= rough), found = [];
    for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k++) found.push([k * step, (k * step).toFixed(Math.max(0, -Math.floor(Math.log10(step) + 1e-9)))]);
    return found;
  }
  axes() {
    const { pen, scale, frame: { left, right, top, bottom } } = this, small = `${12 * scale}px system-ui, "DejaVu Sans", sans-serif`;
    pen.clearRect(0, 0, this.wide, this.tall);
    pen.font = small; pen.lineWidth = scale; pen.fillStyle = INK; pen.strokeStyle = PALE;
    for (const [value, text] of this.ticks(this.x, (right - left) / scale / 64)) {
      const [px] = this.at(value, 0);
      pen.beginPath(); pen.moveTo(px, top); pen.lineTo(px, bottom); pen.stroke();
      pen.textAlign = "center"; pen.fillText(sign(text), px, bottom + 15 * scale);
    }
    for (const [value, text] of this.ticks(this.y, (bottom - top) / scale / 42)) {
      const [, py] = this.at(0, value);
      pen.beginPath(); pen.moveTo(left, py); pen.lineTo(right, py); pen.stroke();
      pen.textAlign = "right"; pen.fillText(sign(text), left - 5 * scale, py + 4 * scale);
    }
    pen.strokeStyle = GREY; pen.strokeRect(left, top, right - left, bottom - top);
    this.name(this.names[0], (left + right) / 2, this.tall - 8 * scale);
    pen.save(); pen.translate(13 * scale, (top + bottom) / 2); pen.rotate(-Math.PI / 2); this.name(this.names[1], 0, 0); pen.restore();
  }
  name(text, x, y) {
    const { pen, scale } = this, font = (size) => `${size * scale}px system-ui, "DejaVu Sans", sans-serif`;
    const pieces = text.split(/[{}]/).map((part, k) => k % 2 ? [part, 10, 3] : [part, 13, 0]);
    const widths = pieces.map(([word, size]) => { pen.font = font(size); return pen.measureText(word).width; });
    let place = x - widths.reduce((sum, w) => sum + w, 0) / 2;
    pen.textAlign = "left"; pen.fillStyle = INK;
    pieces.forEach(([word, size, down], k) => { pen.font = font(size); pen.fillText(word, place, y + down * scale); place += widths[k]; });
  }
  line(xs, ys, color, wide = 1.8, dash = [], pen = this.pen) {
    pen.beginPath(); xs.forEach((x, k) => pen.lineTo(...this.at(x, ys[k])));
    pen.setLineDash(dash.map((d) => d * this.scale)); pen.strokeStyle = color; pen.lineWidth = wide * this.scale; pen.lineJoin = "round"; pen.stroke(); pen.setLineDash([]);
  }
  dot(x, y, color, size = 4, hollow = false, pen = this.pen) {
    pen.beginPath(); pen.arc(...this.at(x, y), size * this.scale, 0, 7);
    pen.lineWidth = 1.6 * this.scale; pen.strokeStyle = hollow ? color : "white"; pen.fillStyle = color;
    if (!hollow) pen.fill();
    pen.stroke();
  }
  mark([x, y, label, marker, color], low) {
    const { pen, scale } = this, [px, py] = this.at(x, y), star = marker === "star", n = star ? 10 : 4;
    if (marker === "circle") this.dot(x, y, color, 4.5);
    else if (label) {
      pen.beginPath();
      for (let k = 0; k < n; k++) { const r = (star ? (k % 2 ? 3 : 8) : 5.5) * scale, a = Math.PI * (2 * k / n - 0.5); pen.lineTo(px + r * Math.cos(a), py + r * Math.sin(a)); }
      pen.closePath(); pen.fillStyle = color; pen.strokeStyle = "white"; pen.lineWidth = scale; pen.fill(); pen.stroke();
    }
    pen.font = `${12 * scale}px system-ui, "DejaVu Sans", sans-serif`; pen.textAlign = "center"; pen.fillStyle = INK;
    if (/^[A-C]$/.test(label)) pen.fillText(label, px, py + (low ? 20 : -11) * scale);
  }
  // The figure with what is there at an instant.
  show(draw) {
    if (!this.paint) return;
    this.lay();
    const pen = this.canvas.getContext("2d");
    pen.clearRect(0, 0, this.wide, this.tall); pen.drawImage(this.still, 0, 0);
    if (draw) this.inside(pen, () => draw(pen));
  }
}

// --- What is drawn of a state ---------------------------------------------------------------------------
const around = (values, room = 0.06) => {
  const low = Math.min(...values), high = Math.max(...values), more = room * (high - low || 1);
  return [low - more, high + more];
};
const drawings = {
  map(figure, step, state) {
    const { window: w, parts, jumps, crossings, fixed, stable } = state.map;
    const told = `map P${"₁₂₃₄"[state.order - 1]}`;
    figure.set("return map with the diagonal, and how returns follow each other", w, w, ["φ{S,k} [rad]", `φ{S,k+${state.order}} [rad]`], (f) => {
      f.line(w, w, GREY, 1);
      for (const [a, b, c, d] of jumps) f.line([a, c], [b, d], GREY, 1, [2, 3]);
      for (const [x, y] of parts) f.line(x, y, STABLE, 1.6);
      for (const [a, b, c, d] of crossings) { f.line([a, c], [b, d], JUMP, 2, [2, 3]); f.dot((a + c) / 2, (a + c) / 2, JUMP, 6, true); }
      const web = state.cobweb.flatMap((x, k, all) => k ? [[all[k - 1], x], [x, x]] : [[x, x]]);
      f.line(web.map(([x]) => x), web.map(([, y]) => y), NOW, 1.2);
      fixed.forEach((x, k) => f.dot(x, x, stable[k] ? STABLE : UNSTABLE, 4.5, !stable[k]));
    });
    return [`return ${told}: jumps dotted, crossings green, orbit violet`, () => null];
  },
  diagram(figure, step, state) {
    const { lines, points } = step.diagram, low = around(lines.flatMap(([, , , x]) => x), 0.1);
    figure.set("branches over the restitution of the beak", [-0.01, 1.01], low, ["ε{N1} [–]", "φ{S} [rad]"], (f) => {
      for (const [color, dash, p, x] of lines) f.line(p, x, color, 2, dash);
      for (const point of points) f.mark(point, point[2] === "C");
    });
    const x = state.motion.phi_s[0];
    return ["branches: solid stable, dashed unstable, dotted jump crossings", (f, now, pen) => {
      f.line([state.eps_n1, state.eps_n1], low, GREY, 1, [], pen); f.dot(state.eps_n1, x, NOW, 6, true, pen);
    }];
  },
  motion(figure, step, state) {
    const { t, phi_s: s, phi_m: m } = state.motion;
    const range = around([...s, ...m]);
    figure.set("angles of the bird and of the sleeve over time", [0, t[t.length - 1]], range, ["t [ms]", "φ [rad]"], (f) => {
      f.line(t, s, STABLE); f.line(t, m, INK, 1.2, [5, 3]);
      for (const [symbol, time, , contacts] of state.marks) if (symbol[0] === "I") f.dot(time, value(state.motion, time, "phi_s"), colour(contacts));
    });
    return ["histories: solid φ of the bird, dashed of the sleeve, dots impacts", (f, now, pen) => f.line([now.time, now.time], range, NOW, 1.4, [], pen)];
  },
  portrait(figure, step, state) {
    const a = state.motion[step.portrait], rate = state.motion[step.rate], { t } = state.motion, bird = step.portrait === "phi_s";
    figure.set("phase portrait", around(a), around(rate), [`φ{${bird ? "S" : "M"}} [rad]`, `dφ{${bird ? "S" : "M"}}/dt [rad/s]`], (f) => {
      let from = 0;
      for (let k = 1; k <= t.length; k++) if (k === t.length || t[k] === t[k - 1]) { // an impact: time stands still
        f.line(a.slice(from, k), rate.slice(from, k), STABLE);
        const struck = k < t.length && state.marks.find(([, time]) => Math.abs(time - t[k]) < 2e-3);
        if (struck) f.line([a[k - 1], a[k]], [rate[k - 1], rate[k]], colour(struck[3]), 1.8, [4, 3]);
        from = k;
      }
    });
    return [`phase portrait of the ${bird ? "bird" : "sleeve"}: broken strokes are impacts`, (f, now, pen) => f.dot(now.value(step.portrait), now.value(step.rate), NOW, 5, false, pen)];
  },
};
// Two figures for the views of a step: the histories beside what has no partner.
const shown_of = (views) => {
  const wanted = ["portrait", "map", "diagram"].filter((name) => views.includes(name));
  return [...wanted, "motion", "portrait"].slice(0, 2);
};

// --- The motion -----------------------------------------------------------------------------------------
const row_at = (data, time) => { // the last sample that is not later
  let low = 0, high = data.t.length - 1;
  while (high - low > 1) { const middle = (low + high) >> 1; if (data.t[middle] <= time) low = middle; else high = middle; }
  return data.t[high] <= time ? high : low;
};
const value = (data, time, name) => {
  const k = Math.min(row_at(data, time), data.t.length - 2), run = data.t[k + 1] - data.t[k];
  return run > 0 ? data[name][k] + (time - data.t[k]) / run * (data[name][k + 1] - data[name][k]) : data[name][k + 1];
};
const tour = {
  TITLES: 10, taken: {}, wanted: 0, number: 0, chosen: 0, time: 0, playing: false, last: 0, lit: { 1: 0, 2: 0, 3: 0 }, figures: [],
  // Show a step, as soon as its data are there.
  go(number) {
    this.wanted = Math.min(Math.max(1, number), this.TITLES);
    if (this.taken[this.wanted]) return this.step();
    document.head.append(make("script", "", { src: `${String(this.wanted).padStart(2, "0")}.js` }));
  },
  take(number, step) { this.taken[number] = step; if (number === this.wanted) this.step(); },
  step() {
    const step = this.taken[this.wanted];
    Object.assign(this, { number: this.wanted, now: step });
    $("#told h2").textContent = `${this.number}. ${step.title} (${step.figure})`;
    $("#told p").textContent = step.text;
    $("#link").textContent = `?${step.link}`;
    for (const button of $("#steps").children) button.toggleAttribute("aria-current", +button.textContent === this.number);
    $("#back").disabled = this.number === 1; $("#next").disabled = this.number === this.TITLES;
    const several = step.states.length > 1 ? step.states : [];
    $("#switch").replaceChildren(...several.map((state, k) => make("button", state.label, { onclick: () => this.choose(k) })));
    if (location.hash !== `#${this.number}`) history.replaceState(null, "", `#${this.number}`);
    this.choose(0);
  },
  choose(k) {
    const state = this.now.states[k];
    Object.assign(this, { chosen: k, state, time: 0, row: 0, held: -1 });
    [...$("#switch").children].forEach((button, j) => button.setAttribute("aria-pressed", j === k));
    this.figures = shown_of(this.now.views).map((name, j) => {
      const view = $(j ? "#view-second" : "#view-first"), figure = new Figure(view.querySelector("canvas"));
      const [told, moving] = drawings[name](figure, this.now, state);
      view.querySelector("h3").textContent = told;
      return [figure, moving];
    });
    const written = (v, digits, unit) => v === null ? "none" : sign(v.toFixed(digits)) + unit, n = state.numbers;
    const numbers = [["restitution", `${state.eps_n1}`], ["friction", state.law === "summed" ? "of the sum" : "by contact"], ["start", written(n.phi_s, 6, " rad")],
      ["multiplier", written(n.multiplier, 5, "")], ["period", n.period === null ? "none" : written(1e3 * n.period, 4, " ms")], ["fall", written(1e3 * n.drop, 4, " mm")]];
    $("#numbers").replaceChildren(...numbers.flatMap(([name, text]) => [make("dt", name), make("dd", text)]));
    $("#word").classList.toggle("long", state.marks.length > 14);
    $("#word").replaceChildren(...state.marks.map(([symbol, time, , contacts], j) => {
      const button = make("button", symbol, { onclick: () => this.event(j), title: `${time.toFixed(2)} ms` });
      button.append(make("small", time.toFixed(2)));
      button.style.setProperty("--contact", colour(contacts)); button.style.setProperty("--share", SHARES[symbol[0]] ?? "12%");
      return button;
    }));
    toy.fit(state.shape, state.motion);
    this.show(0);
  },
  get end() { return this.state.motion.t[this.state.motion.t.length - 1]; },
  // The event that was asked for, of several at one instant, or the last one; -1 before the first.
  get last_event() {
    const { marks } = this.state;
    return marks[this.held]?.[1] === this.time ? this.held : marks.findLastIndex(([, time]) => time <= this.time);
  },
  event(k) { // to an event, right after it; to the start or the end beyond the first and the last
    const mark = this.state.marks[k];
    Object.assign(this, { held: k, time: mark ? mark[1] : k < 0 ? 0 : this.end, row: -1 });
    for (const c of [1, 2, 3]) this.lit[c] = mark?.[3].includes(c) ? 1 : 0;
    this.play(false); this.show(0);
  },
  play(on) { this.playing = on; $("#play").textContent = on ? "❚❚" : "▶"; $("#play").setAttribute("aria-pressed", on); },
  frame(now) {
    requestAnimationFrame((next) => this.frame(next));
    const elapsed = Math.min(100, now - this.last);
    this.last = now;
    if (!this.state || document.hidden) return;
    const glows = [1, 2, 3].some((k) => this.lit[k] > 0 && this.lit[k] < 1);
    if (this.playing) { this.time += elapsed / +$("#speed").value; if (this.time > this.end) { this.time %= this.end; this.row = -1; } }
    if (this.playing || glows) this.show(elapsed);
  },
  show(elapsed) {
    const { motion: data, shape } = this.state, row = row_at(data, this.time);
    let bits = data.closed[row];
    for (let k = (this.row ?? -1) + 1; this.row >= 0 && k <= row; k++) bits |= data.closed[k];
    this.row = row;
    for (const k of [1, 2, 3]) this.lit[k] = bits >> (k - 1) & 1 ? 1 : Math.max(0, this.lit[k] - elapsed / toy.LIGHT);
    const at = (name) => value(data, this.time, name), q = [at("y") / 1000, at("phi_m"), at("phi_s")];
    toy.draw($("#toy"), shape, q, this.lit, toy.height(data, this.time, q[0]));
    for (const [figure, moving] of this.figures) figure.show((pen) => moving(figure, { time: this.time, value: at }, pen));
    const k = this.last_event, mark = this.state.marks[k];
    [...$("#word").children].forEach((button, j) => button.toggleAttribute("aria-current", j === k));
    const told = mark ? `${mark[0]} at ${mark[1].toFixed(3)} ms, ${mark[2]}: ${[mark[4], mark[5]].filter(Boolean).join("; ")}`.replace(/;$/, "").replace(/-(?=[\d.])/g, "−") : "the start: at rest, the sleeve jams";
    if ($("#event").textContent !== told) $("#event").textContent = told;
    if (document.activeElement !== $("#instant") || this.playing) $("#instant").value = this.time / this.end;
  },
};
for (let k = 1; k <= tour.TITLES; k++) $("#steps").append(make("button", k, { onclick: () => tour.go(k) }));
$("#back").onclick = () => tour.go(tour.number - 1);
$("#next").onclick = () => tour.go(tour.number + 1);
$("#before").onclick = () => tour.event(tour.last_event - 1);
$("#after").onclick = () => tour.event(tour.last_event + 1);
$("#play").onclick = () => tour.play(!tour.playing);
$("#instant").oninput = () => { tour.play(false); tour.row = -1; tour.time = +$("#instant").value * tour.end; tour.show(1e3); };
addEventListener("keydown", (pressed) => {
  if (pressed.ctrlKey || pressed.metaKey || pressed.altKey || !tour.now) return;
  const on = pressed.target, own = on.matches?.("input, select") ?? false;
  const keys = { ArrowLeft: () => own || tour.go(tour.number - 1), ArrowRight: () => own || tour.go(tour.number + 1), ",": () => $("#before").click(), ".": () => $("#after").click(), " ": () => on.matches?.("button, input, select") || $("#play").click() };
  if (!(pressed.key in keys)) return;
  const left = keys[pressed.key]();
  if (left !== true) pressed.preventDefault();
});
addEventListener("hashchange", () => tour.go(+location.hash.slice(1) || 1));
addEventListener("resize", () => tour.state && tour.show(0));
tour.play(!matchMedia("(prefers-reduced-motion: reduce)").matches);
tour.go(+location.hash.slice(1) || 1);
requestAnimationFrame((now) => tour.frame(now));
