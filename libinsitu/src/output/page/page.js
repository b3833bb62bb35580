// The page: reads the entries of run.js, and shows them.

/** The entries, put together by what they speak of. */
function readRun(entries) {
  const run = {entries, sessions: [], frames: new Map(), frameStops: [], probes: new Map(), tracers: new Map(), messages: [], plan: "", failures: 0};
  let endings = [];
  for (const e of entries) {
    const at = {cycle: e.cycle, time: e.time};
    if (e.session) {
      run.sessions.push({...e.session, ...at});
      endings = e.session.endings;
      run.purposes = e.session.purposes;
    }
    if (e.frames) {
      const images = e.frames.filter((f) => /\.png$/i.test(f.file));
      if (images.length) run.frameStops.push(at);
      for (const f of images) {
        const name = f.kind === "color" ? f.name : `${f.name}, ${f.kind}`;
        if (!run.frames.has(name)) run.frames.set(name, []);
        run.frames.get(name).push({stop: run.frameStops.length - 1, file: f.file});
      }
    }
    for (const p of e.probes || []) {
      if (!run.probes.has(p.name)) run.probes.set(p.name, {samples: [], columns: [], points: []});
      const probe = run.probes.get(p.name);
      if (p.columns) Object.assign(probe, {columns: p.columns, points: p.points, total: p.total, all_columns: p.all_columns});
      probe.samples.push({...at, columns: probe.columns, values: p.values});
    }
    for (const t of e.tracers || []) {
      if (!run.tracers.has(t.name)) run.tracers.set(t.name, {samples: [], endings});
      run.tracers.get(t.name).samples.push({...at, seeded: t.seeded, counts: t.endings});
    }
    for (const m of e.messages || []) run.messages.push({...m, cycle: e.cycle});
    run.failures += e.failures || 0;
    if (e.plan) run.plan = e.plan;
  }
  return run;
}

const kept = {axis: "cycle", frames: {}, probes: {}}; // what the reader chose, kept when the page follows the run

const axisOf = (samples) => samples.map((s) => s[kept.axis]);
const aboutOf = (samples) => (i) => `cycle ${samples[i].cycle}, time ${formatNumber(samples[i].time)}`;
const plotOver = (samples, options) => makePlot({
  x: axisOf(samples), xName: kept.axis, about: aboutOf(samples), markAt: (mark) => mark[kept.axis],
  choose: (i) => shared.choose && shared.choose(samples[i]), ...options});

function fill(id, ...body) {
  const section = document.getElementById(id);
  section.hidden = body.length === 0;
  section.querySelector(".body").replaceChildren(...body);
}

function makeProbe(name, probe) {
  const chosen = kept.probes[name] ||= {column: probe.columns[0], points: null};
  const labels = probe.points.map((p) => p.name ?? `${p.point}: (${p.at.map(formatNumber).join(", ")})`);
  // A few at first, spread over those that are here.
  const few = Math.min(5, labels.length);
  chosen.points ||= new Set(Array.from({length: few}, (_, i) => labels[few < 2 ? 0 : Math.round(i * (labels.length - 1) / (few - 1))]));
  const place = make("div");
  function draw() {
    const series = labels.map((label, p) => ({name: label, values: probe.samples.map((s) => {
      const row = s.values[p], column = s.columns.indexOf(chosen.column);
      return row && column >= 0 ? row[column] : null;
    })}));
    place.replaceChildren(plotOver(probe.samples, {label: `${chosen.column} of ${name}`, series, shown: chosen.points,
      toggled: (point, on) => chosen.points[on ? "add" : "delete"](point)}));
  }
  const columns = make("select", {id: "column-" + name, "aria-label": "Field of " + name},
      ...probe.columns.map((c) => make("option", {value: c, selected: c === chosen.column}, c)));
  columns.addEventListener("change", () => { chosen.column = columns.value; draw(); });
  const notes = [];
  if (probe.total > probe.points.length) notes.push(`${probe.points.length} of ${formatCount(probe.total)} points`);
  if (probe.all_columns > probe.columns.length) notes.push(`${probe.columns.length} of ${probe.all_columns} columns`);
  draw();
  return make("div", {class: "card"}, make("h3", {}, name), columns,
      ...(notes.length ? [make("p", {class: "note"}, notes.join(", ") + "; the table has all")] : []), place);
}

