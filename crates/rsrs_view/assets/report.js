"use strict";
// What a report adds to its pictures: cells that respond, and runs that move.
// It asks for nothing from elsewhere; its data are the JSON beside it.
(() => {
  const TAIL_S = 20; // How long the way that a robot came is shown, in seconds of the run.
  const SKIP_S = 5;
  const CELL_SPEED = 10;
  const ON_LIDS = "#1a1a1a"; // Letters on the lids of classes, which are as light in every theme.

  const bytes = (base64) => Uint8Array.from(atob(base64), (character) => character.charCodeAt(0));
  const calm = matchMedia("(prefers-reduced-motion: reduce)");
  const dark = matchMedia("(prefers-color-scheme: dark)");

  // A run: poses in frames, between which they are interpolated, and detections at every period.
  class Replay {
    constructor(packed) {
      Object.assign(this, packed);
      const units = (packed_places) => {
        const places = new DataView(bytes(packed_places).buffer);
        return Int16Array.from({ length: places.byteLength / 2 }, (_, at) =>
          places.getInt16(2 * at, true));
      };
      this.places = units(packed.places);
      const { radii_m, places, goals_m, walls_m } =
        packed.world || { radii_m: [], places: "", goals_m: [] };
      [this.object_radii_m, this.object_places, this.goals_m] = [radii_m, units(places), goals_m];
      this.walls_m = walls_m || [];
      this.headings = bytes(packed.headings);
      this.detections = bytes(packed.detections);
      this.n_frames = this.headings.length / this.n_robots;
      this.duration_s = (this.n_frames - 1) * this.frame_s;
      this.labels = this.robots.map((name) => (name.match(/\d+$/) || [""])[0]);
    }

    // The frames before and after a time, and how far it is on the way from one to the other.
    frames(time_s) {
      const frame = Math.min(Math.max(time_s / this.frame_s, 0), this.n_frames - 1);
      const before = Math.floor(frame);
      return [before, Math.min(before + 1, this.n_frames - 1), frame - before];
    }

    // Between two entries of places: [x in m, y in m].
    between(places, one, other, share) {
      return this.centre_m.map((centre_m, axis) => {
        const from = places[2 * one + axis];
        return centre_m + (from + share * (places[2 * other + axis] - from)) * this.unit_m;
      });
    }

    // Where a robot is: [x in m, y in m, heading in radians].
    pose(robot, time_s) {
      const [before, after, share] = this.frames(time_s);
      const [one, other] = [before, after].map((at) => at * this.n_robots + robot);
      const turned = ((this.headings[other] - this.headings[one] + 384) & 255) - 128;
      const heading = this.headings[one] + share * turned;
      return [...this.between(this.places, one, other, share), (heading * Math.PI) / 128];
    }

    // Where objects are, and their radii: [x in m, y in m, radius in m] each.
    objects(time_s) {
      const [before, after, share] = this.frames(time_s);
      const n_objects = this.object_radii_m.length;
      return this.object_radii_m.map((radius_m, object) => {
        const [one, other] = [before, after].map((at) => at * n_objects + object);
        return [...this.between(this.object_places, one, other, share), radius_m];
      });
    }

    detects(robot, time_s) {
      const sample = Math.floor(time_s / this.period_s + 1e-6);
      const bit = sample * this.n_robots + robot;
      return ((this.detections[bit >> 3] >> (bit & 7)) & 1) === 1;
    }
  }

  // The floor from above.
  class Floor {
    constructor(canvas) {
      this.canvas = canvas;
      this.context = canvas.getContext("2d");
      this.follow_theme();
    }

    follow_theme() {
      this.colour = theme_colours(
        ["paper", "ink", "quiet", "trail", "body", "region", "lit", "ring", "lost", "object", "goal"]);
    }

    resize() {
      sharpen(this.canvas);
    }

    draw(replay, time_s) {
      const { context: pen, canvas } = this;
      this.replay = replay;
      this.scale = canvas.width / (2 * replay.half_side_m);
      this.line_px = Math.max(canvas.width / 480, 1);
      pen.fillStyle = this.colour.paper;
      pen.fillRect(0, 0, canvas.width, canvas.height);
      const robots = Array.from({ length: replay.n_robots }, (_, robot) => robot);
      const poses = robots.map((robot) => replay.pose(robot, time_s));
      replay.walls_m.forEach((corners_m, outline) => this.wall(corners_m, outline > 0));
      replay.goals_m.forEach((goal) => this.goal(goal));
      replay.objects(time_s).forEach((object) => this.object(object));
      robots.forEach((robot) => this.trail(robot, time_s));
      robots.forEach((robot) => this.regions(robot, poses[robot], replay.detects(robot, time_s)));
      if (replay.ring_m) this.ring(replay.ring_m);
      robots.forEach((robot) => this.robot(poses[robot], robot));
      this.scale_bar();
      if (replay.classes) this.legend(replay.classes);
    }

    point(x_m, y_m) {
      const { centre_m, half_side_m } = this.replay;
      return [
        (x_m - centre_m[0] + half_side_m) * this.scale,
        (centre_m[1] + half_side_m - y_m) * this.scale,
      ];
    }

    path(points) {
      this.context.beginPath();
      points.forEach(([x, y]) => this.context.lineTo(x, y));
    }

    stroke(colour, width) {
      this.context.strokeStyle = colour;
      this.context.lineWidth = width * this.line_px;
      this.context.stroke();
    }

    trail(robot, time_s) {
      const { replay, context: pen } = this;
      const points = [];
      const first = Math.max(Math.ceil((time_s - TAIL_S) / replay.frame_s), 0);
      for (let frame = first; frame * replay.frame_s < time_s; frame += 1) {
        const [x_m, y_m] = replay.pose(robot, frame * replay.frame_s);
        points.push(this.point(x_m, y_m));
      }
      const [x_m, y_m] = replay.pose(robot, time_s);
      points.push(this.point(x_m, y_m));
      this.path(points);
      pen.globalAlpha = 0.5;
      this.stroke(this.colour.trail, 1.3);
      pen.globalAlpha = 1;
    }

    regions(robot, pose, is_lit) {
      // What a report tells of detections is that of the first sensor.
      const regions_m = this.replay.own_regions_m?.[robot] ?? this.replay.regions_m;
      regions_m.forEach((corners_m, sensor) =>
        this.region(pose, corners_m, is_lit && sensor === 0));
    }

    region([x_m, y_m, heading], corners_m, is_lit) {
      const pen = this.context;
      const [sine, cosine] = [Math.sin(heading), Math.cos(heading)];
      this.path(corners_m.map(([ahead, left]) =>
        this.point(x_m + ahead * cosine - left * sine, y_m + ahead * sine + left * cosine)));
      pen.closePath();
      pen.globalAlpha = is_lit ? 0.45 : 0.1;
      pen.fillStyle = is_lit ? this.colour.lit : this.colour.region;
      pen.fill();
      pen.globalAlpha = is_lit ? 0.9 : 0.35;
      this.stroke(is_lit ? this.colour.lit : this.colour.region, 0.8);
      pen.globalAlpha = 1;
    }

    // The border of the arena, or an obstacle, which is filled.
    wall(corners_m, is_filled) {
      this.path(corners_m.map(([x_m, y_m]) => this.point(x_m, y_m)));
      this.context.closePath();
      this.context.globalAlpha = 0.35;
      this.context.fillStyle = this.colour.quiet;
      if (is_filled) this.context.fill();
      this.context.globalAlpha = 1;
      this.stroke(this.colour.quiet, 1.5);
    }

    disc([x_m, y_m, radius_m]) {
      const [x, y] = this.point(x_m, y_m);
      this.context.beginPath();
      this.context.arc(x, y, radius_m * this.scale, 0, 2 * Math.PI);
    }

    dashed(colour, width, dashes) {
      this.context.setLineDash(dashes.map((dash) => dash * this.line_px));
      this.stroke(colour, width);
      this.context.setLineDash([]);
    }

    ring(ring_m) {
      this.disc(ring_m);
      this.dashed(this.colour.ring, 1.6, [7, 4]);
    }

    goal(goal_m) {
      const pen = this.context;
      this.disc(goal_m);
      pen.globalAlpha = 0.12;
      pen.fillStyle = this.colour.goal;
      pen.fill();
      pen.globalAlpha = 1;
      this.dashed(this.colour.goal, 1.2, [5, 3]);
    }

    object(object_m) {
      const pen = this.context;
      this.disc(object_m);
      pen.fillStyle = this.colour.object;
      pen.fill();
      this.stroke(this.colour.ink, 0.8);
    }

    robot([x_m, y_m, heading], robot) {
      const pen = this.context;
      const radius = Math.max(this.replay.radius_m * this.scale, 3 * this.line_px);
      const colour = this.replay.lost.includes(robot) ? this.colour.lost : this.colour.ink;
      const [x, y] = this.point(x_m, y_m);
      pen.beginPath();
      pen.arc(x, y, radius, 0, 2 * Math.PI);
      const { lids, of_robots } = this.replay.classes || { lids: [], of_robots: [] };
      const lid = lids[of_robots[robot]];
      pen.fillStyle = lid || this.colour.body;
      pen.fill();
      this.stroke(colour, 1.4);
      const ahead = (reach) => [x + reach * Math.cos(heading), y - reach * Math.sin(heading)];
      this.path([ahead(radius), ahead(1.6 * radius)]);
      this.stroke(colour, 2.2);
      if (radius > 8 * this.line_px) {
        pen.fillStyle = lid ? ON_LIDS : colour;
        pen.font = `${Math.round(radius)}px sans-serif`;
        pen.textAlign = "center";
        pen.textBaseline = "middle";
        pen.fillText(this.replay.labels[robot], x, y);
      }
    }

    // The names of classes beside their lids, from the lower left corner upwards.
    legend({ names, lids }) {
      const pen = this.context;
      const line = 16 * this.line_px;
      names.forEach((name, at) => {
        const [x, y] = [line, this.canvas.height - (names.length - at - 0.25) * line];
        pen.beginPath();
        pen.arc(x, y, 5 * this.line_px, 0, 2 * Math.PI);
        pen.fillStyle = lids[at];
        pen.fill();
        this.stroke(this.colour.ink, 1);
        pen.fillStyle = this.colour.ink;
        pen.font = `${Math.round(11 * this.line_px)}px sans-serif`;
        pen.textAlign = "left";
        pen.textBaseline = "middle";
        pen.fillText(name, x + 9 * this.line_px, y);
      });
    }

    scale_bar() {
      const pen = this.context;
      const most_m = this.replay.half_side_m / 2;
      const decade = 10 ** Math.floor(Math.log10(most_m));
      const length_m = [5, 2, 1].map((step) => step * decade).find((step) => step <= most_m);
      const edge = 12 * this.line_px;
      const [right, bottom] = [this.canvas.width - edge, this.canvas.height - edge];
      this.path([[right - length_m * this.scale, bottom], [right, bottom]]);
      this.stroke(this.colour.ink, 2);
      pen.fillStyle = this.colour.ink;
      pen.font = `${Math.round(11 * this.line_px)}px sans-serif`;
      pen.textAlign = "right";
      pen.textBaseline = "bottom";
      pen.fillText(`${Number(length_m.toPrecision(1))} m`, right, bottom - 3 * this.line_px);
    }
  }

  // A floor with its controls.
  class Player {
    constructor(element, show_time) {
      this.element = element;
      this.floor = new Floor(element.querySelector("canvas"));
      this.button = element.querySelector(".play");
      this.slider = element.querySelector(".time");
      this.clock = element.querySelector(".clock");
      this.speed = element.querySelector(".speed");
      this.loops = element.dataset.ends === "loop";
      this.show_time = show_time;
      this.time_s = 0;
      this.is_playing = false;
      this.is_visible = false;
      this.button.addEventListener("click", () => this.toggle());
      this.slider.addEventListener("input", () => this.seek(Number(this.slider.value)));
      new ResizeObserver(() => this.draw()).observe(this.floor.canvas);
      new IntersectionObserver((entries) => {
        this.is_visible = entries[entries.length - 1].isIntersecting;
        wake();
      }).observe(element);
    }

    load(replay) {
      this.replay = replay;
      this.element.hidden = !replay;
      if (!replay) return;
      this.slider.max = replay.duration_s;
      this.seek(0);
    }

    seek(time_s) {
      this.time_s = Math.min(Math.max(time_s, 0), this.replay.duration_s);
      this.draw();
    }

    play(is_playing) {
      this.is_playing = is_playing;
      this.button.textContent = is_playing ? "Pause" : "Play";
      wake();
    }

    toggle() {
      if (!this.is_playing && this.time_s >= this.replay.duration_s) this.seek(0);
      this.play(!this.is_playing);
    }

    advance(passed_s) {
      let time_s = this.time_s + passed_s * Number(this.speed.value);
      if (time_s >= this.replay.duration_s) {
        if (this.loops) time_s = 0;
        else this.play(false);
      }
      this.seek(time_s);
    }

    draw() {
      if (!this.replay) return;
      const run_s = this.replay.start_s + this.time_s;
      this.slider.value = this.time_s;
      this.slider.setAttribute("aria-valuetext", `${run_s.toFixed(0)} s`);
      this.clock.textContent = `${run_s.toFixed(1)} s`;
      this.floor.resize();
      this.floor.draw(this.replay, this.time_s);
      if (this.show_time) this.show_time(this.time_s / this.replay.duration_s);
    }
  }

  // One loop moves all that plays and can be seen.
  const players = [];
  let last_ms = null;
  function wake() {
    if (last_ms === null && players.some((player) => player.is_playing && player.is_visible)) {
      last_ms = performance.now();
      requestAnimationFrame(move);
    }
  }
  function move(now_ms) {
    const passed_s = Math.min(Math.max(now_ms - last_ms, 0), 100) / 1000;
    const moving = players.filter((player) => player.is_playing && player.is_visible);
    moving.forEach((player) => player.advance(passed_s));
    last_ms = moving.length > 0 ? now_ms : null;
    if (last_ms !== null) requestAnimationFrame(move);
  }

  const packed = JSON.parse(document.getElementById("replays").textContent);
  const unpacked = new Map();
  function replay_of(element) {
    const number = element.dataset.replay;
    if (number === undefined) return null;
    if (!unpacked.has(number)) unpacked.set(number, new Replay(packed[Number(number)]));
    return unpacked.get(number);
  }

  function show_runs() {
    for (const run of document.querySelectorAll(".run")) {
      const element = run.querySelector(".player");
      if (!element) continue;
      const cursor = run.querySelector(".cursor");
      const player = new Player(element, (share) => cursor.style.setProperty("--at", share));
      players.push(player);
      element.hidden = false;
      // Unpacked once it comes near.
      new IntersectionObserver((entries, observer) => {
        if (!entries.some((entry) => entry.isIntersecting)) return;
        observer.disconnect();
        player.load(replay_of(run));
      }, { rootMargin: "600px" }).observe(run);
    }
  }

  // The cells of all slices; whatever is pointed at or focused is shown.
  function show_cells() {
    const cells = [...document.querySelectorAll("[role=gridcell]")];
    const player = new Player(document.getElementById("cell-player"));
    player.speed.value = CELL_SPEED;
    players.push(player);
    const facts_of = (cell) => document.getElementById(`cell-${cell.dataset.cell}`);
    let shown = cells.find((cell) => cell.tabIndex === 0) || cells[0];
    const show = (cell) => {
      if (cell !== shown) {
        facts_of(shown).hidden = true;
        shown.tabIndex = -1;
        shown.setAttribute("aria-selected", "false");
        shown = cell;
        player.load(replay_of(facts_of(cell)));
      }
      facts_of(cell).hidden = false;
      cell.tabIndex = 0;
      cell.setAttribute("aria-selected", "true");
    };
    for (const cell of cells) {
      cell.addEventListener("pointerenter", (event) => event.pointerType === "mouse" && show(cell));
      cell.addEventListener("click", () => show(cell));
      cell.addEventListener("focus", () => show(cell));
      cell.addEventListener("keydown", (event) => step(event, cell));
    }
    player.load(replay_of(facts_of(shown)));
    player.play(!calm.matches);
  }

  // Arrow keys go from cell to cell.
  function step(event, cell) {
    const row = [...cell.parentElement.children];
    const rows = [...cell.parentElement.parentElement.children];
    const at = row.indexOf(cell);
    const above = (by) => {
      const other = rows[rows.indexOf(cell.parentElement) + by];
      return other && nearest(cell, [...other.children]);
    };
    const targets = {
      ArrowLeft: () => row[at - 1],
      ArrowRight: () => row[at + 1],
      ArrowUp: () => above(-1),
      ArrowDown: () => above(1),
      Home: () => row[0],
      End: () => row[row.length - 1],
    };
    const target = targets[event.key];
    if (!target) return;
    event.preventDefault();
    const next = target();
    if (next) next.focus();
  }
  function nearest(cell, others) {
    const away = (other) => Math.abs(other.offsetLeft - cell.offsetLeft);
    return others.reduce((best, other) => (away(other) < away(best) ? other : best));
  }

  // The player that has the focus, else the one whose middle is nearest to that of the window.
  function addressed() {
    const holds_focus = (player) => player.element.contains(document.activeElement);
    const away = ({ element }) => {
      const { top, bottom } = element.getBoundingClientRect();
      return Math.abs((top + bottom) / 2 - innerHeight / 2);
    };
    const loaded = players.filter((player) => player.replay);
    const visible = loaded.filter((player) => player.is_visible);
    return loaded.find(holds_focus) || visible.sort((one, other) => away(one) - away(other))[0];
  }
  function on_key(event) {
    if (event.ctrlKey || event.metaKey || event.altKey || event.target.matches("select")) return;
    const player = addressed();
    if (!player) return;
    if (event.key === "k") player.toggle();
    if (event.key === "j") player.seek(player.time_s - SKIP_S);
    if (event.key === "l") player.seek(player.time_s + SKIP_S);
  }

  // The page that simulates lies in this one: it opens at the cell, in a window of its own.
  let simulator = null;
  async function unpacked_page() {
    const packed = new Blob([bytes(document.getElementById("simulator").textContent)]);
    const page = new Response(packed.stream().pipeThrough(new DecompressionStream("gzip")));
    return URL.createObjectURL(new Blob([await page.arrayBuffer()], { type: "text/html" }));
  }
  async function simulate({ dataset }) {
    simulator ||= await unpacked_page();
    const source = document.getElementById("source").textContent;
    open(`${simulator}#${dataset.address}&source=${encodeURIComponent(source)}`, "_blank");
  }
  for (const button of document.querySelectorAll(".simulate")) {
    button.addEventListener("click", () => simulate(button));
  }

  document.documentElement.classList.add("moves");
  document.querySelectorAll(".scripted").forEach((element) => (element.hidden = false));
  show_cells();
  show_runs();
  document.addEventListener("keydown", on_key);
  dark.addEventListener("change", () => players.forEach((player) => {
    player.floor.follow_theme();
    player.draw();
  }));
})();
