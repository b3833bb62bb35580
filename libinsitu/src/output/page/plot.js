// Plots: lines, or areas one over another, as SVG of the size that the page gives them.

/** An element with attributes, and children that are elements or texts. Texts are never markup. */
function make(name, attributes = {}, ...children) {
  const svg = ["svg", "path", "line", "text", "g", "rect"].includes(name);
  const element = svg ? document.createElementNS("http://www.w3.org/2000/svg", name) : document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) {
    if (key.startsWith("on")) element.addEventListener(key.slice(2), value);
    else if (value === true) element.setAttribute(key, "");
    else if (value !== false && value !== undefined && value !== null) element.setAttribute(key, value);
  }
  element.append(...children);
  return element;
}

const finite = (v) => typeof v === "number" && Number.isFinite(v);

function formatNumber(v) {
  if (!finite(v)) return "–";
  if (v === 0) return "0";
  const size = Math.abs(v);
  return size >= 1e6 || size < 1e-4 ? v.toExponential(3).replace(/\.?0+e/, "e").replace("e+", "e")
                                    : String(Number(v.toPrecision(5)));
}
function formatSeconds(v) {
  if (!finite(v)) return "–";
  return v === 0 ? "0 s" : v < 1e-3 ? formatNumber(Number((v * 1e6).toPrecision(3))) + " µs"
      : v < 1 ? formatNumber(Number((v * 1e3).toPrecision(3))) + " ms" : formatNumber(Number(v.toPrecision(4))) + " s";
}
function formatBytes(v) {
  if (!finite(v)) return "–";
  const units = ["B", "KiB", "MiB", "GiB", "TiB"];
  let unit = 0;
  for (; v >= 1024 && unit < 4; ++unit) v /= 1024;
  return Number(v.toPrecision(3)) + " " + units[unit];
}
const formatCount = (v) => (finite(v) ? v.toLocaleString("en") : "–");

/** Round values within [low, high], about `most` of them. `base`: steps are 1, 2 or 5 times its powers. */
function ticks(low, high, most) {
  if (!(high > low)) return [low];
  const rough = (high - low) / most;
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((m) => m * power).find((s) => s >= rough * 0.999) || rough;
  const values = [];
  for (let i = Math.ceil(low / step - 1e-9); i * step <= high + step * 1e-9 && values.length < 50; ++i) values.push(i * step || 0); // no -0
  return values;
}

/** Byte counts are read in powers of 1024: steps of 1, 2, 5, 10, 20 ... KiB, MiB, GiB. */
function byteTicks(low, high, most) {
  const unit = 1024 ** Math.max(0, Math.floor(Math.log(Math.max(high, 1)) / Math.log(1024)));
  return ticks(low / unit, high / unit, most).map((v) => v * unit);
}

const seriesColor = (i) => `var(--c${i % 8})`;
const seriesDash = (i) => ["", "6 3", "2 3"][Math.floor(i / 8) % 3];

/** Where the frames' slider stands, to be marked in every plot: {cycle, time} or null. */
const shared = {mark: null, plots: [], choose: null};

/**
 * options: label; x (values), xName; series [{name, values, color}]; shown (names, or absent: all); stacked;
 * starts: areas are bars from these x to x; format; ticks; about(index): text for the readout; choose(index): a click.
 * Values that are not finite are gaps.
 */
