"use strict";
// Plays a session: `session` holds spans (what stood for a while), marks (what happened) and pictures by stimulus.
(function () {
  const session = JSON.parse(document.getElementById("session").textContent);
  const find = (selector) => document.querySelector(selector);
  const image = find(".stage img"), words = find(".stage .words"), now = find(".now");
  const slider = find(".player input"), play = find(".play"), speed = find(".player select"), line = find(".line");
  const list = find(".list tbody");
  const svg = (name, attributes, text) => {
    const element = document.createElementNS("http://www.w3.org/2000/svg", name);
    for (const key in attributes) element.setAttribute(key, attributes[key]);
    if (text) element.appendChild(document.createElementNS("http://www.w3.org/2000/svg", "title")).textContent = text;
    return element;
  };
  const end = Math.max(session.end, 1e-3);
  const bad = (what) => !["answer", "note", "end"].includes(what);
  const clock = (s) => {
    const minutes = Math.floor(s / 60), rest = (s - 60 * minutes).toFixed(1);
    return minutes + ":" + rest.padStart(4, "0");
  };

  // The line: a lane for phases and pauses, one for stimuli, one for panels, one for marks.
  line.setAttribute("viewBox", "0 0 1000 96");
  line.setAttribute("preserveAspectRatio", "none");
  const lanes = { phase: [2, 22], pause: [2, 22], stimulus: [28, 22], panel: [52, 16] };
  for (const span of session.spans) {
    const [y, height] = lanes[span.lane];
    const width = Math.max(1000 * (span.to_s - span.from_s) / end, 0.6);
    line.append(svg("rect", { class: span.lane, x: 1000 * span.from_s / end, y, width, height }, span.label));
  }
  for (const mark of session.marks) {
    const kind = mark.what === "answer" ? "answer" : bad(mark.what) ? "bad" : "answer";
    line.append(svg("rect", { class: kind, x: 1000 * mark.at_s / end - 0.7, y: 72, width: 1.4, height: 22 }, mark.what + ": " + mark.label));
  }
  const cursor = svg("line", { class: "cursor", y1: 0, y2: 96, "vector-effect": "non-scaling-stroke" });
  line.append(cursor);

  // The list: spans and marks by time.
  const rows = session.spans.map((s) => ({ at: s.from_s, what: s.lane, label: s.label + " (" + (s.to_s - s.from_s).toFixed(2) + " s)" }))
    .concat(session.marks.map((m) => ({ at: m.at_s, what: m.what, label: m.label, bad: bad(m.what) })))
    .sort((a, b) => a.at - b.at);
  for (const row of rows) {
    row.element = list.appendChild(document.createElement("tr"));
    for (const text of [clock(row.at), row.what, row.label]) {
      row.element.appendChild(document.createElement("td")).textContent = text;
    }
    if (row.bad) row.element.className = "bad";
    row.element.addEventListener("click", () => show(row.at));
  }

  let at = 0, shown = null;
  function show(time) {
    at = Math.min(Math.max(time, 0), end);
    slider.value = at;
    const x = 1000 * at / end;
    cursor.setAttribute("x1", x);
    cursor.setAttribute("x2", x);
    const stands = (lane) => session.spans.filter((s) => s.lane === lane && s.from_s <= at && at <= s.to_s).pop();
    const span = stands("pause") || stands("stimulus") || stands("panel");
    const phase = stands("phase");
    now.textContent = clock(at) + " of " + clock(end) + (phase ? ", " + phase.label : "") + (span ? ", " + span.label : "");
    const picture = span && span.stimulus !== null ? session.pictures[span.stimulus] : undefined;
    const what = picture || (span ? span.label : phase ? phase.label : "blank");
    if (what !== shown) {
      shown = what;
      image.hidden = !picture;
      words.hidden = Boolean(picture);
      if (picture) { image.src = picture; image.alt = span.label; } else { words.textContent = span ? span.label : "blank frame or page"; }
    }
    let last = null;
    for (const row of rows) {
      row.element.classList.remove("is");
      if (row.at <= at + 1e-9) last = row;
    }
    if (last) last.element.classList.add("is");
  }
  slider.max = end;
  slider.addEventListener("input", () => show(Number(slider.value)));
  line.addEventListener("click", (event) => {
    const box = line.getBoundingClientRect();
    show(end * (event.clientX - box.left) / box.width);
  });
  let before = null;
  function step(time) {
    if (before === null) return;
    show(at + Number(speed.value) * (time - before) / 1000);
    before = time;
    if (at < end) requestAnimationFrame(step); else stop();
  }
  function stop() { before = null; play.textContent = "Play"; }
  play.addEventListener("click", () => {
    if (before !== null) return stop();
    if (at >= end) show(0);
    play.textContent = "Stop";
    before = performance.now();
    requestAnimationFrame(step);
  });
  show(0);
})();
