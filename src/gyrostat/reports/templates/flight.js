"use strict";
// Flies runs of a scenario by its compiled program. It needs no page: a worker of the page runs it.
// The memory of the program has words of 64 bits, (words, lanes), for one group of runs at a time.
class Flight {
  // instance: of the module; about: places in its memory; shared: words that all runs share
  constructor(instance, about, shared) {
    const { exports } = instance, { words } = about, L = 2;
    Object.assign(this, { exports, about, lanes: L });
    let free = (exports.__heap_base.value + 15) & ~15;
    const sizes = {
      shared: 1 + words.shared, own: L * (about.carry + words.own), made: L * words.made, every: L * words.every,
      asked: L * words.asked, place: 1, end: L * (about.seen[1] + about.counted.length * about.percentiles.length),
      results: L * words.results, values: L * about.keys.length, possible: L * about.relations.length,
    };
    this.at = {};
    for (const name in sizes) { this.at[name] = free; free += 8 * Math.ceil(sizes[name] / 2) * 2; }
    const lacking = free - exports.memory.buffer.byteLength;
    if (lacking > 0) exports.memory.grow(Math.ceil(lacking / 65536));
    const memory = exports.memory.buffer;
    this.word = {}; this.real = {};
    for (const name in sizes) {
      this.word[name] = new BigInt64Array(memory, this.at[name], sizes[name]);
      this.real[name] = new Float64Array(memory, this.at[name], sizes[name]);
    }
    this.word.shared.set(shared, 1);
    this.percents = about.percentiles.map(fraction);
  }
  call(name, shared, own, made) {
    const { at } = this;
    this.exports[name](1n, 1n, shared, own, made, at.every, at.asked, at.place);
  }
  // first relation that each run does not fulfil, -1: none; concerned: whether each is asked for. The values of a run
  // begin with the dispersed ones
  refused(runs, nominal, concerned) {
    const { about, at, real, lanes: L } = this, found = [];
    for (let k = 0; k < runs.length; k += L) {
      const some = runs.slice(k, k + L), values = some.map(run => {
        const all = Float64Array.from(nominal), own = new Float64Array(run.buffer, run.byteOffset, about.dispersed.length);
        about.dispersed.forEach((key, j) => { all[key] = own[j]; });
        return all;
      });
      about.keys.forEach((_, key) => { for (let lane = 0; lane < L; ++lane) real.values[key * L + lane] = values[Math.min(lane, some.length - 1)][key]; });
      this.call("possible", at.shared, at.values, at.possible);
      some.forEach((_, lane) => found.push(concerned.findIndex((asked, row) => asked && real.possible[row * L + lane] !== 1)));
    }
    return found;
  }
  // runs: at most as many as lanes, each the words of a run; nominal: values that replace those of the scenario;
  // wanted: signals that are returned of each run, name -> values, one sample after the other
  fly(runs, nominal, wanted) {
    const { about, at, word, real, lanes: L } = this, { carry, length, samples } = about, from = carry * L;
    if (nominal) real.shared.set(nominal, 1);
    runs[0].forEach((_, k) => { for (let lane = 0; lane < L; ++lane) word.own[from + k * L + lane] = runs[Math.min(lane, runs.length - 1)][k]; });
    word.place[0] = wanted.length ? 0n : -1n;
    this.call("begin", at.shared + 8, at.own + 8 * from, at.made);
    const errors = about.counted.map(() => runs.map(() => new Float64Array(samples))), counts = errors.map(each => each.map(() => 0));
    const signals = runs.map(() => Object.fromEntries(wanted.map(name => [name, new Float64Array(samples * about.signals[name][2])])));
    for (const first of about.starts) {
      word.own.set(word.made.subarray(0, from));
      word.shared[0] = BigInt(first);
      this.call("chunk", at.shared, at.own, at.made);
      const rows = Math.min(length, samples - first);
      about.counted.forEach(([memory, start], signal) => runs.forEach((_, lane) => {
        const values = errors[signal][lane];
        let count = counts[signal][lane];
        for (let k = 0; k < rows; ++k) { const e = real[memory][(start + k) * L + lane]; if (e < Infinity) values[count++] = e; }
        counts[signal][lane] = count;
      }));
      for (const name of wanted) {
        const [memory, start, size, whole] = about.signals[name];
        runs.forEach((_, lane) => {
          const values = signals[lane][name];
          for (let k = 0; k < rows * size; ++k) { const at = (start + k) * L + lane; values[first * size + k] = whole ? Number(word[memory][at]) : real[memory][at]; }
        });
      }
    }
    const [seen, size] = about.seen;
    word.end.set(word.made.subarray(seen * L, (seen + size) * L));
    errors.forEach((each, signal) => each.forEach((values, lane) => {
      const sorted = values.subarray(0, counts[signal][lane]).sort();
      this.percents.forEach(([numerator, denominator], k) => {
        const rank = Math.max(1, Math.ceil(numerator * sorted.length / denominator));
        for (let to = lane; to < (lane === runs.length - 1 ? L : lane + 1); ++to)
          real.end[(size + signal * this.percents.length + k) * L + to] = sorted.length ? sorted[rank - 1] : NaN;
      });
    }));
    this.call("conclude", at.shared, at.end, at.results);
    return runs.map((_, lane) => ({
      results: Float64Array.from({ length: about.words.results }, (_, k) => real.results[k * L + lane]), signals: signals[lane],
    }));
  }
}
// percentage as a fraction of whole numbers, so that ranks are exact
function fraction(percent) {
  const decimals = (String(percent).split(".")[1] ?? "").length;
  return [Math.round(percent * 10 ** decimals), 100 * 10 ** decimals];
}
