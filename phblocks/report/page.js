"use strict";
// Tables: a click on a heading sorts, another one the other way round; numbers by value.
for (const table of document.querySelectorAll("table.sortable")) {
  const headings = [...table.tHead.rows[0].cells];
  headings.forEach((heading, column) => heading.addEventListener("click", () => {
    const up = heading.getAttribute("aria-sort") !== "ascending";
    for (const other of headings) other.removeAttribute("aria-sort");
    heading.setAttribute("aria-sort", up ? "ascending" : "descending");
    const key = (row) => {
      const cell = row.cells[column];
      return cell.dataset.value === undefined ? cell.textContent : Number(cell.dataset.value);
    };
    const order = (a, b) => {
      const p = key(a), q = key(b);
      const less = typeof p === "number" && typeof q === "number" ? p - q : String(p).localeCompare(String(q));
      return up ? less : -less;
    };
    table.tBodies[0].append(...[...table.tBodies[0].rows].sort(order));
  }));
}

// The animation.
const store = document.getElementById("scene");
if (store) {
  const scene = JSON.parse(store.textContent);
  const canvas = document.getElementById("stage"), pen = canvas.getContext("2d");
  const slider = document.getElementById("time"), clock = document.getElementById("clock");
  const button = document.getElementById("play"), speed = document.getElementById("speed");
  const trails = document.getElementById("trails");
  const [width, height] = scene.size;
  canvas.height = Math.round(canvas.width * Math.min(0.8, Math.max(0.35, height / width)));
  const scale = Math.min(canvas.width / width, canvas.height / height);
  const left = (canvas.width - scale * width) / 2, below = (canvas.height - scale * height) / 2;
  const X = (x) => left + scale * x, Y = (y) => canvas.height - below - scale * y;
  const signed = scene.colour && scene.colour.name === "bending moment";
  if (![...speed.options].some((o) => Number(o.value) === scene.speed)) {
    speed.add(new Option(String(scene.speed), String(scene.speed)));
  }
  speed.value = String(scene.speed);

  function mix(a, b, s) { return "rgb(" + a.map((v, i) => Math.round(v + s * (b[i] - v))).join(",") + ")"; }
  const BLUE = [40, 80, 200], GREY = [190, 190, 190], RED = [200, 40, 40], DARK = [68, 1, 84], GREEN = [53, 183, 121],
    YELLOW = [253, 231, 37];
  function paint(value) {  // from -1 to 1, or 0 to 1
    if (signed) return value < 0 ? mix(GREY, BLUE, -value) : mix(GREY, RED, value);
    return value < 0.5 ? mix(DARK, GREEN, 2 * value) : mix(GREEN, YELLOW, 2 * value - 1);
  }
  function stroke(points, colour, thick) {
    pen.strokeStyle = colour; pen.lineWidth = thick; pen.beginPath();
    for (let i = 0; i < points.length; i += 2) pen.lineTo(X(points[i]), Y(points[i + 1]));
    pen.stroke();
  }
  function draw(frame) {
    pen.clearRect(0, 0, canvas.width, canvas.height);
    pen.lineCap = pen.lineJoin = "round";
    // a bar of a round length, to scale
    const metres = 10 ** Math.floor(Math.log10(0.25 * width * scene.unit));
    const long = scale * metres / scene.unit;
    pen.fillStyle = "#444"; pen.fillRect(12, canvas.height - 14, long, 3);
    pen.font = "13px system-ui, sans-serif"; pen.fillText(metres + " m", 12, canvas.height - 20);
    if (trails.checked) {
      scene.trails.forEach((trail, i) => stroke(trail.places.slice(0, 2 * (frame + 1)),
        "hsla(" + (137 * i + 30) % 360 + ",60%,45%,0.7)", 1.2));
    }
    for (let i = 0; i < scene.fixed.length; i += 2) {
      const x = X(scene.fixed[i]), y = Y(scene.fixed[i + 1]);
      pen.fillStyle = "#000"; pen.beginPath(); pen.moveTo(x, y); pen.lineTo(x - 8, y + 14); pen.lineTo(x + 8, y + 14);
      pen.fill();
    }
    for (const line of scene.lines) {
      const p = line.places[frame];
      if (!line.values) { stroke(p, "#555", line.dot ? 14 : p.length > 4 ? 4 : 1.5); continue; }
      const v = line.values[frame];
      for (let k = 0; k + 1 < v.length; k++) {
        stroke(p.slice(2 * k, 2 * k + 4), paint((v[k] + v[k + 1]) / 200), 5);
      }
    }
    const joints = scene.joints[frame];
    pen.fillStyle = "#000";
    for (let i = 0; i < joints.length; i += 2) {
      pen.beginPath(); pen.arc(X(joints[i]), Y(joints[i + 1]), 3.5, 0, 7); pen.fill();
    }
    slider.value = String(frame);
    clock.textContent = "t = " + scene.t[frame].toFixed(3) + " s";
    canvas.dataset.frame = String(frame);
  }

  if (scene.colour && scene.colour.largest > 0) {
    const bar = document.createElement("span"), steps = [];
    for (let k = 0; k <= 10; k++) steps.push(paint(signed ? k / 5 - 1 : k / 10));
    bar.className = "bar"; bar.style.background = "linear-gradient(to right," + steps.join(",") + ")";
    const most = scene.colour.largest.toPrecision(3) + " " + scene.colour.unit;
    document.getElementById("legend").append(scene.colour.name + ": " + (signed ? "-" + most : "0"), bar, most);
  }

  let running = false, since = 0, begun = 0;
  const last = scene.t.length - 1;
  function frameAt(t) {
    let low = 0, high = last;
    while (low < high) { const mid = (low + high + 1) >> 1; if (scene.t[mid] <= t) low = mid; else high = mid - 1; }
    return low;
  }
  function tick(now) {
    if (!running) return;
    const t = begun + Number(speed.value) * (now - since) / 1000;
    draw(frameAt(t));
    if (t >= scene.t[last]) { stop(); return; }
    requestAnimationFrame(tick);
  }
  function stop() { running = false; button.textContent = "Play"; }
  function start() {
    if (Number(slider.value) >= last) slider.value = "0";
    running = true; button.textContent = "Pause"; begun = scene.t[Number(slider.value)]; since = performance.now();
    requestAnimationFrame(tick);
  }
  button.addEventListener("click", () => (running ? stop() : start()));
  speed.addEventListener("change", () => { if (running) { begun = scene.t[Number(slider.value)]; since = performance.now(); } });
  slider.addEventListener("input", () => { stop(); draw(Number(slider.value)); });
  trails.addEventListener("change", () => draw(Number(slider.value)));
  draw(0);
}
