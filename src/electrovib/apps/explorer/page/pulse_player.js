// One pulse, moment by moment: the layers with free charges and lines of the electric displacement, and the curves of
// force and voltage. Everything that is drawn comes from the server at once; a moment is a place in its arrays.
const SLOTS = 12; // places of signs and lines side by side
const STEP = 16; // between two of them
const WIDTH = SLOTS * STEP;
const PLATE = 30;
const FINGER = 74;
const UNIT = 48; // height of the thinnest layer
const PLOT = { left: 46, right: 350, top: 26, low: 226 };
const SECONDS = 18; // of a whole animation
const CALM = 0.5; // seconds between two pictures for a visitor who wants less motion
const NOTHING = 1e-3; // part of the largest value below which 0 is written
const PREFIXES = { "-12": "p", "-9": "n", "-6": "µ", "-3": "m", 0: "", 3: "k", 6: "M", 9: "G" };

function quantity(value, unit, digits = 3) {
  if (value === 0) return `0 ${unit}`;
  const rounded = Number(value.toPrecision(digits));
  const power = Math.max(-12, Math.min(9, 3 * Math.floor(Math.log10(Math.abs(rounded)) / 3 + 1e-9)));
  const number = Number((rounded / 10 ** power).toPrecision(digits));
  return `${String(number).replace("-", "−")} ${PREFIXES[power]}${unit}`;
}

