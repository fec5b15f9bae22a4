// A slider of Quasar whose role, name and value stand on the element that takes the focus, so that a screen reader
// announces them; Quasar writes them on the element around it. Position and text change together, when the server has
// answered. The thumb follows the visitor at once, and the server only where it places the slider itself: answers to
// earlier moves would set a held key back.
export default {
  template: `
    <q-slider
      ref="qRef"
      :model-value="position"
      :min="min"
      :max="max"
      role="none"
      :aria-valuemin="null"
      :aria-valuemax="null"
      :aria-valuenow="null"
      :aria-orientation="null"
      @update:model-value="move"
      @keydown="toAnEnd"
    />
  `,
  props: { modelValue: Number, min: Number, max: Number, ariaLabel: String, text: String, placed: Number },
  emits: ["update:model-value"],
  data() {
    return { position: this.modelValue };
  },
  watch: {
    placed() {
      this.position = this.modelValue;
    },
  },
  mounted() {
    this.describe();
  },
  updated() {
    this.describe();
  },
  methods: {
    describe() {
      const stated = {
        role: "slider",
        "aria-label": this.ariaLabel,
        "aria-valuemin": this.min,
        "aria-valuemax": this.max,
        "aria-valuetext": this.text,
        "aria-valuenow": this.modelValue,
      };
      const focused = this.$el.querySelector("[tabindex]");
      for (const [name, value] of Object.entries(stated)) {
        if (focused.getAttribute(name) !== String(value)) focused.setAttribute(name, value);
      }
    },
    move(position) {
      this.position = position;
      this.$emit("update:model-value", position);
    },
    toAnEnd(event) {
      const ends = { Home: this.min, End: this.max };
      if (!(event.key in ends)) return;
      event.preventDefault();
      this.move(ends[event.key]);
    },
  },
};
