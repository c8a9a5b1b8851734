// Live figures that converge while nobody touches them, in test_live.js's browser: each picture is the mean of the
// driver's pictures of as many seeds.
"use strict";

const ARGS = "--scene cornell --lens-samples 4 --aperture 150 --focal-distance 2 --width 48 --height 48";
const OPTIONS = "lens-samples=1..16 aperture=1..300 debug=|blurred";

// Linear light of a value in a picture.
const linear = (value) => value <= 10.31475 ? value / 255 / 12.92 : ((value / 255 + .055) / 1.055) ** 2.4;

module.exports = ({check, native, run, difference, weave}) => {
  const words = (args, seed) => [...args.split(" "), "--seed", String(seed)];

  // The mean of the pictures of so many seeds, as a page adds them up.
  function mean(driver, args, seeds, kept = {}) {
    let result = run([driver, ...words(args, 0)], undefined, kept);
    for (let seed = 1; seed < seeds; seed++) result = run([driver, ...words(args, seed)], undefined, kept, "adds");
    return result;
  }

  function means_have_less_noise() {
    const pictures = [0, 1, 2, 3].map((seed) => native("depth_of_field", words(ARGS, seed)).picture.rgb), four = mean("depth_of_field", ARGS, 4);
    let wrong = 0, most = 0;
    pictures[0].forEach((value, i) => {
      const values = pictures.map((rgb) => rgb[i]), at = 4 * Math.floor(i / 3) + i % 3;
      if (values.some((one) => one === 255)) return; // perhaps brighter than white
      const wanted = values.reduce((sum, one) => sum + linear(one), 0) / 4, off = Math.abs(linear(four.picture.rgba[at]) - wanted);
      const level = linear(four.picture.rgba[at] + 1) - linear(four.picture.rgba[at]); // each value is rounded by half a level
      most = Math.max(most, off / level);
      wrong += off > 1.25 * level ? 1 : 0;
    });
    check(four.mean.pictures === 4 && four.mean.differ && wrong === 0, "the radiance of four seeds is averaged", `${wrong} values differ, by at most ${most} levels`);

    const reference = native("depth_of_field", ARGS.replace("samples 4", "samples 1024").split(" ")).picture.rgb;
    const error = ({rgba}) => Math.sqrt(reference.reduce((sum, value, i) => sum + (linear(value) - linear(rgba[4 * Math.floor(i / 3) + i % 3])) ** 2, 0) / reference.length);
    const errors = [1, 16].map((seeds) => error(mean("depth_of_field", ARGS, seeds).picture));
    check(errors[1] < errors[0] / 3, "sixteen seeds have about a quarter of the error of one", errors.join(", ")); // 1/sqrt(16), and rounding

    const kept = {};
    mean("depth_of_field", ARGS, 2, kept);
    run(["depth_of_field", ...words(ARGS, 0), "--pixel", "20,20"], undefined, kept, "leaves");
    const third = run(["depth_of_field", ...words(ARGS, 2)], undefined, kept, "adds"), wanted = mean("depth_of_field", ARGS, 3);
    check(third.mean.pictures === 3 && Buffer.compare(third.picture.rgba, wanted.picture.rgba) === 0, "a pixel that is explained meanwhile leaves the mean alone");

    const bloom = "--bloom --bloom-threshold 0.6 --bloom-radius 8 --width 48 --height 48 --light-samples ", seeds = [...Array(16).keys()];
    const halos = native("parallelogram_light", `${bloom}1024`.split(" ")).picture.rgb, off = (value, i) => (value(i) - linear(halos[i])) ** 2;
    const each = seeds.map((seed) => native("parallelogram_light", words(`${bloom}1`, seed)).picture.rgb), {rgba} = mean("parallelogram_light", `${bloom}1`, 16).picture;
    const [before, after] = [(i) => linear(rgba[4 * Math.floor(i / 3) + i % 3]), (i) => each.reduce((sum, rgb) => sum + linear(rgb[i]), 0) / 16]
      .map((value) => halos.reduce((sum, _, i) => sum + off(value, i), 0));
    check(before < after / 2, "halos are those of the mean, not the mean of the halos of noise", `squared errors ${before} and ${after}`);

    const still = "--scene teapot --shadows --width 40 --height 40", same = mean("shading", still, 2);
    check(!same.mean.differ && Buffer.compare(same.picture.rgba, run(["shading", ...still.split(" ")]).picture.rgba) === 0, "a picture without noise is told to be the same for each seed");
    check(mean("adaptive_sampling", "--scene cornell-light --error 0.1 --width 20 --height 20", 1).mean === null, "adaptive sampling, which ends by itself, has no mean");
  }

  const live = 'document.querySelector(".live")', told = `${live}.querySelector(".converging span").textContent`;
  const shown = (browser) => browser.value(`getComputedStyle(${live}.querySelector(".converging")).visibility === "visible"`);
  const button = (browser) => browser.value(`${live}.querySelector(".converging button").click()`);
  const pause = (ms) => new Promise((resolve) => setTimeout(resolve, ms));
  const motion = (browser, value) => browser.send("Emulation.setEmulatedMedia", {features: [{name: "prefers-reduced-motion", value}]});
  const count = `Number(${told}.split(" ")[0])`;

  // "" if the canvas has the mean of so many seeds, else how it differs.
  async function differs(browser, args, seeds) {
    const {width, height, bytes} = await browser.value(`(() => {
      const canvas = ${live}.querySelector("canvas"), {width, height} = canvas;
      return {width, height, bytes: Array.from(canvas.getContext("2d").getImageData(0, 0, width, height).data)};
    })()`);
    const {rgba} = mean("depth_of_field", args, seeds).picture;
    return difference({width: 48, height: 48, rgb: rgba.filter((value, i) => i % 4 < 3)}, bytes, width, height);
  }
  const set = (browser, name, value) => browser.value(`(() => {
    const control = ${live}.querySelector("[name=${name}]");
    control.value = ${JSON.stringify(value)};
    control.dispatchEvent(new Event("change"));
  })()`);

  async function page_converges(browser) {
    await browser.open(`file://${weave({driver: "depth_of_field", args: ARGS}, OPTIONS)}`);
    check(await browser.until(`${told} === "4 of 256 lens samples"`), "where motion is to be reduced, a figure waits for its button", await browser.value(told));
    await pause(700);
    check(!await differs(browser, ARGS, 1), "and shows the driver's picture until then", await differs(browser, ARGS, 1));
    await button(browser);
    await browser.until(`${count} > 12`);
    await button(browser);
    await pause(300); // one picture may be on its way
    const stopped = await browser.value(count);
    await pause(500);
    const same = await browser.value(count), stays = await differs(browser, ARGS, stopped / 4);
    check(stopped < 256 && same === stopped && !stays, "it goes on, and stops by the same button at the mean of so many seeds", `${stopped}, ${same}: ${stays}`);

    await motion(browser, "no-preference");
    await set(browser, "aperture", 1000);
    const wide = ARGS.replace("aperture 150", "aperture 300");
    await browser.until(`${live}.dataset.drawn === ${JSON.stringify(wide)} && ${told} === "4 of 256 lens samples"`);
    await pause(700);
    check(!await differs(browser, wide, 1), "a new setting ends it, and it stays stopped", await differs(browser, wide, 1));
    await button(browser);
    check(await browser.until(`${told} === "256 of 256 lens samples, by 64 seeds"`), "it ends at a number of samples that is told", await browser.value(told));
    check(!await differs(browser, wide, 64), "its last picture is the mean of all", await differs(browser, wide, 64));

    await set(browser, "debug", "blurred");
    await browser.until(`${live}.dataset.drawn.includes("blurred")`);
    await pause(1200);
    check(!await shown(browser), "a debug view stays as it is");

    await browser.open(`file://${weave({driver: "depth_of_field", args: ARGS}, OPTIONS)}`);
    await motion(browser, "no-preference");
    await browser.until(`${told} === "4 of 256 lens samples"`);
    await pause(1200);
    check(await browser.value(`${told} === "4 of 256 lens samples"`), "where the reader chooses the samples, their noise stays", await browser.value(told));
    await browser.open(`file://${weave({driver: "depth_of_field", args: ARGS}, "aperture")}`);
    await motion(browser, "no-preference");
    check(await browser.until(`${count} > 4`), "elsewhere a figure goes on by itself");
    await browser.value('document.body.style.marginTop = "9000px"; scrollTo(0, 0)');
    await pause(400);
    const away = await browser.value(count);
    await pause(500);
    check(away < 256 && await browser.value(count) === away, "out of sight it stops", `${away}, ${await browser.value(count)}`);
    await browser.value('Object.defineProperty(document, "hidden", {get: () => window.hides, configurable: true}); window.hides = true; document.body.style.marginTop = "0"');
    await pause(500);
    check(await browser.value(count) === away, "and while the page is hidden", `${away}, ${await browser.value(count)}`);
    await browser.value('window.hides = false; document.dispatchEvent(new Event("visibilitychange"))');
    check(await browser.until(`${count} === 256`), "then it goes on to its end", await browser.value(told));

    await browser.open(`file://${weave({driver: "shading", args: "--scene teapot --shadows --width 40 --height 40"}, "shadows")}`);
    await motion(browser, "no-preference");
    await browser.until(`${live}.dataset.drawn`);
    await pause(1200);
    check(!await shown(browser), "a picture without noise stays as it is");
  }

  return {means_have_less_noise, page_converges};
};
