// Lines over time, with a cursor at the time that is shown and values beside the names.

const INK = ["#3b78d8", "#e0662f", "#2f9e6b", "#b8548f", "#8a6fd1", "#b08a1e", "#2a9aab", "#d64550"];
const MARGIN = { left: 58, right: 10, top: 8, bottom: 22 };

/** Round numbers that divide a range into a few parts. */
function ticks(low, high, count) {
  const rough = (high - low) / count, power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((k) => k * power).find((s) => s >= rough * 0.999);
  const out = [];
  for (let x = Math.ceil(low / step - 1e-9) * step; x <= high + 1e-9 * step; x += step) out.push(Math.abs(x) < 1e-9 * step ? 0 : x);
  return out;
}

const short = (x) => {
  if (!Number.isFinite(x)) return "–";
  if (x === 0) return "0";
  const size = Math.abs(x);
  return size >= 1e5 || size < 1e-3 ? x.toExponential(2) : String(Number(x.toPrecision(4)));
};

class Plot {
  constructor({ title, unit, lines }, player) {
    Object.assign(this, { lines, player, canvas: element("canvas"), hidden: new Set(), hover: null, cache: null });
    this.canvas.setAttribute("role", "img");
    this.canvas.setAttribute("aria-label", `${title} over time`);
    this.values = lines.map(() => element("span", { className: "value" }));
    const names = lines.map((line, k) => {
      const swatch = element("span", { className: "swatch" });
      swatch.style.background = INK[k % INK.length];
      const name = element("span", { textContent: line.name, className: "name", title: line.name });
      const button = element("button", { type: "button" }, swatch, name, this.values[k]);
      button.setAttribute("aria-pressed", "true");
      button.addEventListener("click", () => this.toggle(k, button));
      return button;
    });
    const heading = element("h3", { textContent: title });
    if (unit) heading.append(element("span", { className: "unit", textContent: unit }));
    this.node = element("figure", {}, element("figcaption", {}, heading, element("div", { className: "legend" }, ...names)), this.canvas);
    this.listen();
  }

  toggle(k, button) {
    const shown = this.hidden.delete(k);
    if (!shown) this.hidden.add(k);
    button.setAttribute("aria-pressed", String(shown));
    this.cache = null;
    this.draw();
  }

  listen() {
    const timeAt = (event) => {
      const { width } = this.area(), { start, end } = this.player;
      return start + ((event.offsetX - MARGIN.left) / width) * (end - start);
    };
    this.canvas.addEventListener("pointermove", (event) => {
      if (event.buttons & 1) this.player.seek(timeAt(event));
      this.hover = timeAt(event);
      this.draw();
    });
    this.canvas.addEventListener("pointerdown", (event) => this.player.seek(timeAt(event)));
    this.canvas.addEventListener("pointerleave", () => { this.hover = null; this.draw(); });
  }

  area() {
    return {
      width: Math.max(1, this.canvas.clientWidth - MARGIN.left - MARGIN.right),
      height: Math.max(1, this.canvas.clientHeight - MARGIN.top - MARGIN.bottom),
    };
  }

  range() {
    let low = Infinity, high = -Infinity;
    this.lines.forEach(({ values }, k) => {
      if (this.hidden.has(k)) return;
      for (const x of values) if (Number.isFinite(x)) { low = Math.min(low, x); high = Math.max(high, x); }
    });
    if (!(low <= high)) return [-1, 1];
    const margin = (high - low) * 0.06 || Math.abs(high) * 0.1 || 1;
    return [low - margin, high + margin];
  }

  /** Draws what does not change with the time: made anew when the size or the colours do. */
  background(ratio) {
    const style = getComputedStyle(document.body), { clientWidth, clientHeight } = this.canvas;
    const key = [clientWidth, clientHeight, ratio, style.color].join();
    if (this.cache?.key === key) return this.cache;
    const canvas = element("canvas", { width: clientWidth * ratio, height: clientHeight * ratio });
    const [low, high] = this.range(), { width, height } = this.area(), { start, end } = this.player;
    const toX = (t) => MARGIN.left + ((t - start) / (end - start || 1)) * width;
    const toY = (x) => MARGIN.top + ((high - x) / (high - low)) * height;
    const pen = canvas.getContext("2d");
    pen.scale(ratio, ratio);
    this.drawAxes(pen, { low, high, start, end, toX, toY, width, height, style });
    pen.save();
    pen.beginPath();
    pen.rect(MARGIN.left, MARGIN.top, width, height);
    pen.clip();
    this.lines.forEach(({ values }, k) => this.hidden.has(k) || this.drawLine(pen, values, INK[k % INK.length], toX, toY));
    pen.restore();
    return (this.cache = { key, canvas, toX, toY, ink: style.color, height });
  }