export default {
  template: `
    <div class="ev-pulse" v-if="count">
      <p class="ev-pulse-answer">{{ pulse.answer }}</p>
      <div class="ev-pulse-controls">
        <button type="button" @click="toggle">{{ isPlaying ? "Pause" : "Play" }}</button>
        <input type="range" min="0" :max="count - 1" step="1" :value="at" aria-label="Time" :aria-valuetext="time"
          @input="scrub(Number($event.target.value))" />
        <span class="ev-pulse-time">{{ time }}</span>
      </div>
      <p class="ev-pulse-said" aria-live="polite">{{ said }}</p>
      <div class="ev-pulse-pictures">
        <svg role="img" aria-label="Layers from the plate to the finger with the charges on their faces"
          :viewBox="'0 0 360 ' + height" fill="currentColor">
          <rect x="4" y="2" :width="width + 8" :height="finger - 2" rx="10" class="ev-pulse-finger" />
          <text x="14" y="20" class="ev-pulse-dark">finger</text>
          <g v-if="pull > 1" class="ev-pulse-pull">
            <path :d="'M' + (width - 16) + ' 10v' + pull + 'm-7 -8l7 9l7 -9'" />
          </g>
          <text :x="textAt" y="20" class="ev-pulse-name">force {{ force }}</text>
          <rect x="4" :y="bottom" :width="width + 8" :height="plate" rx="2" class="ev-pulse-plate" />
          <text x="14" :y="bottom + 24" class="ev-pulse-light">plate</text>
          <g v-for="layer in layers">
            <rect x="4" :y="layer.top" :width="width + 8" :height="layer.height" :fill="layer.colour" fill-opacity="0.5" />
            <text :x="textAt" :y="layer.middle - 2" class="ev-pulse-name">{{ layer.name }}</text>
            <text :x="textAt" :y="layer.middle + 13">{{ layer.voltage }}</text>
          </g>
          <path v-for="line in lines" :d="line.path" :opacity="line.opacity" class="ev-pulse-line" />
          <g v-for="row in rows">
            <line x1="4" :x2="width + 12" :y1="row.y" :y2="row.y" class="ev-pulse-face" />
            <g v-for="sign in row.signs" :opacity="sign.opacity">
              <circle :cx="sign.x" :cy="row.y" r="7" :class="sign.kind" />
              <path :d="sign.path" class="ev-pulse-sign" />
            </g>
            <text :x="textAt" :y="row.y + 4" :class="row.kind">{{ row.charge }}</text>
          </g>
        </svg>
        <svg role="img" aria-label="Force and voltage over time" viewBox="0 0 400 272" fill="currentColor">
          <g v-for="axis in axes">
            <text :x="axis.edge" y="14" :text-anchor="axis.outer" :class="'ev-pulse-' + axis.name">{{ axis.words }}</text>
            <text v-for="tick in axis.ticks" :x="axis.x" :y="tick.y + 4" :text-anchor="axis.anchor"
              :class="'ev-pulse-' + axis.name">{{ tick.text }}</text>
            <path :d="axis.path" :class="'ev-pulse-curve ev-pulse-' + axis.name" />
            <circle :cx="x(at)" :cy="axis.y" r="5" :class="'ev-pulse-' + axis.name" />
          </g>
          <line v-for="tick in axes[0].ticks" :x1="plot.left" :x2="plot.right" :y1="tick.y" :y2="tick.y" class="ev-pulse-grid" />
          <text v-for="tick in timeTicks" :x="tick.x" :y="plot.low + 18" text-anchor="middle">{{ tick.text }}</text>
          <text :x="(plot.left + plot.right) / 2" :y="plot.low + 38" text-anchor="middle">{{ pulse.axes.time.words }}</text>
          <line :x1="x(at)" :x2="x(at)" :y1="plot.top" :y2="plot.low" class="ev-pulse-now" />
        </svg>
      </div>
      <p class="ev-pulse-caption">{{ pulse.caption }}</p>
    </div>
  `,
  props: { pulse: Object },
  data() {
    return { at: 0, isPlaying: false, width: WIDTH, plate: PLATE, finger: FINGER, textAt: WIDTH + 20, plot: PLOT };
  },
  computed: {
    count() {
      return this.pulse.time?.length ?? 0;
    },
    time() {
      return quantity(this.pulse.time[this.at], "s");
    },
    force() {
      return this.value("force", "N");
    },
    said() {
      const begun = this.pulse.starts.filter((start) => start <= this.at).length;
      return this.pulse.said[Math.max(begun - 1, 0)] ?? "";
    },
    pull() {
      const peak = Math.max(...this.pulse.force.map(Math.abs));
      return peak > 0 ? (46 * this.pulse.force[this.at]) / peak : 0;
    },
    placed() {
      let top = FINGER;
      const placed = this.pulse.layers.slice().reverse().map(({ name, height, colour }) => {
        const layer = { name, colour, top, height: UNIT * height, middle: top + (UNIT * height) / 2 };
        top += layer.height;
        return layer;
      });
      return placed.reverse();
    },
    bottom() {
      return this.placed[0].top + this.placed[0].height;
    },
    height() {
      return this.bottom + PLATE + 2;
    },
    layers() {
      return this.placed.map((layer, k) => {
        const across = this.pulse.voltages[k];
        const largest = Math.max(...across.map(Math.abs));
        return { ...layer, voltage: this.shown(across[this.at], largest, "V") };
      });
    },
    shares() {
      // of each slot, from -1 to 1: lines that go up fill them from the left, those that go down from the right
      return this.pulse.lines.map((row) => {
        const lines = row[this.at];
        return Array.from({ length: SLOTS }, (_, slot) => {
          const place = lines > 0 ? slot : SLOTS - 1 - slot;
          return Math.sign(lines) * Math.min(Math.max(Math.abs(lines) - place, 0), 1);
        });
      });
    },
    lines() {
      const lines = [];
      this.shares.forEach((shares, k) => {
        const { top, height, middle } = this.placed[k];
        shares.forEach((share, slot) => {
          if (!share) return;
          const x = this.slot(slot);
          const tip = share > 0 ? "m-3 5l3 -5l3 5" : "m-3 -5l3 5l3 -5";
          lines.push({ path: `M${x} ${top}v${height}M${x} ${middle}${tip}`, opacity: Math.abs(share) });
        });
      });
      return lines;
    },
    rows() {
      const largest = Math.max(...this.pulse.charges.flat().map(Math.abs));
      return this.pulse.charges.map((row, b) => {
        const y = b < this.placed.length ? this.placed[b].top + this.placed[b].height : this.placed[b - 1].top;
        const signs = Array.from({ length: SLOTS }, (_, slot) => {
          const charge = (this.shares[b]?.[slot] ?? 0) - (this.shares[b - 1]?.[slot] ?? 0);
          const x = this.slot(slot);
          const path = `M${x - 4} ${y}h8` + (charge > 0 ? `M${x} ${y - 4}v8` : "");
          return { x, path, opacity: Math.min(Math.abs(charge), 1), kind: this.kind(charge) };
        }).filter((sign) => sign.opacity > 0.02);
        const charge = Math.abs(row[this.at]) < NOTHING * largest ? 0 : row[this.at];
        const words = (charge > 0 ? "+" : "") + quantity(charge, "C/m²");
        return { y, signs, charge: words, kind: this.kind(charge) };
      });
    },
    axes() {
      const sides = [
        { name: "force", x: PLOT.left - 6, anchor: "end", edge: 2, outer: "start" },
        { name: "drive", x: PLOT.right + 6, anchor: "start", edge: 398, outer: "end" },
      ];
      return sides.map((side) => {
        const axis = this.pulse.axes[side.name];
        const y = (value) => PLOT.low - ((PLOT.low - PLOT.top) * (value - axis.low)) / (axis.high - axis.low);
        const values = this.pulse[side.name];
        const path = "M" + values.map((value, i) => `${this.x(i).toFixed(1)} ${y(value).toFixed(1)}`).join("L");
        const ticks = axis.ticks.map((tick) => ({ y: y(tick.at), text: tick.text }));
        return { ...side, words: axis.words, path, ticks, y: y(values[this.at]) };
      });
    },
    timeTicks() {
      return this.pulse.axes.time.ticks.map((tick) => ({ x: this.across(tick.at), text: tick.text }));
    },
  },
  watch: {
    pulse(now, before) {
      const last = (pulse) => Math.max((pulse.time?.length ?? 0) - 1, 0);
      const moment = before.time?.[this.at] ?? 0;
      const after = now.time?.findIndex((time) => time >= moment) ?? 0;
      this.at = after < 0 ? last(now) : after;
    },
  },
  beforeUnmount() {
    this.isPlaying = false;
  },
  methods: {
    slot(place) {
      return 8 + STEP * (place + 0.5);
    },
    kind(charge) {
      return charge ? (charge > 0 ? "ev-pulse-plus" : "ev-pulse-minus") : "";
    },
    shown(value, largest, unit) {
      return Math.abs(value) < NOTHING * largest ? `0 ${unit}` : quantity(value, unit);
    },
    value(name, unit) {
      return this.shown(this.pulse[name][this.at], Math.max(...this.pulse[name].map(Math.abs)), unit);
    },
    across(time) {
      const { low, high } = this.pulse.axes.time;
      return PLOT.left + ((PLOT.right - PLOT.left) * (time - low)) / (high - low);
    },
    x(place) {
      return this.across(this.pulse.time[place]);
    },
    scrub(place) {
      this.isPlaying = false;
      this.at = place;
    },
    toggle() {
      this.isPlaying = !this.isPlaying;
      if (!this.isPlaying) return;
      if (this.at >= this.count - 1) this.at = 0;
      this.play();
    },
    play() {
      const calm = window.matchMedia("(prefers-reduced-motion: reduce)").matches ? CALM : 0;
      let place = this.at;
      let before = performance.now();
      const step = (now) => {
        if (!this.isPlaying || this.$el.offsetParent === null) {
          this.isPlaying = false;
          return;
        }
        const passed = (now - before) / 1000;
        if (passed > calm) {
          if (Math.floor(place) !== this.at) place = this.at; // another pulse has come
          place += (passed * this.count) / SECONDS;
          before = now;
          this.at = Math.min(Math.floor(place), this.count - 1);
          this.isPlaying = this.at < this.count - 1;
        }
        requestAnimationFrame(step);
      };
      requestAnimationFrame(step);
    },
  },
};