function makeTracer(name, tracer) {
  const series = tracer.endings.map((ending, i) => ({name: ending, color: i, values: tracer.samples.map((s) => s.counts[i])}))
      .filter((s) => s.values.some((v) => v > 0));
  const last = tracer.samples[tracer.samples.length - 1];
  return make("div", {class: "card"}, make("h3", {}, name), make("p", {class: "note"}, `${formatCount(last.seeded)} seeded`),
      plotOver(tracer.samples, {label: "Particles of " + name, series, stacked: true, format: formatCount}));
}

const parts = ["commit", "query", "advect", "render", "output"];

function makeCost(run) {
  const spans = run.entries.filter((e) => e.executions > 0);
  const library = (e) => e.seconds.reduce((a, b) => a + b, 0);
  const ends = axisOf(spans);
  const starts = ends.map((end, i) => (i > 0 ? ends[i - 1] : kept.axis === "cycle" ? end - 1 : end));
  const totals = parts.map((_, i) => run.entries.reduce((sum, e) => sum + e.seconds[i], 0));
  const solver = run.entries.reduce((sum, e) => sum + Math.max(0, e.wall - library(e)), 0);
  const all = totals.reduce((a, b) => a + b, 0), wall = all + solver;
  const percent = (part, of) => (of > 0 ? (100 * part / of).toFixed(1) + " %" : "–");
  const series = parts.map((part, i) => ({name: part, color: i, values: spans.map((e) => e.seconds[i] / e.executions)}))
      .concat({name: "solver and the rest", color: 7, values: spans.map((e) => Math.max(0, e.wall - library(e)) / e.executions)});
  const row = (name, seconds, of) => make("tr", {}, make("th", {scope: "row"}, name), make("td", {class: "number"}, formatSeconds(seconds)),
      make("td", {class: "number"}, of ? percent(seconds, all) : ""), make("td", {class: "number"}, percent(seconds, wall)));
  const table = make("table", {},
      make("thead", {}, make("tr", {}, ...["", "total", "of the library", "of the run"].map((t, i) => make("th", {scope: "col", class: i ? "number" : ""}, t)))),
      make("tbody", {}, ...parts.map((p, i) => row(p, totals[i], true)), row("library", all, true), row("solver and the rest", solver, false)));
  const cards = [make("div", {class: "card"}, make("h3", {}, "Seconds a cycle"),
      plotOver(spans, {label: "Seconds a cycle", series, shown: kept.parts ||= new Set(parts), stacked: true, starts, format: formatSeconds,
                       toggled: (part, on) => kept.parts[on ? "add" : "delete"](part)}), table)];
  const spread = run.entries.filter((e) => e.processes);
  if (spread.length > 0) {
    const kinds = ["least", "mean", "greatest"];
    const sum = (kind, i) => spread.reduce((total, e) => total + e.processes[kind][i], 0);
    cards[0].append(make("p", {class: "note"}, `${spread[0].processes.count} processes; the seconds above are the root's, these the least, mean ` +
        "and greatest of a cycle's, added up:"), make("table", {},
        make("thead", {}, make("tr", {}, ...["", ...kinds].map((t, i) => make("th", {scope: "col", class: i ? "number" : ""}, t)))),
        make("tbody", {}, ...parts.map((p, i) => make("tr", {}, make("th", {scope: "row"}, p),
            ...kinds.map((kind) => make("td", {class: "number"}, formatSeconds(sum(kind, i)))))))));
  }
  const purposes = (run.purposes || []).map((name, i) => ({name, values: run.entries.map((e) => e.bytes[i] || 0)}))
      .filter((s) => s.values.some((v) => v > 0));
  const peak = minmax(run.entries.map((e) => e.peak))[1];
  const last = run.entries[run.entries.length - 1];
  cards.push(make("div", {class: "card"}, make("h3", {}, "Memory held by the library"), make("p", {class: "note"},
      `peak ${formatBytes(peak)}, at the end ${formatBytes(last.bytes.reduce((a, b) => a + b, 0))}`),
      plotOver(run.entries, {label: "Memory by purpose", series: purposes, stacked: true, format: formatBytes, ticks: byteTicks})));
  return make("div", {class: "grid"}, ...cards);
}

