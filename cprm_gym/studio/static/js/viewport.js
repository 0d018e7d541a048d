// What is seen of a net: pan and zoom, all of it or as large as can be read, bars that say where one is, and parts far away left out.

const CULLED = 250; // places and transitions beyond which what is far away is not drawn
const READABLE = 0.75; // scale below which names are small
const LARGEST = 1.4;
const EDGE = 15;

/** The base of `NetCanvas`, which gives `element`, `world`, `scaled`, `plan`, `nodes`, `boxes` and `links`. */
export class Viewport {
  constructor() {
    this.view = { x: 0, y: 0, k: 1 };
    this.onlook = null; // told of a view that was chosen here
    this.bars = ["across", "down"].map((way) => {
      const bar = document.createElement("div");
      bar.className = `scroll ${way}`;
      bar.hidden = true;
      bar.append(document.createElement("div"));
      bar.addEventListener("pointerdown", (event) => this.drawBar(event, way));
      return bar;
    });
  }

  /** Fit again what waits for a size when there is one. */
  watch(container) {
    this.resizing = new ResizeObserver(() => {
      this.size = this.element.getBoundingClientRect();
      if (this.waitingToFit) this.read();
      else this.settle();
    });
    this.resizing.observe(container);
  }

  /** Another plan is drawn. */
  shown(keep) {
    this.kept = this.reach = null;
    if (!keep) this.read();
    else this.settle(true);
  }

  settle(anew = false) {
    if (this.plan?.nodes.length > CULLED) this.cull(anew);
    this.placeBars();
  }

  room() {
    const { width, height } = this.element.getBoundingClientRect();
    this.waitingToFit = !width || !this.plan;
    return this.waitingToFit ? null : [width, height];
  }

  /** The scale at which all is seen, and the one at which its width is. */
  scales([width, height]) {
    const [left, top, right, bottom] = this.extent();
    const across = Math.min(LARGEST, (width - 2 * EDGE) / Math.max(1, right - left));
    return [Math.min(across, (height - 2 * EDGE) / Math.max(1, bottom - top)), across];
  }

  /** All of it. */
  fit() {
    const room = this.room();
    if (room) this.look(this.placed(room, this.scales(room)[0]));
  }

  /** All of it if names can be read then; else as wide as the view, or as small as can be read: from the top, where the marking is. */
  read() {
    const room = this.room();
    if (!room) return;
    const [all, across] = this.scales(room);
    this.look(this.placed(room, all >= READABLE ? all : Math.max(READABLE, Math.min(across, 1))));
  }

  /** All of it, or, when all of it is seen, what can be read. */
  fitOrRead() {
    const room = this.room();
    if (!room) return;
    if (Math.abs(this.view.k - this.scales(room)[0]) < 1e-6) this.read();
    else this.fit();
  }

  placed([width, height], k) {
    const [left, top, right, bottom] = this.extent();
    const [x, y] = this.start();
    const along = (room, low, high, start) => ((high - low) * k + 2 * EDGE <= room ? (room - (high - low) * k) / 2 - low * k : Math.min(EDGE - low * k, Math.max(room - EDGE - high * k, room / 2 - start * k)));
    return { k, x: along(width, left, right, x ?? (left + right) / 2), y: along(height, top, bottom, y ?? top) };
  }

  /** Where one begins to read: at the uppermost place that is marked. */
  start() {
    const marked = [...this.nodes].filter(([key, { node }]) => node.kind === "place" && (this.state.marking[key] ?? node.tokens) > 0).map(([, { node }]) => [node.x, node.y]);
    return marked.sort((a, b) => a[1] - b[1])[0] ?? [];
  }

  extent() {
    if (this.reach) return this.reach;
    let [left, top, right, bottom] = [0, 0, 1, 1];
    const known = [...[...this.nodes.values()].map(({ node }) => [node.x - 22, node.y - 22, node.x + 30 + 6.3 * node.label.length, node.y + 22]),
      ...[...this.boxes.values()].map(({ box }) => [box.x, box.y, box.x + box.width, box.y + box.height]),
      ...[...this.links.values()].map(({ extent: [a, b, c, d] }) => [a + 28, b + 28, c - 28, d - 28])];
    known.forEach(([a, b, c, d], i) => {
      [left, top, right, bottom] = i ? [Math.min(left, a), Math.min(top, b), Math.max(right, c), Math.max(bottom, d)] : [a, b, c, d];
    });
    this.reach = [left, top, right, bottom];
    return this.reach;
  }

  /** Zoom by a factor around a point of the element; the middle without one. */
  zoom(factor, at) {
    const { width, height } = this.element.getBoundingClientRect();
    const [px, py] = at ?? [width / 2, height / 2];
    const k = Math.max(0.03, Math.min(4, this.view.k * factor));
    const real = k / this.view.k;
    this.look({ k, x: px - (px - this.view.x) * real, y: py - (py - this.view.y) * real });
  }

  pan(dx, dy) {
    this.look({ ...this.view, x: this.view.x + dx, y: this.view.y + dy });
  }

  /** Up or down by most of what is seen. */
  page(way) {
    this.pan(0, -way * 0.8 * this.element.getBoundingClientRect().height);
  }

  /** Bring a node or module to the middle, near enough to be read. */
  centre(key) {
    const box = this.boxes.get(key)?.box;
    const node = this.nodes.get(key)?.node ?? (box && { x: box.x + box.width / 2, y: box.y + box.height / 2 });
    const { width, height } = this.element.getBoundingClientRect();
    if (!node || !width) return;
    const k = Math.max(this.view.k, READABLE);
    this.look({ k, x: width / 2 - node.x * k, y: height / 2 - node.y * k });
  }

