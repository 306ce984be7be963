// NiceGUI's side of the window: a component whose inside is ours.

export default {
  template: '<div class="amorsim"></div>',
  props: { entry: String },
  async mounted() {
    const { start } = await import(this.entry);
    start(this.$el);
  },
};