function makeMessages(run) {
  const rows = run.messages.map((m) => make("tr", {}, make("td", {class: "number"}, String(m.cycle)),
      make("td", {class: m.level === "warning" ? "warning" : "error"}, m.level), make("td", {class: "text"}, m.text)));
  return make("div", {class: "scroll", tabindex: "0", role: "region", "aria-label": "List of failures and warnings"},
      make("table", {}, make("thead", {}, make("tr", {}, make("th", {scope: "col", class: "number"}, "cycle"), make("th", {scope: "col"}, "kind"),
          make("th", {scope: "col"}, "what"))), make("tbody", {}, ...rows)));
}

function makeHeader(run) {
  const first = run.entries[0], last = run.entries[run.entries.length - 1], session = run.sessions[run.sessions.length - 1] || {};
  const title = session.scene ? "Run of " + session.scene.split("/").slice(-2).join("/") : "Run";
  document.title = title;
  document.getElementById("title").textContent = title;
  const restarts = run.sessions.slice(1).map((s) => s.cycle);
  document.getElementById("summary").textContent = [
    `cycles ${first.cycle} to ${last.cycle}`, `time ${formatNumber(first.time)} to ${formatNumber(last.time)}`,
    ...(restarts.length ? [`restarted at cycle ${restarts.join(", ")}`] : []),
    `started ${session.started}`, `${session.threads} threads`, `libinsitu ${session.library}`].join(" · ");
  const state = document.getElementById("state");
  state.className = run.failures ? "bad" : "";
  state.textContent = (last.finished ? "Finished" : "Not finished: it still runs, or it was killed")
      + (run.failures ? `, with ${formatCount(run.failures)} failure${run.failures > 1 ? "s" : ""}` : ", no failures");
}

function showPage(entries) {
  const notice = document.getElementById("notice");
  notice.hidden = Array.isArray(entries) && entries.length > 0;
  if (!notice.hidden) {
    notice.textContent = Array.isArray(entries) ? "run.js holds no cycle yet." : "run.js, which holds this run's data, is missing beside this page or is damaged.";
    return;
  }
  const run = readRun(entries);
  if (shared.stop) shared.stop();
  Object.assign(shared, {plots: [], choose: null, mark: null, keys: null, stop: null});
  makeHeader(run);
  fill("frames", ...(run.frameStops.length ? makeFrames(run, kept.frames) : []));
  fill("messages", ...(run.messages.length ? [makeMessages(run)] : []));
  const cards = (map, card) => (map.size ? [make("div", {class: "grid"}, ...[...map].map(([name, item]) => card(name, item)))] : []);
  fill("probes", ...cards(run.probes, makeProbe));
  fill("particles", ...cards(run.tracers, makeTracer));
  fill("cost", makeCost(run));
  fill("plan", ...(run.plan ? [make("pre", {tabindex: "0"}, run.plan)] : []));
  const tables = run.sessions[run.sessions.length - 1]?.tables || [];
  fill("files", ...(tables.length ? [make("ul", {}, ...tables.map((t) => make("li", {}, make("a", {href: encodeURIComponent(t.file)}, t.file), ` (${t.kind})`)))] : []));
}

document.addEventListener("keydown", (e) => { if (shared.keys) shared.keys(e); });
document.getElementById("options").addEventListener("submit", (e) => e.preventDefault());
document.getElementById("axis").addEventListener("change", (e) => { kept.axis = e.target.value; showPage(window.insitu); });

/** Reads run.js again, and shows it if it has grown; focus stays where it was. */
let following = null;
document.getElementById("follow").addEventListener("change", (e) => {
  clearInterval(following);
  if (!e.target.checked) return;
  following = setInterval(() => {
    const before = window.insitu ? window.insitu.length : 0;
    const script = make("script", {src: "run.js?" + Date.now()});
    script.addEventListener("load", () => {
      script.remove();
      if (window.insitu.length === before) return;
      const focus = document.activeElement && document.activeElement.id;
      showPage(window.insitu);
      if (focus && document.getElementById(focus)) document.getElementById(focus).focus();
    });
    script.addEventListener("error", () => script.remove());
    document.head.append(script);
  }, 3000);
});

showPage(window.insitu);
