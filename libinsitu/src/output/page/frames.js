// Frames: an image of each name, and one slider over the cycles that have any.

function makeFrames(run, keep) {
  const names = [...run.frames.keys()];
  const stops = run.frameStops; // [{cycle, time}], ascending by entry
  keep.hidden ||= new Set(names.slice(4));
  const figures = names.map((name) => {
    const image = make("img", {decoding: "sync"});
    const link = make("a", {target: "_blank", rel: "noopener"}, image);
    const caption = make("figcaption");
    const figure = make("figure", {hidden: keep.hidden.has(name)}, link, caption);
    image.addEventListener("error", () => { if (image.getAttribute("src")) { figure.classList.add("missing"); caption.textContent = name + ": no such image"; } });
    image.addEventListener("load", () => figure.classList.remove("missing"));
    return {name, image, link, caption, figure, list: run.frames.get(name)};
  });

  const slider = make("input", {type: "range", id: "slider", min: 0, max: stops.length - 1, step: 1, "aria-label": "Cycle of the frames"});
  const label = make("output", {id: "where", for: "slider", "aria-live": "polite"});
  const play = make("button", {type: "button", id: "play"});
  const speed = make("select", {id: "speed", "aria-label": "Frames a second"},
      ...[1, 2, 5, 10, 25].map((s) => make("option", {value: s, selected: s === (keep.speed || 5)}, s + " a second")));
  const button = (id, text, label, by) => make("button", {type: "button", id, "aria-label": label, title: label, onclick: () => { stop(); show(index + by); }}, text);
  let index = keep.atEnd ?? true ? stops.length - 1 : Math.min(keep.index, stops.length - 1), timer = null;

  const addressOf = (file) => encodeURIComponent(file);
  /** The frame of this stop, or the last one before it. */
  function frameAt(list, stop) {
    let low = 0, high = list.length;
    while (low < high) { const m = (low + high) >> 1; if (list[m].stop <= stop) low = m + 1; else high = m; }
    return list[low - 1];
  }
  function show(to) {
    index = Math.max(0, Math.min(stops.length - 1, to));
    keep.index = index;
    keep.atEnd = index === stops.length - 1;
    const here = stops[index];
    const text = `cycle ${here.cycle}, time ${formatNumber(here.time)} (${index + 1} of ${stops.length})`;
    slider.value = index;
    slider.setAttribute("aria-valuetext", text);
    label.textContent = text;
    for (const {name, image, link, caption, list} of figures) {
      const frame = frameAt(list, index);
      if (!frame) {
        image.removeAttribute("src");
        link.removeAttribute("href");
        image.alt = caption.textContent = name + ": not drawn yet";
        continue;
      }
      const address = addressOf(frame.file);
      if (image.getAttribute("src") !== address) image.setAttribute("src", address);
      link.setAttribute("href", address);
      const at = stops[frame.stop];
      image.alt = `${name} at cycle ${at.cycle}, time ${formatNumber(at.time)}`;
      caption.textContent = frame.stop === index ? name : `${name}, of cycle ${at.cycle}`;
    }
    shared.mark = here;
    for (const draw of shared.plots) draw();
  }
  function stop() {
    clearTimeout(timer);
    timer = null;
    play.textContent = "▶";
    play.setAttribute("aria-label", "Play");
    play.title = "Play";
  }
  /** The next images are decoded before they are due, so that playing does not flicker. */
  async function step() {
    if (timer === null) return;
    if (index + 1 >= stops.length) { stop(); return; }
    const began = performance.now(), next = index + 1, mine = timer;
    await Promise.all(figures.filter((f) => !f.figure.hidden).map(async (f) => {
      const frame = frameAt(f.list, next);
      if (!frame) return;
      const image = new Image();
      image.src = addressOf(frame.file);
      try { await image.decode(); } catch { /* shown as missing */ }
    }));
    if (timer !== mine) return;
    timer = setTimeout(() => { show(next); step(); }, Math.max(0, 1000 / Number(speed.value) - (performance.now() - began)));
  }
  play.addEventListener("click", () => {
    if (timer !== null) { stop(); return; }
    if (index + 1 >= stops.length) show(0);
    play.textContent = "⏸";
    play.setAttribute("aria-label", "Pause");
    play.title = "Pause";
    timer = setTimeout(step, 1000 / Number(speed.value));
  });
  speed.addEventListener("change", () => { keep.speed = Number(speed.value); });
  slider.addEventListener("input", () => { stop(); show(Number(slider.value)); });
  shared.keys = (e) => { // wherever the focus is, but for what has its own use of the keys
    const to = {ArrowLeft: index - 1, ArrowRight: index + 1, Home: 0, End: stops.length - 1}[e.key];
    if (to === undefined || e.ctrlKey || e.altKey || e.metaKey || e.target.closest("input, select, .plot, .scroll")) return;
    e.preventDefault();
    stop();
    show(to);
  };
  shared.choose = (entry) => {
    stop();
    let best = 0;
    stops.forEach((s, i) => { if (Math.abs(s.cycle - entry.cycle) < Math.abs(stops[best].cycle - entry.cycle)) best = i; });
    show(best);
  };
  shared.stop = stop;

  stop();
  const choices = names.length < 2 ? [] : [make("div", {class: "controls", role: "group", "aria-label": "Frames shown"},
      ...figures.map(({name, figure}) => make("label", {}, make("input", {type: "checkbox", checked: !figure.hidden, onchange: (e) => {
        figure.hidden = !e.target.checked;
        keep.hidden[figure.hidden ? "add" : "delete"](name);
      }}), " " + name)))];
  const body = [make("div", {class: "images"}, ...figures.map((f) => f.figure)),
                make("div", {class: "controls"}, button("previous", "◀◀", "Previous frame", -1), play, button("next", "▶▶", "Next frame", 1), slider, speed, label),
                ...choices];
  show(index);
  return body;
}