  /** Bring a module that was unfolded into view, readable: all of it, or from its upper left corner. */
  reveal(key) {
    const box = this.boxes.get(key)?.box;
    const room = this.room();
    if (!box || !room) return;
    const [width, height] = room;
    const k = Math.min(Math.max(this.view.k, READABLE), Math.max(READABLE, Math.min((width - 2 * EDGE) / box.width, (height - 2 * EDGE) / box.height)));
    const along = (space, low, size) => (size * k + 2 * EDGE <= space ? (space - size * k) / 2 - low * k : EDGE - low * k);
    this.look({ k, x: along(width, box.x, box.width), y: along(height, box.y, box.height) });
  }

  look(view) {
    this.lookAt(view);
    this.onlook?.(view);
  }

  /** Show what another view shows. */
  lookAt(view) {
    if (view.k !== this.drawnAt) {
      for (const group of this.scaled) group.setAttribute("transform", `scale(${view.k})`);
      this.element.classList.toggle("far", view.k < 0.4);
      this.element.classList.toggle("tiny", view.k < 0.2);
      this.drawnAt = view.k;
    }
    this.view = view;
    this.world.style.transform = `translate3d(${Math.round(view.x)}px, ${Math.round(view.y)}px, 0)`;
    this.settle();
  }

  /** Large nets: leave out what lies far outside what is seen. */
  cull(anew = false) {
    const { width, height } = this.size ?? this.element.getBoundingClientRect();
    const { x, y, k } = this.view;
    const [left, top, right, bottom] = [-x / k, -y / k, (width - x) / k, (height - y) / k];
    const seen = this.kept;
    if (!anew && seen && seen.k === k && left >= seen.left && top >= seen.top && right <= seen.right && bottom <= seen.bottom) return;
    const [dx, dy] = [(right - left) * 0.35, (bottom - top) * 0.35];
    this.kept = { k, left: left - dx, top: top - dy, right: right + dx, bottom: bottom + dy };
    const { kept } = this;
    const show = (part, within) => {
      if (part.away === !within) return;
      part.away = !within;
      part.group.style.display = within ? "" : "none";
    };
    for (const part of this.nodes.values()) {
      const { node } = part;
      show(part, node.x > kept.left - 260 && node.x < kept.right + 30 && node.y > kept.top - 30 && node.y < kept.bottom + 30);
    }
    for (const part of this.links.values()) {
      const [a, b, c, d] = part.extent;
      show(part, c > kept.left && a < kept.right && d > kept.top && b < kept.bottom);
    }
  }

  /** The point of the net under a pointer event. */
  at(event) {
    const { left, top } = this.element.getBoundingClientRect();
    return [(event.clientX - left - this.view.x) / this.view.k, (event.clientY - top - this.view.y) / this.view.k];
  }

  // -- bars -----------------------------------------------------------------------------------------------------------------------

  /** Along each way: pixels of the view, of the net, and where the view begins in it; the net with its edge. */
  spans() {
    const { width, height } = this.size ?? this.element.getBoundingClientRect();
    const [left, top, right, bottom] = this.extent();
    const { x, y, k } = this.view;
    return { across: [width, (right - left) * k + 2 * EDGE, -x - left * k + EDGE], down: [height, (bottom - top) * k + 2 * EDGE, -y - top * k + EDGE] };
  }

  placeBars() {
    if (!this.plan || !this.nodes.size) return;
    const spans = this.spans();
    for (const bar of this.bars) {
      const way = bar.classList.contains("down") ? "down" : "across";
      const [seen, all, from] = spans[way];
      bar.hidden = all <= seen + 2;
      if (bar.hidden) continue;
      const share = Math.max(0.08, seen / all);
      const at = Math.max(0, Math.min(1, from / (all - seen))) * (1 - share);
      const [place, size] = way === "down" ? ["top", "height"] : ["left", "width"];
      Object.assign(bar.firstChild.style, { [place]: `${100 * at}%`, [size]: `${100 * share}%` });
    }
  }

  /** Move along a bar: by its grip, or to where it was pressed. */
  drawBar(event, way) {
    event.preventDefault();
    event.stopPropagation();
    const bar = event.currentTarget;
    const down = way === "down";
    const along = (e) => (down ? e.clientY : e.clientX);
    const box = bar.getBoundingClientRect();
    const grip = bar.firstChild.getBoundingClientRect();
    const [start, length] = down ? [box.top, box.height] : [box.left, box.width];
    const [gripAt, gripLong] = down ? [grip.top, grip.height] : [grip.left, grip.width];
    const held = event.target === bar.firstChild ? along(event) - gripAt : gripLong / 2;
    const move = (e) => {
      const [seen, all, from] = this.spans()[way];
      const share = Math.max(0, Math.min(1, (along(e) - held - start) / Math.max(1, length - gripLong)));
      const by = from - share * (all - seen);
      this.pan(down ? 0 : by, down ? by : 0);
    };
    const end = () => {
      window.removeEventListener("pointermove", move);
      window.removeEventListener("pointerup", end);
      window.removeEventListener("pointercancel", end);
    };
    move(event);
    window.addEventListener("pointermove", move);
    window.addEventListener("pointerup", end);
    window.addEventListener("pointercancel", end);
  }
}