function makePlot(options) {
  const {x, series} = options;
  const format = options.format || formatNumber;
  const state = {cursor: null, width: 0};
  const svg = make("svg", {"aria-hidden": "true"});
  const stage = make("div", {class: "plot", tabindex: "0", role: "img"}, svg);
  const readout = make("p", {class: "readout", "aria-live": "polite"});
  const legend = make("div", {class: "legend", role: "group", "aria-label": "Lines of " + options.label});
  const figure = make("div", {class: "figure"}, stage, readout, legend);
  const visible = series.map((s) => !options.shown || options.shown.has(s.name));
  const values = series.map(() => make("span", {class: "value"}));

  series.forEach((s, i) => {
    const color = seriesColor(s.color ?? i);
    const sample = make("svg", {width: 18, height: 12, "aria-hidden": "true"},
        options.stacked ? make("rect", {width: 18, height: 12, rx: 2, style: `fill:${color};fill-opacity:.75`})
                        : make("path", {d: "M0 6H18", style: `stroke:${color};stroke-width:3`, "stroke-dasharray": seriesDash(s.color ?? i)}));
    const button = make("button", {type: "button", "aria-pressed": String(visible[i])}, sample, make("span", {}, s.name), values[i]);
    button.addEventListener("click", () => {
      visible[i] = !visible[i];
      button.setAttribute("aria-pressed", String(visible[i]));
      if (options.toggled) options.toggled(s.name, visible[i]);
      draw();
    });
    legend.append(button);
  });

  /** One value a pixel column: the mean of areas; the least and the greatest of lines, so that no peak is lost. */
  function thin(columns) {
    const n = x.length;
    if (n <= 2 * columns) return x.map((_, i) => [i, i + 1]);
    return Array.from({length: columns}, (_, c) => [Math.floor(c * n / columns), Math.floor((c + 1) * n / columns)]);
  }

  function draw() {
    const width = Math.max(240, state.width || 600), height = options.height || 230;
    const left = 62, right = 10, top = 10, bottom = 36;
    const shownSeries = series.map((s, i) => ({...s, i})).filter((s) => visible[s.i]);
    const bins = thin(Math.max(50, Math.floor(width - left - right)));
    const xs = bins.map(([a, b]) => x[Math.floor((a + b - 1) / 2)]);
    let layers, low = Infinity, high = -Infinity;
    if (options.stacked) {
      const base = bins.map(() => 0);
      layers = shownSeries.map((s) => {
        const lower = base.slice();
        bins.forEach(([a, b], k) => {
          let sum = 0, count = 0;
          for (let i = a; i < b; ++i) if (finite(s.values[i])) { sum += s.values[i]; ++count; }
          base[k] += count ? sum / count : 0;
          high = Math.max(high, base[k]);
        });
        return {s, lower, upper: base.slice()};
      });
      low = 0;
    } else {
      layers = shownSeries.map((s) => {
        const points = [];
        bins.forEach(([a, b], k) => {
          let least = Infinity, most = -Infinity;
          for (let i = a; i < b; ++i) if (finite(s.values[i])) { least = Math.min(least, s.values[i]); most = Math.max(most, s.values[i]); }
          points.push(least <= most ? [xs[k], least, most] : null);
          low = Math.min(low, least); high = Math.max(high, most);
        });
        return {s, points};
      });
    }
    if (!(low <= high)) { low = 0; high = 1; }
    if (low === high) { const pad = Math.abs(low) / 10 || 1; high += pad; if (!options.stacked) low -= pad; }
    const known = x.concat(options.starts || []).filter(finite);
    let x0 = Math.min(...minmax(known)), x1 = Math.max(...minmax(known));
    if (!(x0 < x1)) { x0 -= 0.5; x1 += 0.5; }
    const px = (v) => left + (v - x0) / (x1 - x0) * (width - left - right);
    const py = (v) => top + (high / 2 - v / 2) / (high / 2 - low / 2) * (height - top - bottom);
    const at = (v) => v.toFixed(1);

    svg.setAttribute("viewBox", `0 0 ${width} ${height}`);
    svg.setAttribute("height", height);
    svg.replaceChildren();
    for (const v of (options.ticks || ticks)(low, high, 5))
      svg.append(make("line", {class: "rule", x1: left, x2: width - right, y1: at(py(v)), y2: at(py(v))}),
                 make("text", {x: left - 6, y: at(py(v) + 4), "text-anchor": "end"}, format(v)));
    for (const v of ticks(x0, x1, Math.max(2, Math.floor(width / 110))))
      svg.append(make("line", {class: "rule", x1: at(px(v)), x2: at(px(v)), y1: height - bottom, y2: height - bottom + 4}),
                 make("text", {x: at(px(v)), y: height - bottom + 17, "text-anchor": "middle"}, formatNumber(v)));
    svg.append(make("line", {class: "rule", x1: left, x2: width - right, y1: height - bottom, y2: height - bottom}),
               make("text", {x: at((left + width - right) / 2), y: height - 3, "text-anchor": "middle"}, options.xName));
    for (const {s, points, lower, upper} of layers) {
      const color = seriesColor(s.color ?? s.i);
      let d = "", pen = "M";
      if (options.stacked) {
        const go = (to, v) => { if (finite(to)) { d += `${pen}${at(px(to))} ${at(py(v))}`; pen = "L"; } };
        const from = (k) => (options.starts ? options.starts[bins[k][0]] : null);
        const to = (k) => (options.starts ? x[bins[k][1] - 1] : xs[k]);
        for (let k = 0; k < xs.length; ++k) { go(from(k), upper[k]); go(to(k), upper[k]); }
        for (let k = xs.length - 1; k >= 0; --k) { go(to(k), lower[k]); go(from(k), lower[k]); }
        if (d) svg.append(make("path", {class: "area", d: d + "Z", style: `fill:${color}`}));
        continue;
      }
      for (const p of points) {
        if (!p || !finite(p[0])) { pen = "M"; continue; }
        d += `${pen}${at(px(p[0]))} ${at(py(p[1]))}`;
        d += p[2] > p[1] ? `L${at(px(p[0]))} ${at(py(p[2]))}` : pen === "M" ? "h0.1" : "";
        pen = "L";
      }
      if (d) svg.append(make("path", {class: "curve", d, style: `stroke:${color};stroke-linecap:round`, "stroke-dasharray": seriesDash(s.color ?? s.i)}));
    }
    const mark = shared.mark && options.markAt ? options.markAt(shared.mark) : null;
    if (finite(mark) && mark >= x0 && mark <= x1)
      svg.append(make("line", {class: "mark", x1: at(px(mark)), x2: at(px(mark)), y1: top, y2: height - bottom}));
    if (state.cursor !== null && finite(x[state.cursor]))
      svg.append(make("line", {class: "cursor", x1: at(px(x[state.cursor])), x2: at(px(x[state.cursor])), y1: top, y2: height - bottom}));
    state.toIndex = (pixels) => {
      const value = x0 + (pixels - left) / (width - left - right) * (x1 - x0);
      let best = null;
      x.forEach((v, i) => { if (finite(v) && (best === null || Math.abs(v - value) < Math.abs(x[best] - value))) best = i; });
      return best;
    };
    const i = state.cursor;
    readout.textContent = i === null ? "" : options.about(i);
    series.forEach((s, k) => { values[k].textContent = i === null || !visible[k] ? "" : format(s.values[i]); });
    const last = x.length - 1;
    stage.setAttribute("aria-label", `${options.label}: ${x.length} values from ${options.xName} ${formatNumber(x[0])} to ${formatNumber(x[last])}. `
        + shownSeries.slice(0, 6).map((s) => `${s.name}: last ${format(s.values[last])}`).join("; ") + ". Left and right arrow keys read the values.");
  }

  const move = (cursor) => { if (cursor !== state.cursor) { state.cursor = cursor; draw(); } };
  stage.addEventListener("pointermove", (e) => move(state.toIndex(e.clientX - svg.getBoundingClientRect().left)));
  stage.addEventListener("pointerleave", () => move(null));
  stage.addEventListener("click", (e) => {
    const i = state.toIndex(e.clientX - svg.getBoundingClientRect().left);
    if (i !== null && options.choose) options.choose(i);
  });
  stage.addEventListener("blur", () => move(null));
  stage.addEventListener("keydown", (e) => {
    const n = x.length, from = state.cursor;
    const to = {ArrowLeft: from === null ? n - 1 : Math.max(0, from - 1), ArrowRight: from === null ? 0 : Math.min(n - 1, from + 1),
                Home: 0, End: n - 1}[e.key];
    if (e.key === "Enter" && from !== null && options.choose) options.choose(from);
    if (to === undefined) return;
    e.preventDefault();
    e.stopPropagation();
    move(to);
  });
  new ResizeObserver((all) => {
    const width = Math.round(all[0].contentRect.width);
    if (width > 0 && width !== state.width) { state.width = width; draw(); }
  }).observe(stage);
  draw();
  shared.plots.push(draw);
  return figure;
}

/** [least, greatest], of any number of values. */
function minmax(values) {
  let least = Infinity, most = -Infinity;
  for (const v of values) { if (v < least) least = v; if (v > most) most = v; }
  return [least, most];
}