  drawAxes(pen, { low, high, start, end, toX, toY, width, height, style }) {
    pen.font = `13px ${style.fontFamily}`;
    pen.lineWidth = 1;
    const faint = style.getPropertyValue("--line"), ink = style.getPropertyValue("--quiet");
    const stroke = (x0, y0, x1, y1) => { pen.beginPath(); pen.moveTo(x0, y0); pen.lineTo(x1, y1); pen.stroke(); };
    pen.strokeStyle = faint;
    pen.fillStyle = ink;
    pen.textAlign = "right";
    pen.textBaseline = "middle";
    for (const x of ticks(low, high, Math.max(2, height / 26))) {
      stroke(MARGIN.left, toY(x), MARGIN.left + width, toY(x));
      pen.fillText(short(x), MARGIN.left - 6, toY(x));
    }
    pen.textAlign = "center";
    pen.textBaseline = "top";
    if (!(end > start)) return;
    for (const t of ticks(start, end, Math.max(2, width / 80))) {
      stroke(toX(t), MARGIN.top, toX(t), MARGIN.top + height);
      const at = Math.min(toX(t), MARGIN.left + width - 10);
      pen.fillText(`${short(t)} s`, at, MARGIN.top + height + 5);
    }
  }

  /** A line; where there are more values than pixels, the least and the largest of each pixel. */
  drawLine(pen, values, ink, toX, toY) {
    const { times } = this.player, { width } = this.area(), bucket = Math.max(1, Math.floor(times.length / (2 * width)));
    pen.strokeStyle = ink;
    pen.lineWidth = 1.6;
    pen.lineJoin = "round";
    pen.beginPath();
    let open = false;
    const point = (k) => {
      if (!Number.isFinite(values[k])) { open = false; return; }
      if (open) pen.lineTo(toX(times[k]), toY(values[k]));
      else pen.moveTo(toX(times[k]), toY(values[k]));
      open = true;
    };
    for (let from = 0; from < times.length; from += bucket) {
      let low = from, high = from;
      for (let k = from; k < Math.min(from + bucket, times.length); k++) {
        if (values[k] < values[low]) low = k;
        if (values[k] > values[high]) high = k;
      }
      point(Math.min(low, high));
      if (low !== high) point(Math.max(low, high));
    }
    pen.stroke();
  }

  draw() {
    const ratio = window.devicePixelRatio || 1, { canvas } = this;
    if (!canvas.clientWidth) return;
    const { canvas: back, toX, toY, ink, height } = this.background(ratio);
    if (canvas.width !== back.width || canvas.height !== back.height) Object.assign(canvas, { width: back.width, height: back.height });
    const pen = canvas.getContext("2d");
    pen.setTransform(1, 0, 0, 1, 0, 0);
    pen.clearRect(0, 0, canvas.width, canvas.height);
    pen.drawImage(back, 0, 0);
    pen.scale(ratio, ratio);
    const time = this.hover ?? this.player.time, x = toX(Math.max(this.player.start, Math.min(this.player.end, time)));
    pen.strokeStyle = ink;
    pen.globalAlpha = 0.55;
    pen.beginPath();
    pen.moveTo(x, MARGIN.top);
    pen.lineTo(x, MARGIN.top + height);
    pen.stroke();
    pen.globalAlpha = 1;
    this.showValues(pen, time, x, toY);
  }

  /** Values at a time beside the names, and dots on the lines. */
  showValues(pen, time, x, toY) {
    const { index, fraction } = this.player.place(time), last = this.player.times.length - 1;
    this.lines.forEach(({ values }, k) => {
      const [a, b] = [values[index], values[Math.min(index + 1, last)]];
      const value = Number.isFinite(b) ? a + (b - a) * fraction : a;
      this.values[k].textContent = short(value);
      if (this.hidden.has(k) || !Number.isFinite(value)) return;
      pen.fillStyle = INK[k % INK.length];
      pen.beginPath();
      pen.arc(x, toY(value), 3.5, 0, 2 * Math.PI);
      pen.fill();
    });
  }
}
