// Adaptive sampling in rounds: the pixels of a small picture as cells, each with the samples that it has, those that it
// gets next, and the estimate of its standard deviation.
({once, begin}, states, plot, {short, lines}) => {
  const style = `
    .replay .pixel { fill: var(--paper); stroke: var(--line); }
    .replay .pixel.kept { fill: var(--one); fill-opacity: .25; }
    .replay .noise { fill: var(--three); }
    .replay .at { fill: none; stroke: var(--ink); stroke-width: 3; }
    .replay .asked { fill: none; stroke: var(--two); stroke-width: 3; stroke-dasharray: 6 3; }
    .replay .others { opacity: .35; }
    .replay .count { font-weight: 700; }
    .replay text.small { font-size: 9.5px; }`;
  const {width} = once, pixels = begin.counts.length, wide = 440 / width, tall = 39, top = 30, last = states.length - 1, final = states[last];
  const all = [...Array(pixels).keys()], x = (p) => wide * (p % width), y = (p) => top + tall * Math.floor(p / width);
  const sigma = ({own, variance}, p) => Math.sqrt(variance[p] || own[p]), most = Math.max(...all.map((p) => sigma(final, p)));
  const digits = (value) => value ? value.toPrecision(2).replace(/^0(?=\.)/, "") : "0";
  const of = [0, 1].map((colour) => new Set(states.filter((state) => state.colour === colour && state.n != null).map(({i}) => i))); // of the chessboard, as they are planned
  const name = (k) => lines[k] ? lines[k].name : "", noted = states.findIndex(({own}) => own.some((value) => value > 0));
  const title = (k) => ({keep_samples: "Round 1 decides: which pixels keep their samples?", start_generation: "The others throw theirs away, and take new ones.",
    rk_adaptive_plan_generation: states[k].has.every((n) => n > 0) && states[k].lambda == null && states[k].counts.some((n, p) => n !== begin.counts[p]) ? "Round 2 is rendered."
      : "Round 1 decides: how noisy is each pixel?",
    plan_colour: k === last ? "Round 3 will take these samples." : `Round 2 decides how many samples the pixels of colour ${states[k].colour ?? 0} take.`,
    rk_adaptive_plan_second_round: "Round 2 decides about round 3."})[name(k)] || `Round 1 has taken ${begin.has[0]} samples in each pixel.`;
  function draw(k) {
    const {i, kept, has, counts, colour} = states[k], asked = questions.get(k) && questions.get(k).pixels || [];
    const dim = (p) => name(k) === "plan_colour" && colour != null && !of[colour].has(p) ? "others" : "";
    const frame = (p, kind) => plot.node("rect", {class: kind, x: x(p) + 2, y: y(p) + 2, width: wide - 4, height: tall - 4});
    return [plot.text(2, 16, title(k), "start", {class: "strong"}),
      ...all.map((p) => plot.node("g", {class: dim(p)}, plot.node("rect", {class: `pixel ${kept[p] ? "kept" : ""}`, x: x(p), y: y(p), width: wide, height: tall}),
        ...(kept[p] ? [] : [plot.node("rect", {class: "noise", x: x(p) + 1, y: y(p) + 1, width: wide - 2, height: tall - 2, opacity: .6 * sigma(states[k], p) / most})]),
        plot.text(x(p) + wide / 2, y(p) + 16, has[p] === counts[p] ? has[p] : `${has[p]} → ${counts[p]}`, "middle", {class: "count"}),
        plot.text(x(p) + wide / 2, y(p) + 31, kept[p] ? "kept" : k >= noted && noted > 0 ? `σ ${digits(sigma(states[k], p))}` : "", "middle", {class: "small"}))),
      ...(i == null ? [] : [frame(i, "at")]), ...asked.map((p) => frame(p, "asked"))];
  }

  // Does a pixel keep samples that agree; what is the number of samples proportional to; who goes on.
  const questions = new Map(), first = (wanted) => states.findIndex((state, k) => name(k) === wanted);
  const keeps = first("keep_samples"), starts = first("start_generation"), second = first("plan_colour");
  const reached = (from, wanted, p) => states.findIndex((state, k) => k > from && (name(k) !== wanted || state.i > p));
  const agrees = all.find((p) => final.own[p] === 0 && !final.kept[p]);
  if (keeps > 0 && agrees !== undefined) questions.set(keeps, {text: "The eight samples of the outlined pixel all agree. Does it keep them?", choices: ["yes", "no"],
    right: 1, until: reached(keeps, "keep_samples", agrees), pixels: [agrees]});
  if (starts > 0 && second > 0) {
    const {variance, kept} = states[starts], {counts} = states[second], taken = all.filter((p) => !kept[p] && counts[p] > Math.min(...counts));
    const apart = ([a, b]) => Math.abs(Math.log(variance[a] / variance[b] / 16));
    const [a, b] = taken.flatMap((p) => taken.map((q) => [p, q])).filter(([p, q]) => variance[p] > variance[q]).sort((p, q) => apart(p) - apart(q))[0] || [];
    const times = [1, 2, 4, 16], right = a === undefined ? -1 : times.indexOf(counts[a] / counts[b]);
    if (right >= 0) questions.set(starts, {text: `Of the two outlined pixels, one has the standard deviation ${short(Math.sqrt(variance[a]))}, the other ${short(Math.sqrt(variance[b]))}. How many times as many new samples does the first one get?`,
      choices: ["as many", "twice", "4 times", "16 times"], right, until: reached(starts, "start_generation", Math.max(a, b)), pixels: [a, b]});
    const more = all.filter((p) => final.counts[p] > counts[p]), of_kept = more.filter((p) => final.kept[p]).length;
    if (more.length) questions.set(second, {text: "Round 2 has measured the error, which is still too large. Which pixels take more samples?",
      choices: ["pixels of both kinds", "only pixels with new samples", "only pixels that kept theirs"], right: of_kept === 0 ? 1 : of_kept === more.length ? 2 : 0, until: last});
  }
  return {style, height: top + tall * Math.ceil(pixels / width) + 4, label: "the pixels, with their samples", draw, questions, names: ["i", "around", "lambda", "colour", "n"],
    strides: {line: () => true, pixel: (k) => states[k].i !== states[k - 1].i, function: (k) => name(k) !== name(k - 1)}};
}
