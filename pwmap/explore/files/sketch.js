// What a change moves is drawn here until the page is at rest, on canvases over the figures. A letter brings new
// columns of tables; Bokeh, which takes some 8 ms to lay out and paint a figure, keeps the axes and all
// other tables. At rest everything is Bokeh's again. Glyphs are those that the views use.
"use strict";
const sketch = {
  columns: {}, // by the name of a table: what the last letters told
  hidden: [],
  data(table) { return this.columns[table.name] ?? table.data; },
  take(tables, all) {
    const numbers = new Float64Array(all.buffer, all.byteOffset, all.length);
    for (const [name, columns] of Object.entries(tables)) {
      const told = Object.entries(columns).map(([column, part]) =>
        [column, Array.isArray(part) ? part : numbers.subarray(part.at, part.at + part.n)]);
      this.columns[name] = Object.fromEntries(told);
    }
    this.paint();
  },
  // New columns that the page itself makes: they come with the next letter while a slider moves.
  put(table, columns) {
    if (this.hidden.length) this.columns[table.name] = columns;
    else table.data = columns;
  },
  // Bokeh draws all of it with its next frame, and nothing blinks.
  end() {
    if (!this.hidden.length) return;
    for (const renderer of this.hidden) renderer.setv({ visible: true }, { sync: false });
    this.hidden = [];
    this.columns = {};
    requestAnimationFrame(() => setTimeout(() => {
      if (!this.hidden.length) for (const canvas of document.querySelectorAll(".sketch")) canvas.hidden = true;
    }, 40));
  },
  paint() {
    for (const view of Object.values(window.Bokeh.index.roots ?? window.Bokeh.index)) {
      const renderers = view.model.renderers?.filter((each) => this.columns[each.data_source?.name]);
      if (renderers?.length && view.bbox.width > 0) this.figure(view, renderers);
    }
  },
  figure(view, renderers) {
    for (const renderer of renderers) if (renderer.visible) {
      renderer.setv({ visible: false }, { sync: false });
      this.hidden.push(renderer);
    }
    const scale = window.devicePixelRatio || 1, { width, height } = view.bbox, frame = view.frame.bbox;
    const pen = this.pen(view, Math.round(width * scale), Math.round(height * scale));
    pen.setTransform(scale, 0, 0, scale, 0, 0);
    pen.clearRect(0, 0, width, height);
    pen.save();
    pen.beginPath();
    pen.rect(frame.left, frame.top, frame.width, frame.height);
    pen.clip();
    const { x_range, y_range } = view.model;
    const kx = frame.width / (x_range.end - x_range.start), ky = frame.height / (y_range.end - y_range.start);
    const at = {
      kx, ky, frame, x: (v) => frame.left + (v - x_range.start) * kx, y: (v) => frame.bottom - (v - y_range.start) * ky,
    };
    for (const { glyph, data_source } of renderers) this[glyph.type]?.(pen, glyph, this.data(data_source), at);
    pen.restore();
  },
  pen(view, width, height) {
    const place = document.querySelector("#plot-" + view.model.name);
    let canvas = place.querySelector(".sketch");
    if (!canvas) {
      canvas = place.appendChild(document.createElement("canvas"));
      canvas.className = "sketch";
      canvas.ariaLabel = view.model.name + ", while it moves";
    }
    if (canvas.hidden) canvas.hidden = false;
    if (canvas.width !== width || canvas.height !== height) { canvas.width = width; canvas.height = height; }
    return (canvas.pen ??= canvas.getContext("2d"));
  },
  // A property of a glyph in a row: one value for all of them, or a column.
  of(property, data, k) {
    if (property?.field !== undefined) return data[property.field][k];
    return property?.value !== undefined ? property.value : property;
  },
  style(pen, glyph, data, k) {
    const dash = this.of(glyph.line_dash, data, k);
    pen.strokeStyle = this.of(glyph.line_color, data, k) ?? "transparent";
    pen.lineWidth = this.of(glyph.line_width, data, k) ?? 1;
    pen.setLineDash(Array.isArray(dash) ? dash : []);
  },
  fill(pen, glyph, data, k) {
    const color = this.of(glyph.fill_color, data, k);
    if (!color) return;
    pen.globalAlpha = this.of(glyph.fill_alpha, data, k) ?? 1;
    pen.fillStyle = color;
    pen.fill();
    pen.globalAlpha = 1;
  },
  Line(pen, glyph, data, at) {
    const x = data[glyph.x.field], y = data[glyph.y.field];
    this.style(pen, glyph, data, 0);
    pen.lineJoin = "bevel";
    pen.beginPath();
    let joined = false;
    for (let k = 0; k < x.length; k++) {
      const u = at.x(x[k]), v = at.y(y[k]);
      if (!Number.isFinite(u) || !Number.isFinite(v)) { joined = false; continue; }
      if (joined) pen.lineTo(u, v); else pen.moveTo(u, v);
      joined = true;
    }
    pen.stroke();
  },
  Segment(pen, glyph, data, at) {
    const [x0, y0, x1, y1] = ["x0", "y0", "x1", "y1"].map((name) => data[glyph[name].field]);
    for (let k = 0; k < x0.length; k++) {
      this.style(pen, glyph, data, k);
      pen.beginPath();
      pen.moveTo(at.x(x0[k]), at.y(y0[k]));
      pen.lineTo(at.x(x1[k]), at.y(y1[k]));
      pen.stroke();
    }
  },
  VSpan(pen, glyph, data, at) {
    const x = data[glyph.x.field];
    for (let k = 0; k < x.length; k++) {
      this.style(pen, glyph, data, k);
      pen.beginPath();
      pen.moveTo(at.x(x[k]), at.frame.top);
      pen.lineTo(at.x(x[k]), at.frame.bottom);
      pen.stroke();
    }
  },
  HSpan(pen, glyph, data, at) {
    const y = data[glyph.y.field];
    for (let k = 0; k < y.length; k++) {
      this.style(pen, glyph, data, k);
      pen.beginPath();
      pen.moveTo(at.frame.left, at.y(y[k]));
      pen.lineTo(at.frame.right, at.y(y[k]));
      pen.stroke();
    }
  },
  Scatter(pen, glyph, data, at) {
    const x = data[glyph.x.field], y = glyph.y.field ? data[glyph.y.field] : null;
    for (let k = 0; k < x.length; k++) {
      const u = at.x(x[k]), v = at.y(y ? y[k] : this.of(glyph.y, data, k)), half = this.of(glyph.size, data, k) / 2;
      this.style(pen, glyph, data, k);
      pen.beginPath();
      const marker = this.of(glyph.marker, data, k);
      if (marker === "square") pen.rect(u - half, v - half, 2 * half, 2 * half);
      else if (marker === "triangle") { pen.moveTo(u - half, v + half); pen.lineTo(u, v - half); pen.lineTo(u + half, v + half); pen.closePath(); }
      else pen.arc(u, v, half, 0, 7);
      this.fill(pen, glyph, data, k);
      pen.stroke();
    }
  },
  Rect(pen, glyph, data, at) {
    const x = data[glyph.x.field];
    for (let k = 0; k < x.length; k++) {
      const w = this.of(glyph.width, data, k) * at.kx, h = this.of(glyph.height, data, k) * at.ky;
      this.style(pen, glyph, data, k);
      pen.beginPath();
      pen.roundRect(at.x(x[k]) - w / 2, at.y(this.of(glyph.y, data, k)) - h / 2, w, h, 4);
      this.fill(pen, glyph, data, k);
      pen.stroke();
    }
  },
  Text(pen, glyph, data, at) {
    const x = data[glyph.x.field], bold = this.of(glyph.text_font_style, data, 0) === "bold" ? "bold " : "";
    pen.font = `${bold}${this.of(glyph.text_font_size, data, 0)} ${this.of(glyph.text_font, data, 0)}`;
    pen.fillStyle = this.of(glyph.text_color, data, 0);
    pen.textAlign = "center";
    pen.textBaseline = "middle";
    for (let k = 0; k < x.length; k++) pen.fillText(this.of(glyph.text, data, k), at.x(x[k]), at.y(this.of(glyph.y, data, k)));
  },
};
