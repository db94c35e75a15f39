/* Axes of charts: ranges, ticks, and numbers as text. */

const SUPER = {"-": "⁻", 0: "⁰", 1: "¹", 2: "²", 3: "³", 4: "⁴", 5: "⁵", 6: "⁶", 7: "⁷", 8: "⁸", 9: "⁹"};
const power = (exponent) => `10${[...String(exponent)].map((c) => SUPER[c]).join("")}`;

/** A number with four digits; very large and small ones, or all beside such ones, as powers of ten. */
function shortNumber(value, beside = value) {
  if (!Number.isFinite(value) || value === 0) return value === 0 ? "0" : "–";
  const exponent = Math.floor(Math.log10(Math.abs(beside)) + 1e-12);
  if (exponent < -4 || exponent > 5) {
    const head = Number((value / 10 ** exponent).toPrecision(3));
    return `${head}×${power(exponent)}`.replace(/^(-?)1×/, "$1").replace(/^-/, "−");
  }
  return String(Number(value.toPrecision(4))).replace("-", "−");
}

/** Ticks of a linear axis at round numbers: values and texts. */
function linearTicks([low, high], count) {
  const rough = (high - low) / Math.max(count, 1), unit = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((f) => f * unit).find((s) => s >= rough * 0.75);
  const values = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k++) values.push(k * step);
  const largest = Math.max(...values.map(Math.abs));
  return values.map((value) => ({value, text: shortNumber(Math.abs(value) < 1e-9 * step ? 0 : value, largest)}));
}

/** Ticks of a logarithmic axis, whose range counts in powers of ten. */
function powerTicks([low, high], count) {
  const step = Math.max(1, Math.ceil((high - low) / Math.max(count, 1))), values = [];
  for (let e = Math.ceil(low - 1e-9); e <= high + 1e-9; e++) {
    if (((e % step) + step) % step === 0) values.push({value: e, text: power(e)});
  }
  return values;
}

/** One axis: from values of the data to the drawing. */
class Axis {
  constructor(options, values) {
    this.options = options;
    this.log = options.type === "log";
    this.range = [...(options.range || this.around(values))];
    if (!(this.range[1] > this.range[0])) this.range = [this.range[0] - 1, this.range[0] + 1];
  }
  around(values) {
    const found = values.map((v) => this.log ? Math.log10(v) : v).filter(Number.isFinite);
    let low = found.reduce((a, b) => Math.min(a, b), Infinity);
    let high = found.reduce((a, b) => Math.max(a, b), -Infinity);
    if (!(low <= high)) return [0, 1];
    if (this.options.rangemode === "tozero") [low, high] = [Math.min(low, 0), Math.max(high, 0)];
    const margin = this.options.tight ? 0 : 0.05 * (high - low || Math.abs(high) || 1);
    return [low < 0 || low > 0 ? low - margin : low, high + margin];
  }
  /** Lay the range over pixels from `from` to `to`. */
  over(from, to) { [this.from, this.to] = [from, to]; return this; }
  at(value) {
    const v = this.log ? Math.log10(value) : value;
    return this.from + (this.to - this.from) * (v - this.range[0]) / (this.range[1] - this.range[0]);
  }
  /** Value at a pixel. */
  value(pixel) {
    const v = this.range[0] + (pixel - this.from) / (this.to - this.from) * (this.range[1] - this.range[0]);
    return this.log ? 10 ** v : v;
  }
  ticks(apart) {
    const count = Math.abs(this.to - this.from) / apart;
    return this.log ? powerTicks(this.range, count).map((t) => ({...t, value: 10 ** t.value}))
      : linearTicks(this.range, count);
  }
  get perPixel() { return (this.range[1] - this.range[0]) / Math.abs(this.to - this.from); }
  /** Widen the range around its middle until a pixel is worth this much. */
  widen(perPixel) {
    const middle = (this.range[0] + this.range[1]) / 2, half = perPixel * Math.abs(this.to - this.from) / 2;
    this.range = [middle - half, middle + half];
  }
}
