"use strict";
// What the page does: a swarm in motion, its judge in a thread of its own, and a diagram that fills in.
// All that is computed is computed by the simulator; here are its inputs, and what is drawn.
(() => {
  const element = (id) => document.getElementById(id);
  const facts = JSON.parse(element("facts").textContent);
  const axis_of = Object.fromEntries(facts.axes.map((axis) => [axis.key, axis]));
  const phase_of = Object.fromEntries(facts.phases.map((phase) => [phase.key, phase]));
  const colour_of = Object.fromEntries(facts.parameters.map((it) => [it.key, it.colour]));

  // Which settings have a slider: key, least, greatest, step. A value beyond widens its slider.
  const GROUPS = [
    ["What robots are told", true, [
      ["speed_m_s", 0.02, 0.3, 0.005], ["turn_rate_rad_s", 0.1, 2.5, 0.05]]],
    ["The swarm", true, [
      ["robots", 1, 300, 1], ["placement_radius_m", 0.2, 6, 0.025]]],
    ["The sensor", true, [
      ["range_m", 0.1, 4, 0.05], ["half_angle_rad", 0, 1.5, 0.02], ["true_positive", 0, 1, 0.01],
      ["false_positive", 0, 1, 0.01]]],
    ["Noise, differences and delays", false, [
      ["heterogeneity", 0, 0.3, 0.01], ["gain_noise", 0, 0.3, 0.01],
      ["heading_noise_rad", 0, 0.2, 0.005], ["turn_bias_rad_s", 0, 0.3, 0.005],
      ["gust_m_s", 0, 0.1, 0.002], ["yaw_lag_s", 0, 1, 0.02], ["latency_steps", 0, 10, 1]]],
    ["While none is detected", false, [
      ["undetected_speed_m_s", -0.3, 0.3, 0.005], ["undetected_turn_rate_rad_s", -2.5, 2.5, 0.05]]],
    ["Arena, mounting and gains", false, [
      ["arena_m", 2, 40, 0.5], ["sensor_bearing_rad", -1.6, 1.6, 0.02], ["polygon_scale", 0.2, 2, 0.02],
      ["speed_gain", 0.5, 1.5, 0.01], ["turn_gain", 0.5, 1.5, 0.01], ["period_s", 0.02, 0.5, 0.01]]],
  ];
  const SLIDERS = Object.fromEntries(GROUPS.flatMap(([, , rows]) => rows.map((row) => [row[0], row])));
  const USUAL = { robots: [2, 22], placement_radius_m: [0.4, 2.4], range_m: [0.2, 3], half_angle_rad: [0.1, 1.2] };
  const STARTS = [
    ["disc_facing_out", "in a disc, facing out"], ["box_facing_out", "in a box, facing out"],
    ["box_facing_any_way", "in a box, facing any way"]];
  const EXPLAINED = {
    rotation: "how well headings circle the middle: 1 where all go round it one way",
    orbit: "how far robots go around the middle, over how far they were told to drive",
    circliness: "how round the ring is: 1 for a circle",
    blocked: "share of time in which robots were blocked",
    stuck: "share of robots that were blocked nearly all of the time",
    lost: "share of robots with nobody within reach for most of the time",
    clustered: "share of robots in the largest cluster",
  };
  const PHASES_EXPLAINED = {
    stable_milling: "one ring that rotates, free of contact, with every robot on it",
    semi_stable_milling: "rotation around a centre, but no clean ring",
    unformed: "none of the others, mostly two separate mills",
    dispersion: "a quarter of the robots or more have nobody within reach",
    colliding_unstable: "robots block each other and stand",
    aggregated: "nine tenths of the robots or more are in one cluster",
    partly_aggregated: "half of the robots or more are in one cluster",
    not_aggregated: "less than half of the robots are in one cluster",
    spread_out: "nine tenths of the robots or more have nobody within reach",
    partly_spread_out: "half of the robots or more have nobody within reach",
    not_spread_out: "less than half of the robots have nobody within reach",
  };
  const ORDER = {
    milling: ["rotation", "orbit", "circliness", "blocked", "stuck", "lost"],
    aggregation: ["clustered"],
    dispersal: ["lost"],
  };
  const PACES = [1, 2, 5, 10, 20, 50];
  const REPLICATES = 20;
  const AT_ONCE = 4; // A vector has four lanes.
  const TAIL_S = 20;
  const TAIL_EVERY_S = 0.5;
  // What fills in by itself takes seconds, in steps of robots.
  const MOST_UNASKED = 3e8;
  const MOST_ROBOTS = 2000; // More stand still on a screen.
  const calm = matchMedia("(prefers-reduced-motion: reduce)");
  const dark = matchMedia("(prefers-color-scheme: dark)");

  const number = (value, digits = 12) => String(Number(value.toPrecision(digits)));
  const with_unit = (key, value) => {
    const { name, unit } = axis_of[key];
    const count = unit === "robots" ? `${value} robots` : `${name} ${number(value, 6)}`;
    return unit && unit !== "robots" ? `${count} ${unit}` : count;
  };
  const capitalised = (text) => text.charAt(0).toUpperCase() + text.slice(1);
  // Who moves sliders has no file with lines and keys, and sees which cell it is.
  const in_words_of_page = (message) => message
    .replace(/^cell `[^`]*`: /, "")
    .replace(/ at line \d+ column \d+$/, "")
    .replace(/\nstay within the limits; .* in their profile/, "")
    .replace(/^\w+(?= is )/, (key) => axis_of[key]?.name || key);
  const defined = (of, words) => of.map(([title, key]) => `<dt>${title}</dt><dd>${words[key]}</dd>`).join("");
  const some_time = (time_s) =>
    time_s < 90 ? `${Math.max(5 * Math.ceil(time_s / 5), 5)} s` : `${Math.ceil(time_s / 60)} min`;

  // What is shown: a sweep of a robot as text, which keeps every number as it was written, and what is
  // set differently.
  const first = () => ({
    source: facts.source,
    cell: {},
    as_measured: false,
    start: null,
    seed: null,
    replicate: "0",
    across: null,
    up: null,
    // More robots start in a larger disc, as dense as it was, until somebody sets the disc; it fits into the
    // arena, until somebody sets that.
    disc_follows: true,
    arena_follows: true,
  });
  let state = first();
  let simulated = null; // The state of the swarm that is watched, which a refused setting leaves as it is.

  // A scene for the simulator. A seed may have more digits than a number of this language.
  function scene(changes = {}) {
    const { source, cell, as_measured, start, seed } = { ...state, ...changes };
    const parts = [`"source":${source}`, `"cell":${JSON.stringify(cell)}`];
    if (as_measured) parts.push('"as_measured":true');
    if (start) parts.push(`"start":${JSON.stringify(start)}`);
    if (seed !== null) parts.push(`"seed":${seed}`);
    const axes = changes.axes === undefined ? grid_axes() : changes.axes;
    if (axes) parts.push(`"axes":${JSON.stringify(axes)}`);
    return `{${parts.join(",")}}`;
  }

  // The address: only what differs from the first page.
  let left_out = []; // What an address has that is no setting.
  function from_address(hash) {
    const given = new URLSearchParams(hash.slice(1));
    state = first();
    left_out = [];
    if (given.has("source")) state.source = given.get("source");
    const digits = (key) => (/^\d{1,20}$/.test(given.get(key) || "") ? given.get(key) : null);
    state.seed = digits("seed") && String(BigInt(digits("seed")));
    state.replicate = digits("replicate") || "0";
    state.as_measured = given.get("robots_are") === "as_measured";
    const [kind, width_m, height_m] = (given.get("start") || "").split(",");
    if (kind === "disc_facing_out") state.start = { kind, radius_m: 1 };
    else if (STARTS.some(([key]) => key === kind)) {
      state.start = { kind, width_m: Number(width_m), height_m: Number(height_m) };
    }
    for (const side of ["across", "up"]) {
      if (given.get(side) in SLIDERS) state[side] = given.get(side);
    }
    const is_taken = {
      source: () => true,
      seed: () => state.seed !== null,
      replicate: () => digits("replicate") !== null,
      robots_are: () => true,
      start: () => state.start !== null,
      across: () => state.across !== null,
      up: () => state.up !== null,
    };
    for (const [key, value] of given) {
      if (key in axis_of && value.trim() !== "" && Number.isFinite(Number(value))) {
        state.cell[key] = Number(value);
      } else if (!is_taken[key]?.()) left_out.push(value === "" ? key : `${key}=${value}`);
    }
  }
  function address() {
    const { robots, placement_radius_m } = state.cell;
    const is_alone = robots !== undefined && placement_radius_m === undefined && !is_boxed();
    const cell = is_alone ? { ...state.cell, placement_radius_m: swarm.values.placement_radius_m } : state.cell;
    const parts = Object.entries(cell).filter(([, value]) => value !== undefined).map(([key, value]) => `${key}=${value}`);
    const { start, seed, replicate, across, up } = state;
    if (state.as_measured) parts.push("robots_are=as_measured");
    if (start) parts.push(`start=${[start.kind, start.width_m, start.height_m].filter((it) => it !== undefined).join(",")}`);
    if (seed !== null) parts.push(`seed=${seed}`);
    if (replicate !== "0") parts.push(`replicate=${replicate}`);
    if (across) parts.push(`across=${across}`);
    if (up) parts.push(`up=${up}`);
    if (state.source !== facts.source) parts.push(`source=${encodeURIComponent(state.source)}`);
    return `#${parts.join("&")}`;
  }

  // The axes of the diagram: those of the sweep, unless others are chosen or there are too many values.
  const MOST_VALUES = [15, 12];
  let source_axes = [];
  function grid_axes() {
    const keys = [state.across || source_axes[0]?.[0], state.up || source_axes[1]?.[0]];
    const others = ["speed_m_s", "turn_rate_rad_s"];
    keys.forEach((key, at) => {
      if (!key || keys.indexOf(key) !== at) keys[at] = others.find((other) => !keys.includes(other));
    });
    const values = (key, most) => {
      const swept = source_axes.find(([other]) => other === key)?.[1];
      if (swept && swept.length > 1 && swept.length <= most) return swept;
      const [, least, greatest, step] = swept && swept.length > 1
        ? [key, swept[0], swept[swept.length - 1], 0]
        : (ranges[key] || SLIDERS[key]);
      const n = most === MOST_VALUES[0] ? 11 : 8;
      if (step === 0) return { from: least, to: greatest, steps: n };
      // Round numbers within what nine or so robots have use for.
      const [from, to] = USUAL[key] || [least, greatest];
      const value = (at) => Number((step * Math.round((from + ((to - from) * at) / (n - 1)) / step)).toFixed(6));
      return [...new Set(Array.from({ length: n }, (_, at) => value(at)))];
    };
    return Object.fromEntries(keys.map((key, at) => [key, values(key, MOST_VALUES[at])]));
  }

  // The simulator on this thread moves the watched swarm.
  const asked = (what, text) => {
    put(text);
    return got(simulator[what]());
  };

  // A thread that answers one question after the other.
  class Thread {
    constructor(url, module) {
      this.worker = new Worker(url);
      this.waiting = new Map();
      this.n_asked = 0;
      this.worker.onmessage = ({ data }) => {
        const { resolve, reject } = this.waiting.get(data.id);
        this.waiting.delete(data.id);
        if (data.refusal === undefined) resolve(data);
        else reject(new Error(data.refusal));
      };
      this.ready = this.ask({ task: "load", module });
    }

    ask(question) {
      this.n_asked += 1;
      const id = this.n_asked;
      return new Promise((resolve, reject) => {
        this.waiting.set(id, { resolve, reject });
        this.worker.postMessage({ id, ...question });
      });
    }
  }

  // The floor from above. One path for all of a colour: three hundred robots are a few strokes.
  const floor = {
    canvas: element("floor"),
    view: null,
    trails: [],

    follow_theme() {
      this.colour = theme_colours(
        ["paper", "ink", "quiet", "rule", "trail", "body", "region", "lit", "ring", "lost"]);
    },

    resize() {
      sharpen(this.canvas);
    },

    // Rows of x, y, heading and flags, and how it all lies on the canvas.
    draw(rows, is_new) {
      const { canvas, colour } = this;
      const pen = (this.pen ||= canvas.getContext("2d"));
      const n = rows.length / 4;
      const { radius_m, outline_m, walls_m, reach_m } = swarm;
      let [left, right, low, high] = [Infinity, -Infinity, Infinity, -Infinity];
      for (let at = 0; at < rows.length; at += 4) {
        left = Math.min(left, rows[at]);
        right = Math.max(right, rows[at]);
        low = Math.min(low, rows[at + 1]);
        high = Math.max(high, rows[at + 1]);
      }
      const wanted = n === 0 ? [0, 0, 1] : [
        (left + right) / 2, (low + high) / 2,
        // A disc faces out: at the start sensors are around it.
        Math.max(right - left, high - low) / 2 + 2 * radius_m + (simulator.n_steps() === 0 ? 1 : 0.35) * reach_m,
      ];
      if (!this.view || is_new) this.view = wanted;
      const ease = is_moving() ? 0.06 : 1;
      this.view = this.view.map((value, at) => value + ease * (wanted[at] - value));
      const [x_m, y_m, half_m] = this.view;
      const scale = canvas.width / (2 * half_m);
      const line = Math.max(canvas.width / 520, 1);
      const at_x = (x) => (x - x_m + half_m) * scale;
      const at_y = (y) => (y_m + half_m - y) * scale;

      pen.fillStyle = colour.paper;
      pen.fillRect(0, 0, canvas.width, canvas.height);
      if (walls_m !== null) {
        pen.strokeStyle = colour.quiet;
        pen.lineWidth = 1.5 * line;
        pen.strokeRect(at_x(-walls_m), at_y(walls_m), 2 * walls_m * scale, 2 * walls_m * scale);
      }

      pen.beginPath();
      // What many robots draw is what takes time: their trails are shorter, and their sensors have no rim.
      const is_crowd = n > 60;
      const tail_s = is_crowd ? TAIL_S / 5 : TAIL_S;
      const oldest = Math.max(this.trails.length - tail_s / TAIL_EVERY_S, 0);
      for (let robot = 0; robot < n; robot += 1) {
        for (let at = oldest; at < this.trails.length; at += 1) {
          const x = at_x(this.trails[at][2 * robot]);
          const y = at_y(this.trails[at][2 * robot + 1]);
          if (at === oldest) pen.moveTo(x, y);
          else pen.lineTo(x, y);
        }
        if (this.trails.length > 0) pen.lineTo(at_x(rows[4 * robot]), at_y(rows[4 * robot + 1]));
      }
      pen.globalAlpha = 0.5;
      pen.strokeStyle = colour.trail;
      pen.lineWidth = 1.2 * line;
      pen.stroke();

      for (const is_lit of [0, 1]) {
        pen.beginPath();
        for (let at = 0; at < rows.length; at += 4) {
          if ((rows[at + 3] & 1) !== is_lit) continue;
          const [x, y] = [at_x(rows[at]), at_y(rows[at + 1])];
          const [cosine, sine] = [scale * Math.cos(rows[at + 2]), scale * Math.sin(rows[at + 2])];
          outline_m.forEach(([ahead, aside], corner) => {
            const [to_x, to_y] = [x + ahead * cosine - aside * sine, y - ahead * sine - aside * cosine];
            if (corner === 0) pen.moveTo(to_x, to_y);
            else pen.lineTo(to_x, to_y);
          });
          pen.closePath();
        }
        pen.fillStyle = is_lit ? colour.lit : colour.region;
        pen.globalAlpha = is_lit ? 0.45 : 0.12;
        pen.fill();
        if (is_crowd) continue;
        pen.strokeStyle = pen.fillStyle;
        pen.lineWidth = 0.8 * line;
        pen.globalAlpha = is_lit ? 0.9 : 0.35;
        pen.stroke();
      }
      pen.globalAlpha = 1;

      if (ring_m !== null && n > 0) {
        let [sum_x, sum_y] = [0, 0];
        for (let at = 0; at < rows.length; at += 4) {
          sum_x += rows[at];
          sum_y += rows[at + 1];
        }
        pen.beginPath();
        pen.arc(at_x(sum_x / n), at_y(sum_y / n), ring_m * scale, 0, 7);
        pen.setLineDash([7 * line, 4 * line]);
        pen.strokeStyle = colour.ring;
        pen.lineWidth = 1.6 * line;
        pen.stroke();
        pen.setLineDash([]);
      }

      const radius = Math.max(radius_m * scale, 2.5 * line);
      for (const is_blocked of [0, 2]) {
        pen.beginPath();
        for (let at = 0; at < rows.length; at += 4) {
          if ((rows[at + 3] & 2) !== is_blocked) continue;
          const [x, y] = [at_x(rows[at]), at_y(rows[at + 1])];
          pen.moveTo(x + radius, y);
          pen.arc(x, y, radius, 0, 7);
        }
        pen.fillStyle = colour.body;
        pen.fill();
        pen.strokeStyle = is_blocked ? colour.lost : colour.ink;
        pen.lineWidth = 1.4 * line;
        pen.stroke();
        pen.beginPath();
        for (let at = 0; at < rows.length; at += 4) {
          if ((rows[at + 3] & 2) !== is_blocked) continue;
          const [x, y] = [at_x(rows[at]), at_y(rows[at + 1])];
          const [cosine, sine] = [Math.cos(rows[at + 2]), Math.sin(rows[at + 2])];
          pen.moveTo(x + radius * cosine, y - radius * sine);
          pen.lineTo(x + 1.6 * radius * cosine, y - 1.6 * radius * sine);
        }
        pen.lineWidth = 2.2 * line;
        pen.stroke();
      }
      if (radius > 8 * line) {
        pen.fillStyle = colour.ink;
        pen.font = `${Math.round(radius)}px sans-serif`;
        pen.textAlign = "center";
        pen.textBaseline = "middle";
        for (let robot = 0; robot < n; robot += 1) {
          pen.fillText(robot + 1, at_x(rows[4 * robot]), at_y(rows[4 * robot + 1]));
        }
      }

      const most_m = half_m / 2;
      const decade = 10 ** Math.floor(Math.log10(most_m));
      const length_m = [5, 2, 1].map((step) => step * decade).find((step) => step <= most_m);
      const [edge_x, edge_y] = [canvas.width - 12 * line, canvas.height - 12 * line];
      // Its paper keeps it apart from a wall behind it.
      pen.fillStyle = colour.paper;
      pen.fillRect(edge_x - length_m * scale - 4 * line, edge_y - 18 * line, length_m * scale + 8 * line, 22 * line);
      pen.beginPath();
      pen.moveTo(edge_x - length_m * scale, edge_y);
      pen.lineTo(edge_x, edge_y);
      pen.strokeStyle = colour.ink;
      pen.lineWidth = 2 * line;
      pen.stroke();
      pen.fillStyle = colour.ink;
      pen.font = `${Math.round(11 * line)}px sans-serif`;
      pen.textAlign = "right";
      pen.textBaseline = "bottom";
      pen.fillText(`${Number(length_m.toPrecision(1))} m`, edge_x, edge_y - 3 * line);
    },
  };

  // The outline of a sensor's region, in the robot's frame.
  function outline(region) {
    if (region.polygon) return region.polygon.corners_m;
    const { half_angle_rad, range_m } = region.cone;
    const n = Math.max(2, Math.ceil(half_angle_rad / 0.1));
    const on_arc = (at) => (2 * at / n - 1) * half_angle_rad;
    const arc = Array.from({ length: n + 1 }, (_, at) =>
      [range_m * Math.cos(on_arc(at)), range_m * Math.sin(on_arc(at))]);
    return [[0, 0], ...arc];
  }

  // The watched swarm.
  let swarm = null; // What the simulator states of the scene.
  let before = new Float32Array();
  let after = new Float32Array();
  let between = new Float32Array();
  let owed_steps = 0;
  let is_playing = !calm.matches;
  let ring_m = null;
  let is_placed = false;
  let run = 0; // Numbers the runs, so that answers about an earlier one are dropped.
  const is_moving = () => is_playing && is_placed;
  const n_steps_of = (duration_s) => Math.floor(duration_s / swarm.period_s + 1e-9);

  function advance(n_steps) {
    const at = simulator.step(n_steps);
    const found = new Float32Array(simulator.memory.buffer, at, after.length);
    before.set(n_steps > 1 ? found : after);
    after.set(found);
  }

  // Between two control periods robots are where they are on the way.
  function rows() {
    const share = owed_steps;
    for (let at = 0; at < after.length; at += 4) {
      const turned = after[at + 2] - before[at + 2];
      const way = turned - 2 * Math.PI * Math.round(turned / (2 * Math.PI));
      between[at] = before[at] + share * (after[at] - before[at]);
      between[at + 1] = before[at + 1] + share * (after[at + 1] - before[at + 1]);
      between[at + 2] = before[at + 2] + share * way;
      between[at + 3] = after[at + 3];
    }
    return between;
  }

  // Places the robots, or throws why they cannot be placed; then the swarm is the one before.
  function place() {
    put(scene());
    got(simulator.open(BigInt(state.replicate)));
  }

  function restart() {
    place();
    begin();
  }

  function begin() {
    run += 1;
    is_placed = true;
    const n = 4 * swarm.robots;
    [before, after, between] = [n, n, n].map((length) => new Float32Array(length));
    advance(0);
    before.set(after);
    owed_steps = 0;
    floor.trails = [];
    ring_m = null;
    history = [];
    at_end = null;
    judge.open();
    show_judgement({ time_s: 0 });
    floor.draw(rows(), true);
    show_clock();
  }

  function refuse(error) {
    is_placed = false;
    element("phase").textContent = "Not simulated:";
    element("why").textContent = "these settings cannot be simulated.";
    element("status-symbol").removeAttribute("href");
    floor.canvas.classList.add("stale");
    say(in_words_of_page(error.message));
  }

  // What is watched goes on, and so do the diagram, the judge and the address; the setting that was refused
  // stays where it was put, and is marked.
  function refuse_change(error, set) {
    state = structuredClone(simulated);
    show_settings();
    if (set) {
      const { slider, exact } = controls[set.key];
      slider.value = set.value;
      exact.value = number(set.value, 5);
      exact.setAttribute("aria-invalid", "true");
    }
    say(`${in_words_of_page(error.message)}\nThe swarm is still the one from before.`);
  }
  function say(words) {
    element("refusal").textContent = capitalised(words);
    element("refusal").hidden = false;
  }
  function say_nothing() {
    element("refusal").hidden = true;
    element("copied").textContent = "";
    floor.canvas.classList.remove("stale");
    for (const { exact } of Object.values(controls)) exact.removeAttribute("aria-invalid");
  }

  const pace = element("pace");
  let last_ms = 0;
  function frame(now_ms) {
    requestAnimationFrame(frame);
    const passed_s = Math.min(Math.max(now_ms - last_ms, 0), 100) / 1000;
    last_ms = now_ms;
    if (!is_moving() || document.hidden) return;
    owed_steps += (passed_s * Number(pace.value)) / swarm.period_s;
    let n_steps = Math.floor(owed_steps);
    owed_steps -= n_steps;
    const every = Math.max(1, Math.round(TAIL_EVERY_S / swarm.period_s));
    while (n_steps > 0) {
      const some = Math.min(n_steps, every - (simulator.n_steps() % every));
      advance(some);
      n_steps -= some;
      if (simulator.n_steps() % every === 0) {
        const places = new Float32Array(after.length / 2);
        for (let robot = 0; robot < places.length / 2; robot += 1) {
          places[2 * robot] = after[4 * robot];
          places[2 * robot + 1] = after[4 * robot + 1];
        }
        floor.trails.push(places);
        if (floor.trails.length > (2 * TAIL_S) / TAIL_EVERY_S) floor.trails.splice(0, TAIL_S / TAIL_EVERY_S);
      }
    }
    floor.resize();
    floor.draw(rows(), false);
    show_clock();
    judge.look(now_ms);
  }

  function show_clock() {
    const time_s = simulator.n_steps() * swarm.period_s;
    const text = `${time_s.toFixed(0)} s`;
    if (element("clock").textContent !== text) element("clock").textContent = text;
  }

  function play(wanted) {
    is_playing = wanted;
    element("play").textContent = wanted ? "Pause" : "Play";
  }

  // The judge, in its own thread with its own copy of the swarm.
  let history = [];
  let at_end = null;
  const judge = {
    thread: null,
    is_busy: false,
    looked_ms: 0,
    opened: 0,

    async open() {
      if (!this.thread) return;
      const [of, text, replicate] = [run, scene(), state.replicate];
      try {
        await this.thread.ask({ task: "open", scene: text, replicate });
        this.opened = of;
      } catch (error) {
        if (of === run) refuse(error);
      }
    },

    async look(now_ms) {
      if (this.is_busy || this.opened !== run || now_ms - this.looked_ms < 200) return;
      const of = run;
      const now = simulator.n_steps();
      const end = n_steps_of(swarm.duration_s);
      const last = history.length > 0 ? history[history.length - 1].n_steps : 0;
      if (now <= last) return;
      // A sweep judges at the end of the run, so it is looked at just then.
      const n_steps = last < end && end <= now ? end : now;
      this.is_busy = true;
      this.looked_ms = now_ms;
      try {
        const { judgement } = await this.thread.ask({ task: "judge", n_steps });
        if (of === run) {
          history.push({ n_steps, ...judgement });
          if (history.length > 4000) history = history.filter((_, at) => at % 2 === 1);
          if (n_steps === end) at_end = judgement.phase;
          show_judgement(judgement);
        }
      } catch (error) {
        if (of === run) refuse(error);
      }
      this.is_busy = false;
    },
  };

  function show_judgement(judgement) {
    const { phase, evidence, reason } = judgement;
    const use = element("status-symbol");
    if (phase) use.setAttribute("href", `#symbol-${phase}`);
    else use.removeAttribute("href");
    const title = `${phase ? capitalised(phase_of[phase].title) : "Not judged yet"}:`;
    if (element("phase").textContent !== title) element("phase").textContent = title;
    const end = at_end ? ` At ${swarm.duration_s} s, when a sweep judges a run, it was ${phase_of[at_end].title}.` : "";
    const why = phase
      ? (reason.length > 0 ? `${reason.join("; ")}.` : "every measure is within its bounds.")
      : "the judge needs a whole minute of driving.";
    element("why").textContent = `${why}${end}`;
    ring_m = phase && phase === swarm.phases[0] && phase === "stable_milling" ? evidence.mean_radius_m : null;
    for (const row of order_rows) row.show(judgement);
  }

  // The order parameters, a row each.
  let order_rows = [];
  function lay_out_order() {
    const holds = {
      at_least: (found, bound) => found >= bound,
      below: (found, bound) => found < bound,
      at_most: (found, bound) => found <= bound,
    };
    const body = element("order");
    body.replaceChildren();
    element("wanted").textContent = phase_of[swarm.phases[0]].title;
    element("window").textContent =
      `Order parameters of the last minute, from 0 to 1. A dashed line is the bound of ${phase_of[swarm.phases[0]].title}.`;
    const row_of = (key) => {
      const row = body.insertRow();
      const bounds = swarm.bounds.filter((bound) => bound.key === key);
      row.innerHTML =
        `<th scope="row">${key}</th>` +
        "<td>–</td><td><canvas aria-hidden=\"true\"></canvas></td><td></td>";
      const [, value, , verdict] = row.cells;
      const canvas = row.querySelector("canvas");
      const show = ({ evidence, phase }) => {
        const found = evidence ? evidence[key] : null;
        const is_known = found !== null && found !== undefined;
        value.textContent = is_known ? found.toFixed(2) : "–";
        if (bounds.length > 0) {
          const all_hold = bounds.every(({ needs, bound }) => holds[needs](found, bound));
          const in_words = bounds.map((bound) => bound.in_words).join(", ");
          // Before there is a phase, nothing is judged.
          verdict.textContent = `${is_known && phase ? (all_hold ? "✓ " : "✗ ") : ""}${in_words}`;
        }
        draw_curve(canvas, key, bounds);
      };
      return { show };
    };
    const bounded = [...new Set(swarm.bounds.map(({ key }) => key))];
    const keys = ORDER[swarm.behaviour] || bounded;
    order_rows = keys.map(row_of);
    element("measures").innerHTML = defined(keys.filter((key) => key in EXPLAINED).map((key) => [key, key]), EXPLAINED);
    element("phases").innerHTML = defined(swarm.phases.map((key) => [phase_of[key].title, key]), PHASES_EXPLAINED);
    // Another behaviour has rules of its own for phases of the same name.
    element("phases").closest("details").hidden = !(swarm.behaviour in ORDER);
    const row = body.insertRow();
    row.className = "strip";
    row.innerHTML = '<th scope="row">phase</th><td></td><td><canvas aria-hidden="true"></canvas></td><td></td>';
    const canvas = row.querySelector("canvas");
    order_rows.push({ show: () => draw_strip(canvas) });
  }

  function chart(canvas) {
    const [width, height] = [canvas.clientWidth, canvas.clientHeight]
      .map((side) => Math.max(1, Math.round(side * devicePixelRatio)));
    if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
    const pen = canvas.getContext("2d");
    pen.clearRect(0, 0, width, height);
    const now_s = history.length > 0 ? history[history.length - 1].time_s : 0;
    const most_s = Math.max(swarm.duration_s, now_s);
    element("time-axis").textContent = `0 to ${most_s.toFixed(0)} s`;
    return { pen, width, height, x: (time_s) => (time_s / most_s) * width };
  }

  function draw_curve(canvas, key, bounds) {
    const { pen, width, height, x } = chart(canvas);
    const line = devicePixelRatio;
    const y = (value) => height - line - Math.min(Math.max(value, 0), 1) * (height - 2 * line);
    pen.strokeStyle = floor.colour.rule;
    pen.lineWidth = line;
    pen.strokeRect(line / 2, line / 2, width - line, height - line);
    for (const { bound } of bounds.filter(({ bound }) => bound > 0.005)) {
      pen.setLineDash([4 * line, 3 * line]);
      pen.strokeStyle = floor.colour.quiet;
      pen.beginPath();
      pen.moveTo(0, y(bound));
      pen.lineTo(width, y(bound));
      pen.stroke();
      pen.setLineDash([]);
    }
    pen.beginPath();
    for (const { time_s, evidence } of history) {
      const value = evidence?.[key];
      if (value !== null && value !== undefined) pen.lineTo(x(time_s), y(value));
    }
    const colour = colour_of[key];
    pen.strokeStyle = colour === "#555555" ? floor.colour.quiet
      : colour === "#0072b2" ? floor.colour.trail : colour;
    pen.lineWidth = 2 * line;
    pen.stroke();
  }

  function draw_strip(canvas) {
    const { pen, height, x } = chart(canvas);
    let from_s = 0;
    for (const { time_s, phase } of history) {
      if (phase) {
        pen.fillStyle = phase_of[phase].colour;
        pen.fillRect(x(from_s), 0, Math.max(x(time_s) - x(from_s), 1) + 0.5, height);
      }
      from_s = time_s;
    }
    pen.strokeStyle = floor.colour.rule;
    pen.lineWidth = devicePixelRatio;
    pen.strokeRect(0, 0, canvas.width, height);
  }

  // Settings.
  const ranges = {}; // Key, least, greatest, step, as they are for this robot.
  const controls = {};
  let touched = null; // The setting that is being moved, whose control stays as it is.

  function lay_out_settings() {
    const holder = element("sliders");
    for (const [title, is_open, rows_of_group] of GROUPS) {
      const group = document.createElement(is_open ? "fieldset" : "details");
      group.innerHTML = is_open ? `<legend>${title}</legend>` : `<summary>${title}</summary>`;
      for (const [key] of rows_of_group) group.append(setting(key));
      if (title === "The swarm") group.append(start_choice());
      holder.append(group);
    }
  }

  // Where numbers have a point, a browser drops a comma that is typed: 1,5 would be 15.
  const has_point = (1.5).toLocaleString().includes(".");
  function point_for_comma(event) {
    if (event.data !== "," || !has_point) return;
    event.preventDefault();
    document.execCommand("insertText", false, ".");
  }

  function setting(key) {
    const { name, unit } = axis_of[key];
    const row = document.createElement("div");
    row.className = "setting";
    row.innerHTML =
      `<label for="${key}">${name}</label><input id="${key}" type="range">` +
      `<input type="number" step="any" aria-label="${name}${unit && unit !== "robots" ? `, in ${unit}` : ""}">` +
      `<span class="unit">${unit === "robots" ? "" : unit}</span>`;
    const [label, slider, exact] = row.children;
    const set = (value, control) => {
      if (value === "" || !Number.isFinite(Number(value))) {
        say_nothing();
        return show_settings();
      }
      touched = control;
      change(key, Number(value));
      touched = null;
    };
    slider.addEventListener("input", () => set(slider.value, slider));
    exact.addEventListener("change", () => set(exact.value, exact));
    exact.addEventListener("beforeinput", point_for_comma);
    controls[key] = { row, label, slider, exact };
    return row;
  }

  function start_choice() {
    const row = document.createElement("div");
    row.innerHTML =
      '<div class="setting"><label for="start">start</label><select id="start"></select></div>' +
      '<div class="setting"><label for="robots-are">robots are</label><select id="robots-are">' +
      '<option value="worse">worse than measured</option><option value="as_measured">as measured</option></select></div>' +
      '<div class="setting"><label for="seed">seed</label><input id="seed" type="number" min="0" step="1"></div>' +
      '<div class="setting"><label for="replicate">replicate</label><input id="replicate" type="number" min="0" step="1"></div>';
    const start = row.querySelector("#start");
    start.innerHTML = STARTS.map(([kind, words]) => `<option value="${kind}">${words}</option>`).join("");
    start.addEventListener("change", () => {
      const side_m = Number((1.7 * (swarm.values.placement_radius_m || 1)).toFixed(2));
      state.start = start.value === "disc_facing_out"
        ? { kind: start.value, radius_m: 1 }
        : { kind: start.value, width_m: side_m, height_m: side_m };
      // A box has no radius that a diagram could go over.
      for (const side of ["across", "up"]) if (state[side] === "placement_radius_m") state[side] = null;
      update();
    });
    const digits = (name, take) => ({ target }) => {
      if (/^\d{1,19}$/.test(target.value)) return take(String(BigInt(target.value)));
      show_settings();
      say(`a ${name} is a whole number from 0 on, of at most 19 digits; it is still ${target.value}`);
    };
    row.querySelector("#seed").addEventListener("change", digits("seed", (seed) => {
      state.seed = seed;
      update();
    }));
    row.querySelector("#replicate").addEventListener("change", digits("replicate", set_replicate));
    row.querySelector("#robots-are").addEventListener("change", ({ target }) => {
      state.as_measured = target.value === "as_measured";
      update();
    });
    return row;
  }

  function change(key, value) {
    const set = { key, value };
    if (key === "arena_m") state.arena_follows = false;
    if (key === "placement_radius_m") {
      state.disc_follows = false;
      if (is_boxed()) {
        state.start = { kind: swarm.placement, width_m: value, height_m: value };
        return update({ set });
      }
    }
    if (key === "robots" && value <= MOST_ROBOTS && !is_boxed()) follow(value);
    state.cell[key] = value;
    update({ set });
  }
  function disc_of(n_robots) {
    const { robots, placement_radius_m } = first_values;
    const radius_m = placement_radius_m * Math.sqrt(Math.max(n_robots, 0) / Math.max(robots, 1));
    return Number(Math.max(radius_m, 0.1).toFixed(3));
  }
  function follow(n_robots) {
    if (!state.disc_follows) return;
    state.cell.placement_radius_m = disc_of(n_robots);
    const needed_m = 2.6 * state.cell.placement_radius_m;
    if (state.arena_follows) delete state.cell.arena_m;
    if (needed_m > (state.cell.arena_m || first_values.arena_m)) state.cell.arena_m = Math.ceil(needed_m);
  }
  const is_boxed = () => swarm && swarm.placement.startsWith("box");

  let first_values = {};
  function show_settings() {
    const { values, limits } = swarm;
    for (const [key, { row, label, slider, exact }] of Object.entries(controls)) {
      let value = values[key];
      if (key === "placement_radius_m") {
        if (is_boxed()) value = swarm.conditions.placement.width_m;
        label.textContent = is_boxed() ? "side of the box" : axis_of[key].name;
      }
      row.hidden = value === undefined ||
        (key === "placement_radius_m" && swarm.placement === "given") ||
        (key === "polygon_scale" && values.polygon_scale === undefined);
      if (row.hidden) continue;
      let [, least, greatest, step] = SLIDERS[key];
      if (limits[key]) [least, greatest] = limits[key];
      if (swarm.is_mirrored === false && limits[key]) least = -greatest;
      ranges[key] = [key, Math.min(least, value), Math.max(greatest, value), step];
      [, least, greatest] = ranges[key];
      Object.assign(slider, { min: least, max: greatest, step: "any" });
      // Steps that hit round numbers, and the value that it has.
      slider.step = touched === slider ? step : "any";
      if (touched !== slider) slider.value = value;
      slider.step = step;
      slider.min = Math.floor(least / step + 1e-6) * step;
      if (touched !== slider) slider.value = value;
      slider.setAttribute("aria-valuetext", with_unit(key, value));
      if (touched !== exact) exact.value = number(value, 5);
      const follows = { placement_radius_m: state.disc_follows, arena_m: state.arena_follows }[key];
      const is_set = key === "placement_radius_m" && is_boxed() ? state.start !== null
        : state.cell[key] !== undefined && !follows && Math.abs(value - first_values[key]) > 1e-9;
      row.classList.toggle("changed", is_set);
    }
    const chosen = {
      start: state.start !== null,
      "robots-are": state.as_measured,
      seed: state.seed !== null,
      replicate: state.replicate !== "0",
    };
    for (const [id, is_set] of Object.entries(chosen)) {
      element(id).closest(".setting").classList.toggle("changed", is_set);
    }
    const whose = state.source === facts.source ? "page" : "sweep";
    element("bold").textContent = `Settings that differ from the ${whose}'s own are bold. ` +
      "The placement radius follows the number of robots, and the arena the placement radius, until you set them.";
    element("start").value = swarm.placement;
    element("start").closest(".setting").hidden = !STARTS.some(([kind]) => kind === swarm.placement);
    element("robots-are").value = state.as_measured ? "as_measured" : "worse";
    element("seed").value = swarm.seed;
    element("replicate").value = state.replicate;
    element("robot").textContent = `Robots of the profile “${swarm.name}”${made_worse()}.`;
  }

  // What a sweep makes worse, and by how much; not what somebody has set.
  function made_worse() {
    if (state.as_measured) return ", as measured";
    const measured = JSON.parse(asked("describe", scene({ as_measured: true }))).values;
    const is_worse = (key) => Math.abs(swarm.values[key] - measured[key]) > 1e-9;
    const worse = Object.keys(measured).filter(is_worse)
      .map((key) => `${with_unit(key, swarm.values[key])} (measured ${number(measured[key], 6)})`);
    return worse.length > 0
      ? `, made worse than measured, so that real ones do at least as well: ${worse.join("; ")}` : "";
  }

  // The diagram.
  const plane = {
    threads: [],
    key: null,
    counts: [],
    values: [[], []],
    keys: [],
    cells: [],
    n_done: 0,
    filling: 0,
    is_filling: false,
    timer: 0,

    scene_of(at) {
      const [columns] = this.values;
      const [x, y] = [at % columns.length, Math.floor(at / columns.length)];
      return { ...state.cell, [this.keys[0]]: this.values[0][x], [this.keys[1]]: this.values[1][y] };
    },

    // Lays the cells out where the axes are others, and asks for runs where anything else is.
    update() {
      const [[x_key, x_values], [y_key, y_values]] = swarm.axes;
      const rest = { ...state.cell, [x_key]: 0, [y_key]: 0 };
      const ordered = Object.fromEntries(Object.entries(rest).sort());
      const key = scene({ cell: ordered }) + JSON.stringify(swarm.axes);
      if (key !== this.key) {
        this.key = key;
        this.keys = [x_key, y_key];
        this.values = [x_values, y_values];
        this.counts = x_values.flatMap(() => y_values.map(() => null));
        this.lay_out();
        this.stop();
        this.n_done = 0;
        this.took_s = null;
        this.progress();
        clearTimeout(this.timer);
        const n_steps = n_steps_of(swarm.duration_s);
        this.cost = this.counts.length * REPLICATES * n_steps * swarm.robots;
        const is_asked = this.cost > MOST_UNASKED;
        element("fill").hidden = !is_asked;
        const while_s = this.cost / this.per_s;
        element("runs").textContent = is_asked
          ? `${this.counts.length} cells of ${swarm.robots} robots take ${this.per_s ? `${some_time(while_s)} or longer` : "a while"}.` : "";
        if (!is_asked) this.timer = setTimeout(() => this.fill(), 400);
      }
      this.select();
    },

    lay_out() {
      const [columns, rows_up] = this.values;
      const holder = element("grid-holder");
      holder.style.setProperty("--columns", columns.length);
      const label = (value) => number(value, 3);
      const [x, y] = this.keys.map((key) => axis_of[key]);
      const words = ({ name, unit }) => (!unit || name.endsWith(unit) ? name : `${name} (${unit})`);
      const lines = rows_up.map((value, row) => {
        const cells = columns.map((_, column) =>
          `<div role="gridcell" class="empty" tabindex="-1" aria-selected="false" data-at="${row * columns.length + column}"></div>`);
        return `<div role="row"><span role="rowheader">${label(value)}</span>${cells.join("")}</div>`;
      }).reverse();
      const ticks = columns.map((value) => `<span>${label(value)}</span>`);
      holder.innerHTML =
        `<p class="up">${words(y)}</p><div class="grid"><div role="grid" aria-label="cells of the phase diagram">${lines.join("")}</div>` +
        '<span class="between" id="between" hidden></span></div>' +
        `<div class="columns${columns.length > 6 ? " many" : ""}" aria-hidden="true"><span></span>${ticks.join("")}</div><p class="across">${words(x)}</p>`;
      this.cells = [];
      for (const cell of holder.querySelectorAll("[role=gridcell]")) {
        const at = Number(cell.dataset.at);
        this.cells[at] = cell;
        cell.addEventListener("click", () => this.choose(at));
        cell.addEventListener("pointerenter", () => this.point(at));
        cell.addEventListener("pointerleave", () => this.point(null));
        cell.addEventListener("focus", () => this.point(at));
        cell.addEventListener("blur", () => this.point(null));
        cell.addEventListener("keydown", (event) => this.step(event, at));
        this.paint(at);
      }
      element("legend").innerHTML = swarm.phases
        .map((key) => `<li><span class="swatch" style="background: ${phase_of[key].colour}"></span> ${phase_of[key].title}</li>`).join("");
      for (const [side, key] of [["across", this.keys[0]], ["up", this.keys[1]]]) {
        const other = this.keys[side === "across" ? 1 : 0];
        const keys = Object.keys(SLIDERS).filter((it) => swarm.values[it] !== undefined && it !== other);
        element(side).innerHTML = keys.map((it) =>
          `<option value="${it}"${it === key ? " selected" : ""}>${axis_of[it].name}</option>`).join("");
      }
    },

    // As the diagrams of reports: the hue of the most frequent phase, paler the smaller its share.
    paint(at) {
      const cell = this.cells[at];
      const counts = this.counts[at];
      cell.classList.toggle("empty", counts === null);
      cell.classList.toggle("refused", counts !== null && counts.refusal !== undefined);
      cell.style.background = "";
      cell.setAttribute("aria-label", this.in_words(at));
      if (counts === null || counts.refusal !== undefined) return;
      const total = swarm.phases.reduce((sum, key) => sum + (counts[key] || 0), 0);
      const most = swarm.phases.reduce((best, key) => ((counts[key] || 0) > (counts[best] || 0) ? key : best));
      const { least_hue: least } = phase_of[most];
      const share = Math.max(counts[most] / total - facts.least_share, 0) / (1 - facts.least_share);
      const amount = 100 * (least + (1 - least) * share);
      cell.style.background = `color-mix(in oklab, ${phase_of[most].colour} ${amount.toFixed(1)}%, #ffffff)`;
    },

    in_words(at) {
      const of = this.scene_of(at);
      const name = this.keys.map((key) => with_unit(key, of[key])).join(", ");
      const counts = this.counts[at];
      if (counts === null) return `${name}: not simulated yet`;
      if (counts.refusal !== undefined) return `${name}: ${counts.refusal}`;
      const total = swarm.phases.reduce((sum, key) => sum + (counts[key] || 0), 0);
      const shares = swarm.phases.filter((key) => counts[key])
        .map((key) => `${counts[key]} ${phase_of[key].title}`);
      return `${name}: ${total} runs, ${shares.join(", ")}`;
    },

    point(at) {
      const shown = at === null ? this.selected : at;
      const words = shown === null
        ? "The watched swarm is no cell of this diagram. Click a cell to watch it." : this.in_words(shown);
      element("pointed").textContent = words;
    },

    // The cell that is watched, if it is one of the diagram's.
    select() {
      const is_near = (one, other) => Math.abs(one - other) <= 1e-9 * Math.max(1, Math.abs(one));
      const places = this.keys.map((key, side) =>
        this.values[side].findIndex((value) => is_near(value, swarm.values[key])));
      this.selected = places.includes(-1) ? null : places[1] * this.values[0].length + places[0];
      const reachable = this.selected === null ? 0 : this.selected;
      this.cells.forEach((cell, at) => {
        cell.setAttribute("aria-selected", String(at === this.selected));
        cell.tabIndex = at === reachable ? 0 : -1;
      });
      const [x, y] = this.keys.map((key, side) => this.share_of(swarm.values[key], this.values[side]));
      element("between").hidden = this.selected !== null || !Number.isFinite(x + y);
      element("between").style.cssText =
        `left: calc(var(--label) + (100% - var(--label)) * ${x}); bottom: ${100 * y}%`;
      this.point(null);
    },

    // Where a value is along an axis: a cell's in the middle of the cell, one beyond all cells at the edge.
    share_of(value, values) {
      const above = values.findIndex((it) => it > value);
      const low = values[above - 1];
      const at = above === 0 ? -0.5
        : above > 0 ? above - 1 + (value - low) / (values[above] - low)
        : values.length - (value > values[values.length - 1] ? 0.5 : 1);
      return (at + 0.5) / values.length;
    },

    choose(at) {
      go(() => {
        if (this.keys.includes("placement_radius_m")) state.disc_follows = false;
        if (this.keys.includes("arena_m")) state.arena_follows = false;
        state.cell = this.scene_of(at);
        if (update({ keeps_address: true })) floor.canvas.scrollIntoView({ block: "nearest" });
      });
    },

    step(event, at) {
      const n = this.values[0].length;
      const column = at % n;
      const targets = {
        ArrowLeft: column > 0 ? at - 1 : at,
        ArrowRight: column < n - 1 ? at + 1 : at,
        ArrowUp: at + n,
        ArrowDown: at - n,
        Home: at - column,
        End: at - column + n - 1,
      };
      if (event.key === "Enter" || event.key === " ") {
        event.preventDefault();
        this.choose(at);
      } else if (event.key in targets) {
        event.preventDefault();
        const target = this.cells[targets[event.key]];
        if (target) {
          this.cells.forEach((cell) => (cell.tabIndex = -1));
          target.tabIndex = 0;
          target.focus();
        }
      }
    },

    progress() {
      const wanted = this.counts.length * REPLICATES;
      element("progress").value = this.n_done / wanted;
      if (this.n_done === 0) return;
      const n_refused = this.counts.filter((it) => it?.refusal !== undefined).length;
      const n_runs = wanted - n_refused * REPLICATES;
      const took = this.took_s ? ` in ${this.took_s.toFixed(1)} s` : "";
      const which = n_refused > 0 ? "each cell that can be simulated" : "each cell";
      const all = n_runs === 0 ? "None of these cells can be simulated."
        : `${n_runs} runs of ${swarm.duration_s} s${took}, ${REPLICATES} in ${which}. A sweep with seed ${swarm.seed} makes the same runs, and more.`;
      const passed_s = (performance.now() - this.began_ms) / 1000;
      const left = passed_s > 2 ? `, about ${some_time((passed_s * (wanted - this.n_done)) / this.n_done)} left` : "";
      element("runs").textContent =
        this.n_done < wanted ? `${this.n_done} of ${wanted} runs of ${swarm.duration_s} s${left}` : all;
    },

    // Runs of all cells, a few of each at a time; a cell goes to whichever thread is idle.
    async fill() {
      this.stop();
      const filling = this.filling;
      this.is_filling = true;
      element("fill").hidden = false;
      element("fill").textContent = "Stop";
      this.began_ms = performance.now();
      this.took_s = null;
      this.n_done = 0;
      this.counts = this.counts.map(() => null);
      this.cells.forEach((_, at) => this.paint(at));
      const near = this.selected ?? 0;
      const n = this.values[0].length;
      const away = (at) => Math.hypot((at % n) - (near % n), Math.floor(at / n) - Math.floor(near / n));
      const order = this.counts.map((_, at) => at).sort((one, other) => away(one) - away(other));
      const jobs = [];
      for (let from = 0; from < REPLICATES; from += AT_ONCE) {
        for (const at of order) jobs.push({ at, from });
      }
      const axes = grid_axes();
      let next = 0;
      const work = async (thread) => {
        await thread.ready;
        while (next < jobs.length && filling === this.filling) {
          const { at, from } = jobs[next];
          next += 1;
          if (this.counts[at]?.refusal !== undefined) {
            this.n_done += AT_ONCE;
            continue;
          }
          const question = { task: "count", scene: scene({ cell: this.scene_of(at), axes }), from, to: from + AT_ONCE };
          let found;
          try {
            found = (await thread.ask(question)).counts;
          } catch (error) {
            found = { refusal: in_words_of_page(error.message) };
          }
          if (filling !== this.filling) return;
          const sum = { ...(this.counts[at] || {}) };
          for (const [phase, count] of Object.entries(found)) {
            sum[phase] = phase === "refusal" ? count : (sum[phase] || 0) + count;
          }
          this.counts[at] = sum;
          this.n_done += AT_ONCE;
          this.paint(at);
          if (at === this.selected) this.point(null);
          this.progress();
        }
      };
      await Promise.all(this.threads.map(work));
      if (filling !== this.filling) return;
      this.stop();
      element("fill").hidden = true;
      this.took_s = (performance.now() - this.began_ms) / 1000;
      this.per_s = this.cost / this.took_s;
      this.progress();
    },

    // What a thread has begun it ends, and its answer is dropped.
    halt() {
      this.stop();
      element("runs").textContent = `Stopped after ${this.n_done} of ${this.counts.length * REPLICATES} runs.`;
    },
    stop() {
      this.filling += 1;
      this.is_filling = false;
      element("fill").textContent = "Simulate it";
    },
  };

  // A phase of a behaviour that is not built in looks as that of milling in its place.
  function know_phase({ key, title, colour }, place) {
    if (key in phase_of) return;
    const alike = facts.phases[place];
    const own = alike.colour;
    phase_of[key] = { ...alike, key, title, colour: colour || own };
    phase_of[key].symbol = alike.symbol.replaceAll(own, phase_of[key].colour);
    add_symbol(phase_of[key]);
  }
  function add_symbol({ key, symbol: marks }) {
    element("symbols").insertAdjacentHTML(
      "beforeend", `<symbol id="symbol-${key}" viewBox="-9 -9 18 18">${marks}</symbol>`);
  }

  // Takes the state over everywhere.
  let watched = null; // Which swarm it is: one that is the same goes on.
  function update({ keeps_address = false, set = null } = {}) {
    let description;
    let is_another;
    say_nothing();
    try {
      const { robots } = state.cell;
      if (robots > MOST_ROBOTS) throw new Error(`robots is ${robots}, expected at most ${MOST_ROBOTS} in a browser`);
      description = JSON.parse(asked("describe", scene()));
      if (description.conditions.robots === 0) throw new Error("robots is 0, expected at least 1");
      const asked_for = [description.digest, description.seed, state.replicate, state.source].join();
      is_another = asked_for !== watched;
      if (is_another) place();
      watched = asked_for;
    } catch (error) {
      if (!simulated) throw error;
      refuse_change(error, set);
      return false;
    }
    simulated = structuredClone(state);
    const { conditions } = description;
    const had = swarm;
    swarm = {
      ...description,
      robots: conditions.robots,
      period_s: conditions.period_s,
      radius_m: conditions.robot.radius_m,
      outline_m: outline(conditions.robot.region),
      placement: conditions.placement.kind,
      is_mirrored: conditions.controller.undetected === undefined,
    };
    swarm.reach_m = Math.max(...swarm.outline_m.map(([x, y]) => Math.hypot(x, y)));
    swarm.phase_entries.forEach(know_phase);
    if (!had || had.behaviour !== swarm.behaviour) lay_out_order();
    show_settings();
    if (is_another) begin();
    plane.update();
    if (!keeps_address) take_address();
    show_sweep();
    return true;
  }

  // A slider that is moved changes the address often, which browsers do not like.
  let address_timer = 0;
  function take_address() {
    clearTimeout(address_timer);
    address_timer = setTimeout(() => write_address("replaceState"), 150);
  }
  function write_address(how) {
    clearTimeout(address_timer);
    // A page without a place of its own, as one that lies in a report, keeps its address.
    try {
      window.history[how](null, "", address());
    } catch {
      return;
    }
  }
  // What the browser's way back undoes: another cell, or other settings altogether.
  function go(change_state) {
    const from = address();
    write_address("replaceState");
    change_state();
    if (address() !== from) write_address("pushState");
  }

  // Whether all its cells can be simulated takes a while to find out.
  let sweep_timer = 0;
  function show_sweep() {
    clearTimeout(sweep_timer);
    if (!element("sweep").closest("details").open) return;
    sweep_timer = setTimeout(() => {
      try {
        element("sweep").textContent = sweep_file();
      } catch (error) {
        element("sweep").textContent = error.message;
      }
    }, 300);
  }
  const sweep_file = () => asked("sweep_file", scene());

  async function copy(text, what) {
    let said = `${what} is copied.`;
    try {
      await navigator.clipboard.writeText(text);
    } catch {
      said = `This browser does not let a page copy: ${what.toLowerCase()} is below.`;
      element("sweep").textContent = text;
      element("sweep").closest("details").open = true;
    }
    element("copied").textContent = said;
  }

  // A sweep without a cell is shown in the middle of its axes.
  function open_source() {
    source_axes = [];
    const { sweep, profile } = JSON.parse(state.source);
    if (!sweep || !profile) throw new Error("the link has a source without a sweep or without a profile");
    const axes = sweep.axes ? Object.entries(sweep.axes) : [];
    if (sweep.cells) {
      for (const key of Object.keys(sweep.cells[0])) {
        axes.push([key, [...new Set(sweep.cells.map((cell) => cell[key]))].sort((one, other) => one - other)]);
      }
    }
    source_axes = axes;
    const is_own = state.source === facts.source;
    const shipped = is_own ? { speed_m_s: 0.15, turn_rate_rad_s: 0.75 } : {};
    const usual = Object.fromEntries(axes.map(([key, values]) =>
      [key, shipped[key] ?? values[Math.floor((values.length - 1) / 2)]]));
    first_values = JSON.parse(asked("describe", scene({ cell: usual, as_measured: false, start: null }))).values;
    state.cell = { ...usual, ...state.cell };
    const { robots, placement_radius_m, arena_m } = state.cell;
    if (is_own && robots <= MOST_ROBOTS && placement_radius_m === undefined && !state.start) follow(robots);
    state.disc_follows = placement_radius_m === undefined || placement_radius_m === disc_of(robots ?? first_values.robots);
    state.arena_follows = arena_m === undefined ||
      (state.disc_follows && arena_m === Math.ceil(2.6 * placement_radius_m));
  }

  function open_address(hash = location.hash) {
    clearTimeout(address_timer);
    simulated = null;
    try {
      from_address(hash);
      open_source();
      update({ keeps_address: true });
    } catch (error) {
      state = first();
      open_source();
      update({ keeps_address: true });
      say(`the settings of the link cannot be simulated, and the page's own are shown: ${in_words_of_page(error.message)}`);
      return;
    }
    if (left_out.length > 0) say(`the link has parts that are no settings; they are left out: ${left_out.join(", ")}`);
  }

  function on_key(event) {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const { target } = event;
    if (target.matches("select, textarea")) return;
    const is_typed = target.matches("input[type=number]");
    const acts = target.matches("button, summary, a, [role=gridcell]");
    if ((event.key === " " && !acts && !is_typed) || (event.key === "k" && !is_typed)) {
      event.preventDefault();
      play(!is_playing);
    }
    if (event.key === "r" && !is_typed) restart_anew();
    if (event.key === "n" && !is_typed) other_start();
  }
  function restart_anew() {
    say_nothing();
    restart();
  }
  function other_start() {
    say_nothing();
    set_replicate(String((BigInt(state.replicate) + 1n) % 1000000n));
  }
  function set_replicate(replicate) {
    state.replicate = replicate;
    update();
  }

  async function unpacked(base64) {
    const bytes = Uint8Array.from(atob(base64), (character) => character.charCodeAt(0));
    const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
    return new Response(stream).arrayBuffer();
  }

  async function main() {
    facts.phases.forEach(add_symbol);
    pace.innerHTML = PACES.map((times) => `<option value="${times}"${times === 10 ? " selected" : ""}>${times}×</option>`).join("");
    floor.follow_theme();
    play(is_playing);
    lay_out_settings();
    const module = await WebAssembly.compile(await unpacked(element("wasm").textContent));
    simulator = (await WebAssembly.instantiate(module, {})).exports;
    floor.resize();
    open_address();
    window.loaded_ms = performance.now();

    const url = URL.createObjectURL(new Blob([element("calls").textContent, element("worker").textContent], { type: "text/javascript" }));
    judge.thread = new Thread(url, module);
    judge.open();
    const n_threads = Math.max(1, Math.min(8, (navigator.hardwareConcurrency || 2) - 1));
    plane.threads = Array.from({ length: n_threads }, () => new Thread(url, module));

    element("play").addEventListener("click", () => play(!is_playing));
    element("again").addEventListener("click", restart_anew);
    element("other").addEventListener("click", other_start);
    element("fill").addEventListener("click", () => (plane.is_filling ? plane.halt() : plane.fill()));
    for (const side of ["across", "up"]) {
      element(side).addEventListener("change", ({ target }) => {
        state[side] = target.value;
        update();
      });
    }
    element("copy-link").hidden = location.protocol === "blob:";
    element("copy-link").addEventListener("click", () => copy(location.href.split("#")[0] + address(), "The link"));
    element("copy-sweep").addEventListener("click", () => {
      try {
        copy(sweep_file(), "The sweep file");
      } catch (error) {
        element("copied").textContent = capitalised(error.message);
      }
    });
    // Those of the link, or of the report, that led here.
    const first_address = location.hash;
    element("relink").hidden = first_address.length < 2;
    element("relink").addEventListener("click", () => go(() => open_address(first_address)));
    element("reset").addEventListener("click", () => go(() => open_address("#")));
    element("sweep").closest("details").addEventListener("toggle", show_sweep);
    addEventListener("hashchange", () => open_address());
    addEventListener("keydown", on_key);
    dark.addEventListener("change", () => {
      floor.follow_theme();
      floor.draw(rows(), false);
    });
    new ResizeObserver(() => {
      floor.resize();
      if (swarm) floor.draw(rows(), false);
    }).observe(floor.canvas);
    requestAnimationFrame(frame);
  }

  // What tests ask.
  window.simulated = {
    state: (cell, replicate, n_steps) => {
      put(scene({ cell }));
      got(simulator.open(BigInt(replicate)));
      simulator.step(n_steps);
      const digest = BigInt.asUintN(64, simulator.digest()).toString(16).padStart(16, "0");
      restart();
      return digest;
    },
    sweep_file: () => sweep_file(),
    phase_at_end: () => at_end,
    phase_in_sweep: () => {
      put(scene());
      const replicate = BigInt(state.replicate);
      const counts = JSON.parse(got(simulator.count(replicate, replicate + 1n)));
      return Object.keys(counts).filter((phase) => counts[phase] > 0);
    },
    counts: () => plane.counts,
    n_steps: () => simulator.n_steps(),
    digest: () => BigInt.asUintN(64, simulator.digest()).toString(16).padStart(16, "0"),
    describe: () => swarm,
    is_full: () => plane.took_s !== null && plane.took_s !== undefined,
    took_s: () => plane.took_s,
  };

  main().catch(refuse);
})();
