// The toy on a canvas. The geometry is that of woodpecker.plot.drawing: the beak and both edges of
// the sleeve are exactly as far from the pole as the gaps say [Leine2001, Eq. 8].
"use strict";
const toy = {
  WALL: 0.45, COILS: 6, LIGHT: 1000 / 6, // ms that an impact stays lit
  COLORS: { 1: "#d95f0e", 2: "#238b45", 3: "#6a51a3" },
  SHAPES: {"BARS": [[[1.02, 0.36], [1.25, 0.24]], [[1.06, 0.09999999999999998], [1.27, -0.030000000000000027]], [[1.1, -0.16000000000000003], [1.29, -0.30000000000000004]]], "BEAK": [[0.0, 1.0], [0.39, 1.1], [0.38, 0.91]], "BELLY": [[0.41, 0.89], [0.54, 0.9], [0.68, 0.72], [0.8, 0.42], [0.88, 0.05], [0.97, -0.31], [1.06, -0.6], [0.87, -0.5], [0.73, -0.17], [0.67, 0.21], [0.65, 0.55], [0.53, 0.79]], "BODY": [[0.36, 1.04], [0.43, 1.21], [0.6, 1.27], [0.77, 1.17], [0.87, 0.93], [1.06, 0.66], [1.24, 0.28], [1.32, -0.17], [1.27, -0.52], [1.08, -0.66], [0.86, -0.5], [0.72, -0.17], [0.66, 0.21], [0.64, 0.55], [0.52, 0.79], [0.4, 0.89]], "CAP": [[0.5, 1.215], [0.6, 1.275], [0.77, 1.175], [0.835, 1.01], [0.75, 1.06], [0.62, 1.17]], "CHEEK": [[0.44, 0.96], [0.55, 1.06], [0.72, 1.02], [0.76, 0.92], [0.62, 0.88], [0.5, 0.89]], "EYE": [0.555, 1.125], "HOLD": [0.69, -0.02], "TAIL": [[1.31, -0.3], [1.53, -1.22], [1.42, -1.17], [1.35, -1.26], [1.0, -0.55]]},
  // Points of the sleeve and the bird at q = (y, phi_M, phi_S) [m, rad].
  sleeve(s, [y, m], [x, h]) { return [x - m * h, h + m * x + y]; },
  bird(s, [y, m, a], [px, py]) {
    const tipX = s.l_g - s.l_s, tipY = s.h_s, c = Math.cos(a), n = Math.sin(a);
    const turned = (x, z) => [x * c - z * n, x * n + z * c];
    const across = s.l_m + tipX - tipY * a - turned(tipX, tipY)[0];
    const [x, z] = turned(px * s.l_s + tipX, (py - 1) * s.h_s + tipY);
    return [x + across, z + y + s.l_m * m];
  },
  spring(s, q) {
    const start = this.sleeve(s, q, [(1 + this.WALL) * s.r_m, 0]), end = this.bird(s, q, this.SHAPES.HOLD);
    const reach = Math.hypot(end[0] - start[0], end[1] - start[1]), radius = 0.3 * s.h_m, way = [];
    const out = [reach * Math.cos(q[1]), reach * Math.sin(q[1])], back = [reach * Math.cos(q[2]), reach * Math.sin(q[2])];
    const count = 30 * this.COILS;
    for (let k = 0; k < count; k++) {
      const t = k / (count - 1), bend = t * t * (3 - 2 * t), w = t * (1 - t);
      way.push([0, 1].map((i) => (1 - bend) * start[i] + bend * end[i] + w * ((1 - t) * out[i] - t * back[i])));
    }
    return way.map((p, k) => {
      const a = way[Math.max(0, k - 1)], b = way[Math.min(count - 1, k + 1)], t = k / (count - 1);
      const long = Math.hypot(b[0] - a[0], b[1] - a[1]) || 1;
      const swing = radius * Math.sin(2 * Math.PI * this.COILS * Math.min(1, Math.max(0, (t - 0.08) / 0.84)));
      return [p[0] - swing * (b[1] - a[1]) / long, p[1] + swing * (b[0] - a[0]) / long];
    });
  },
  contact(s, q, k) {
    if (k === 1) return this.bird(s, q, [0, 1]);
    return this.sleeve(s, q, [s.r_m, k === 2 ? -s.h_m : s.h_m]);
  },
  // What the picture holds: everything that a motion shows, seen from a height that follows the fall.
  room: { left: -0.019, right: 0.042, low: -0.04, high: 0.03 },
  // Where the eye is: it sinks evenly, or goes with the toy where that falls freely.
  height(data, t, y) {
    if (this.seen !== data) {
      const n = data.t.length - 1, end = data.t[n] || 1;
      this.free = data.t.some((time, k) => Math.abs(data.y[k] - data.y[n] * time / end) > 15);
      this.seen = data;
    }
    const n = data.t.length - 1;
    return this.free ? y : data.y[n] / 1000 * t / (data.t[n] || 1);
  },
  fit(s, data) {
    const room = { left: -(1 + this.WALL) * s.r_m - 0.0145, right: 0, low: -s.h_m, high: 1.2 * s.h_m }, n = data.t.length;
    for (let k = 0; k < n; k += Math.max(1, n >> 5)) {
      const q = [data.y[k] / 1000, data.phi_m[k], data.phi_s[k]], height = this.height(data, data.t[k], q[0]);
      for (const name of ["TAIL", "BODY"]) for (const point of this.SHAPES[name]) {
        const [x, y] = this.bird(s, q, point);
        room.right = Math.max(room.right, x); room.left = Math.min(room.left, x);
        room.low = Math.min(room.low, y - height); room.high = Math.max(room.high, y - height);
      }
    }
    this.room = { left: room.left - 0.001, right: room.right + 0.002, low: room.low - 0.002, high: room.high + 0.002 };
  },
  // Draw at q, seen from a height that follows the fall; lit: contacts that are closed or were just struck.
  draw(canvas, s, q, lit, height) {
    const scale = window.devicePixelRatio || 1, box = canvas.getBoundingClientRect();
    const width = Math.round(box.width * scale), tall = Math.round(box.height * scale);
    if (canvas.width !== width || canvas.height !== tall) { canvas.width = width; canvas.height = tall; }
    const pen = canvas.getContext("2d");
    pen.setTransform(1, 0, 0, 1, 0, 0);
    pen.clearRect(0, 0, width, tall);
    const { left, right, low, high } = this.room;
    const unit = Math.min(width / (right - left), tall / (high - low));
    const at = ([x, y]) => [width / 2 + (x - (left + right) / 2) * unit, tall / 2 - (y - height - (low + high) / 2) * unit];
    this.pole(pen, s, at, height, unit, scale);
    const wall = (x0, x1) => [[x0, -s.h_m], [x1, -s.h_m], [x1, s.h_m], [x0, s.h_m]].map((p) => at(this.sleeve(s, q, p)));
    const outer = (1 + this.WALL) * s.r_m, ink = 0.8 * scale;
    this.shape(pen, wall(-s.r_m, s.r_m), "#d9d9d955", null, ink);
    this.shape(pen, wall(s.r_m, outer), "#969696", "#333333", ink);
    this.shape(pen, wall(-outer, -s.r_m), "#969696", "#333333", ink);
    const coil = this.spring(s, q).map(at);
    this.line(pen, coil, "white", 3 * scale); this.line(pen, coil, "#333333", 1.3 * scale);
    const place = (p) => at(this.bird(s, q, p));
    for (const [name, color, round] of [["TAIL", "#333333", 0], ["BEAK", "#969696", 0], ["BODY", "#333333", 1], ["BELLY", "#f7f3e8", 1], ["CHEEK", "#f7f3e8", 1], ["CAP", "#cb181d", 1]])
      this.shape(pen, this.SHAPES[name].map(place), color, "#333333", ink, round);
    for (const bar of this.SHAPES.BARS) this.line(pen, bar.map(place), "#f7f3e8", 1.8 * scale);
    const [ex, ey] = place(this.SHAPES.EYE);
    pen.beginPath(); pen.arc(ex, ey, 2 * scale, 0, 7); pen.fillStyle = "#333333"; pen.fill(); pen.strokeStyle = "#f7f3e8"; pen.lineWidth = scale; pen.stroke();
    for (const k of [1, 2, 3]) if (lit[k] > 0) this.ring(pen, at(this.contact(s, q, k)), k, lit[k], scale);
  },
  pole(pen, s, at, height, unit, scale) {
    const [x0] = at([-s.r_0, 0]), [x1] = at([s.r_0, 0]), tall = pen.canvas.height;
    pen.fillStyle = "#ead7b7"; pen.fillRect(x0, 0, x1 - x0, tall);
    pen.strokeStyle = "#a88a5c"; pen.lineWidth = scale;
    pen.beginPath();
    for (const x of [x0, x1]) { pen.moveTo(x, 0); pen.lineTo(x, tall); }
    pen.stroke();
    pen.fillStyle = "#8c6d3f"; pen.font = `${10 * scale}px system-ui, "DejaVu Sans", sans-serif`; pen.textAlign = "right";
    for (let mm = 10 * Math.ceil(100 * (height - 0.04)); mm < 1000 * (height + 0.05); mm += 10) {
      const [, y] = at([0, mm / 1000]);
      pen.fillRect(x0 - 4 * scale, y, x1 - x0 + 4 * scale, 0.7 * scale);
      pen.fillText(`${mm} mm`.replace("-", "−"), x0 - 16 * scale, y + 3 * scale);
    }
  },
  line(pen, way, color, wide) {
    pen.beginPath(); way.forEach(([x, y], k) => k ? pen.lineTo(x, y) : pen.moveTo(x, y));
    pen.strokeStyle = color; pen.lineWidth = wide; pen.lineJoin = pen.lineCap = "round"; pen.stroke();
  },
  shape(pen, way, fill, stroke, wide, round = 0) {
    pen.beginPath();
    const n = way.length;
    if (!round) way.forEach(([x, y], k) => k ? pen.lineTo(x, y) : pen.moveTo(x, y));
    else for (let k = 0; k < n; k++) { // a smooth closed curve through the points (Catmull and Rom)
      const [a, b, c, d] = [k - 1, k, k + 1, k + 2].map((i) => way[(i + n) % n]);
      if (!k) pen.moveTo(...b);
      pen.bezierCurveTo(b[0] + (c[0] - a[0]) / 6, b[1] + (c[1] - a[1]) / 6, c[0] - (d[0] - b[0]) / 6, c[1] - (d[1] - b[1]) / 6, ...c);
    }
    pen.closePath(); pen.fillStyle = fill; pen.fill();
    if (stroke) { pen.strokeStyle = stroke; pen.lineWidth = wide; pen.stroke(); }
  },
  ring(pen, [x, y], k, bright, scale) {
    pen.globalAlpha = Math.min(1, bright);
    const glow = pen.createRadialGradient(x, y, 0, x, y, 16 * scale);
    glow.addColorStop(0, this.COLORS[k] + "cc"); glow.addColorStop(1, this.COLORS[k] + "00");
    pen.fillStyle = glow; pen.beginPath(); pen.arc(x, y, 16 * scale, 0, 7); pen.fill();
    pen.strokeStyle = this.COLORS[k]; pen.lineWidth = 2.2 * scale; pen.beginPath(); pen.arc(x, y, 7 * scale, 0, 7); pen.stroke();
    pen.fillStyle = this.COLORS[k]; pen.font = `bold ${12 * scale}px system-ui, "DejaVu Sans", sans-serif`; pen.textAlign = "center";
    pen.fillText(k, x, y + (k === 2 ? 20 : -11) * scale);
    pen.globalAlpha = 1;
  },
};
