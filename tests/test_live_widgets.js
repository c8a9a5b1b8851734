// The widgets of live figures, in test_live.js's browser: what is dragged becomes an option, and the numbers and
// pictures that a widget shows are the native driver's.
"use strict";

module.exports = async ({check, native, run, weave, differs, browser}) => {
  const live = 'document.querySelector(".live")', says = `(() => { // with all digits
    const text = ${live}.querySelector(".widget .numbers").cloneNode(true);
    for (const data of text.querySelectorAll("data")) data.textContent = data.value;
    return text.textContent;
  })()`;
  const only = process.env.RAYKIT_TEST_WIDGETS; // names of those to test, separated by spaces

  // Opens a figure with a widget, and waits for its picture and numbers; false if these do not come.
  async function open(driver, widget, args, options) {
    await browser.open(`file://${weave({driver, args}, options, `widget=${widget}`)}`);
    const come = await browser.until(`${live}.dataset.drawn && (${live}.dataset.answered || ${live}.dataset.ready)`);
    check(come, `${widget}: the figure and its widget come`, "no picture or no numbers within 30 seconds");
    return come;
  }
  // Moves the n-th handle by a number of arrow keys.
  async function keys(n, key, times = 1) {
    await browser.value(`${live}.querySelectorAll(".handle")[${n}].focus()`);
    for (let i = 0; i < times; i++) await browser.key(key);
  }
  // Drags the n-th handle's knob by parts of its plot's width and height.
  async function drag(n, dx, dy = 0) {
    const [x, y, width, height] = await browser.value(`(() => {
      const handle = ${live}.querySelectorAll(".handle")[${n}], box = handle.querySelector(".knob").getBoundingClientRect();
      const plot = handle.ownerSVGElement.getBoundingClientRect();
      handle.scrollIntoView({block: "center"});
      const now = handle.querySelector(".knob").getBoundingClientRect();
      return [now.left + now.width / 2, now.top + now.height / 2, plot.width, plot.height];
    })()`);
    await browser.mouse("mousePressed", x, y);
    for (let k = 1; k <= 4; k++) await browser.mouse("mouseMoved", x + dx * width * k / 4, y + dy * height * k / 4);
    await browser.mouse("mouseReleased", x + dx * width, y + dy * height);
  }
  // The options of the command under the figure, once its picture is drawn and its numbers are there.
  async function settled(condition = "true") {
    const done = await browser.until(`(() => {
      const command = ${live}.querySelector(".command").textContent;
      return command.endsWith(" " + ${live}.dataset.drawn) && (${condition});
    })()`);
    return done ? (await browser.value(`${live}.dataset.drawn`)).split(" ") : null;
  }
  const option = (args, name) => args && args[args.indexOf(`--${name}`) + 1];
  const same = (got, wanted, what) => check(got === wanted, what, `${got}\n-- instead of --\n${wanted}`);
  const contains = (text, parts, what) => check(parts.every((part) => text.includes(part)), what, `${text}\n-- without one of --\n${parts.join(", ")}`);

  // The table below the n-th plot that has one: the driver's values, which are copied and saved as CSV, as well.
  async function tells(name, n, heads, rows) {
    const data = `[...${live}.querySelectorAll(".widget .data:not([hidden])")][${n}]`;
    await browser.until(`${data}.open = true, ${data}.querySelectorAll("tbody tr").length === ${rows.length}`);
    const {table, copied, saved, beside} = await browser.value(`(async () => {
      const data = ${data}, cells = (part) => [...data.querySelectorAll(part + " tr")].map((row) => [...row.children].map((cell) => cell.textContent).join());
      let copied = "", blob = null;
      Object.defineProperty(navigator, "clipboard", {configurable: true, value: {writeText: async (text) => { copied = text; }}});
      URL.createObjectURL = (one) => { blob = one; return "#"; };
      data.querySelector("button").click();
      data.querySelector(".save").onclick();
      return {table: [...cells("thead"), ...cells("tbody")], copied, saved: await blob.text(), beside: data.previousSibling.tagName};
    })()`);
    const wanted = rows.map((row) => row.map((cell) => String(isNaN(cell) ? cell : Number(cell))).join());
    const other = wanted.findIndex((line, i) => line !== table[i + 1]);
    check(table.length === wanted.length + 1 && other < 0, `${name}: the table below plot ${n} has the unit's numbers`, `${table[other + 1]} instead of ${wanted[other]}`);
    check(table[0] === heads.join() && beside === "svg", `${name}: its columns have heads, with units`, table[0]);
    const csv = [heads.map((head) => head.includes(",") ? `"${head}"` : head).join(), ...wanted, ""].join("\n");
    check(copied === csv && saved === csv, `${name}: it is copied and saved as CSV`, `${copied.slice(0, 200)}\n-- or --\n${saved.slice(0, 200)}`);
  }

  const widgets = {
    async sah() {
      const args = "--scene statue:200 --bins 12 --debug bad-split --candidate 0 --width 120 --height 120";
      if (!await open("sah_binning", "sah", args, "bins=2..50 node=0..30")) return;
      const {rows} = native("sah_binning", "--scene statue:200 --bins 12 --splits".split(" "), "sah_binning_splits");
      const numbers = ({cost, left, right}) => [`cost ${cost} `, `${left} left`, `${right} right`];
      const costs = (all) => all.filter(({axis}) => axis === all[0].axis && axis).map(({plane, cost}) => [plane, cost]);
      const heads = [`the plane's place on the ${"xyz"[rows[0].axis]} axis, world units`, "expected cost of a ray"];
      await tells("sah", 0, heads, costs(rows));
      await keys(1, "ArrowRight", 2);
      const moved = await settled(`/--candidate 2 /.test(${live}.dataset.drawn)`);
      contains(await browser.value(says), numbers(rows[2]), "sah: an arrow key moves the plane to the unit's next split");
      same(moved ? await differs(browser, "sah_binning") : "no such picture", "", "sah: the picture of that split is the driver's");
      await drag(0, .3);
      const dragged = Number(option(await settled(`!/--candidate 2 /.test(${live}.dataset.drawn)`), "candidate"));
      contains(await browser.value(says), numbers(rows[dragged]), "sah: the plane is dragged over the triangles to the unit's splits");
      await browser.value(`${live}.querySelector(".widget > button").click()`);
      const least = rows.findIndex((row) => row.cheapest === "1");
      same(option(await settled(`!/--candidate ${dragged} /.test(${live}.dataset.drawn)`), "candidate"), String(least), "sah: the cheapest split is the unit's");
      await browser.value(`(() => {
        const slider = ${live}.querySelector("input[name=bins]");
        slider.value = 0;
        slider.dispatchEvent(new Event("change"));
      })()`);
      same(option(await settled('/--bins 2 /.test(document.querySelector(".live").dataset.drawn)'), "candidate"), "0",
        "sah: where there is no such split, the cheapest is drawn");
      await tells("sah", 0, heads, costs(native("sah_binning", "--scene statue:200 --bins 2 --splits".split(" "), "sah_binning_splits").rows));
    },

    async light() {
      const args = "--light-samples 4 --width 60 --height 60", growth = ["--growth", "--most", "64", "--reference", "512"];
      if (!await open("parallelogram_light", "light", args, "light-sampling")) return;
      const told = ({rmse, shadow_rays}) => [`error ${rmse},`, `${shadow_rays} shadow rays`];
      const {rows} = native("parallelogram_light", [...args.split(" "), ...growth], "parallelogram_light_growth");
      await keys(2, "ArrowLeft", 2);
      const chosen = await settled(`${says}.startsWith("16 samples")`);
      contains(await browser.value(says), told(rows[4]), "light: the error and rays of 16 samples are the unit's");
      same(chosen ? await differs(browser, "parallelogram_light") : "no such picture", "", "light: the picture is the driver's of as many samples");
      await tells("light", 0, ["lamp", "samples on the light", "error, RMSE of radiance"], rows.map(({samples, rmse}) => ["now", samples, rmse]));
      await drag(0, -.1, .1);
      await drag(1, .02, -.03);
      const moved = await settled(`${live}.dataset.answered.includes("--lamp-size ") && ${says}.startsWith("64 samples") && ${live}.dataset.drawn.includes("-samples 64")`);
      check(Number(option(moved, "lamp-x")) > 0 && Number(option(moved, "lamp-z")) < 0 && Number(option(moved, "lamp-size")) > 1,
        "light: dragging moves the lamp and resizes it", moved && moved.join(" "));
      const again = native("parallelogram_light", [...moved, ...growth], "parallelogram_light_growth").rows;
      contains(await browser.value(says), told(again[6]), "light: the errors of the moved lamp are the unit's");
      same(await differs(browser, "parallelogram_light"), "", "light: and so is its picture");
      const now = await browser.value(`[...${live}.querySelectorAll(".widget .data:not([hidden]) tbody tr")].map((row) => [...row.children].map((cell) => cell.textContent).join()).filter((row) => row.startsWith("now"))`);
      same(now.join("\n"), again.map(({samples, rmse}) => `now,${samples},${Number(rmse)}`).join("\n"), "light: the table follows the moved lamp");
    },

    async lens() {
      const args = "--scene statue:967 --focal-distance 2 --aperture 200 --lens-samples 4 --width 100 --height 100";
      if (!await open("depth_of_field", "lens", args, "aperture=0..300")) return;
      await keys(0, "ArrowRight", 3);
      const moved = await settled(`${live}.dataset.drawn.includes("-distance 2.15") && ${live}.dataset.answered.includes("-distance 2.15")`);
      same(moved ? await differs(browser, "depth_of_field") : "no such picture", "", "lens: the picture follows the focal plane, and is the driver's");
      await drag(1, .1);
      const {rows} = native("depth_of_field", [...args.replace("-distance 2 ", "-distance 2.15 ").split(" "), "--circles"], "depth_of_field_circles");
      const shown = (await browser.value(says)).match(/A circle of (\S+) pixels around a point at distance (\S+)\. /);
      const row = rows.find(({distance}) => shown && distance === shown[2]);
      const circles = rows.filter((one) => one.distance), most = 2.5 * circles[circles.length - 1].diameter;
      await tells("lens", 1, ["distance from the lens, world units", "diameter, pixels"],
        circles.filter(({diameter}) => Number(diameter) <= Math.max(2, most)).map(({distance, diameter}) => [distance, diameter]));
      check(row && row.diameter === shown[1] && Number(row.distance) > 3, "lens: the dragged point's circle of confusion is the unit's", JSON.stringify([shown, row]));
    },

    async motion() {
      const args = "--time-samples 4 --shutter-open 0 --shutter-close 0 --width 100 --height 100";
      if (!await open("motion_blur", "motion", args, "time-samples=1..64")) return;
      await drag(2, .2);
      const scrubbed = await settled(`!${live}.dataset.drawn.includes("-open 0 ") && ${live}.dataset.answered.includes("-open " + ${live}.dataset.drawn.match(/-open (\\S+)/)[1] + " ")`);
      check(option(scrubbed, "shutter-open") === option(scrubbed, "shutter-close"), "motion: the point moves both ends of the shutter", scrubbed && scrubbed.join(" "));
      same(await differs(browser, "motion_blur"), "", "motion: the picture of one time is the driver's");
      await keys(1, "ArrowRight", 8);
      const open_ = option(scrubbed, "shutter-open"), close = String(Math.round(1000 * (Number(open_) + .08)) / 1000);
      const blurred = await settled(`${live}.dataset.drawn.includes("-close ${close} ") && ${live}.dataset.answered.includes("-close ${close} ")`);
      const {rows} = native("motion_blur", ["--shutter-open", open_, "--shutter-close", close, "--positions"], "motion_blur_shutter");
      const row = rows.find((one) => one.object === "0");
      await tells("motion", 0, ["time", "displacement along x, world units", "displacement upwards, world units"],
        native("motion_blur", ["--positions"], "motion_blur_path").rows.filter(({object}) => object === "0").map(({time, x, y}) => [time, x, y]));
      contains(await browser.value(says), [`(${row.from_x}, ${row.from_y}) to (${row.to_x}, ${row.to_y})`], "motion: the displacements are the unit's");
      same(blurred ? await differs(browser, "motion_blur") : "no such picture", "", "motion: the blurred picture is the driver's");
    },

    async bloom() {
      const args = "--scene lanterns --reflections --fov 27 --bloom-threshold 1 --bloom-radius 20 --width 120 --height 75";
      if (!await open("bloom", "bloom", args, "bloom-radius=1..100")) return;
      const said = async (threshold) => {
        await settled(`${live}.dataset.drawn.includes("-threshold ${threshold} ") && ${live}.dataset.answered.includes("-threshold ${threshold} ")`);
        const {rows} = native("bloom", [...args.replace("-threshold 1 ", `-threshold ${threshold} `).split(" "), "--histogram"], "bloom_bright");
        const row = rows.find((one) => Number(one.threshold) === Math.fround(threshold) || one.threshold === String(threshold)) || rows[rows.length - 1];
        contains(await browser.value(says), [`${row.bright} of ${row.pixels} pixels`, `at least ${row.threshold}:`], `bloom: the number of pixels above ${threshold} is the unit's`);
      };
      await said(1);
      await keys(0, "ArrowRight", 4);
      await said(1.42);
      const {rows} = native("bloom", [...args.replace("-threshold 1 ", "-threshold 1.42 ").split(" "), "--histogram"], "bloom_histogram");
      await tells("bloom", 0, ["luminance from", "luminance to", "pixels"], rows.filter(({bin}) => bin).map(({low, high, pixels}) => [low, high, pixels]));
      same(await differs(browser, "bloom"), "", "bloom: the picture follows the threshold, and is the driver's");
      await drag(0, -.2);
      const dragged = await settled(`!${live}.dataset.drawn.includes("-threshold 1.42 ")`);
      const threshold = Number(option(dragged, "bloom-threshold"));
      check(threshold > .1 && threshold < 1, "bloom: dragging the line to the left lowers the threshold", threshold);
    },

    async lobes() {
      const args = "--shading phong --debug lobe --incidence 60 --shininess 30 --ks 0.7 --width 120 --height 75";
      if (!await open("shading", "lobes", args, "shininess=0..1000")) return;
      const seen = async (incidence, eye, what) => {
        const given = args.replace("--debug lobe --incidence 60", `--incidence ${incidence}`).split(" ");
        const {rows} = native("shading", [...given, "--radiance"], "shading_radiance");
        const row = rows.find((one) => one.incidence === String(incidence) && one.angle === String(eye));
        contains(await browser.value(says), [`Radiance ${row.radiance} `, `diffuse ${row.diffuse} `, `highlight ${row.highlight}.`], what);
      };
      await keys(1, "ArrowLeft", 5);
      await seen(60, 57.5, "lobes: the radiance towards the moved eye is the unit's");
      await drag(0, .05, -.1);
      const moved = await settled(`!${live}.dataset.drawn.includes("-incidence 60 ") && ${live}.dataset.answered.includes("-incidence " + ${live}.dataset.drawn.match(/-incidence (\\S+)/)[1])`);
      check(Number(option(moved, "incidence")) < 60, "lobes: dragging the light turns it", moved && moved.join(" "));
      await seen(option(moved, "incidence"), 57.5, "lobes: the radiance follows the light");
      const given = args.replace("--debug lobe --incidence 60", `--incidence ${option(moved, "incidence")}`).split(" ");
      await tells("lobes", 0, ["angle from the normal, degrees", "radiance", "diffuse", "highlight"],
        run(["shading", ...given, "--radiance"]).rows.map((row) => [row.angle, row.radiance, row.diffuse, row.highlight])); // the native powf has other last digits
      same(await differs(browser, "shading"), "", "lobes: and so does the driver's picture");
    },

    async fold() {
      const args = "--mirror 0.9 --side 8 --marked --width 60 --height 60";
      if (!await open("cubemap", "fold", args, "side=1..256 environment-filter")) return;
      await browser.value(`(() => {
        const list = ${live}.querySelector("select");
        list.value = "nearest";
        list.dispatchEvent(new Event("change"));
      })()`);
      await settled(`${live}.dataset.answered.includes("nearest")`);
      const {picture} = native("cubemap", "--side 8 --marked --environment-filter nearest --debug cross --width 512 --height 384".split(" "));
      const faces = await browser.value(`[...${live}.querySelectorAll(".face > canvas")].map((canvas) => Array.from(canvas.getContext("2d").getImageData(0, 0, 128, 128).data))`);
      const cells = [[1, 1], [1, 2], [1, 3], [1, 0], [0, 1], [2, 1]]; // row and column of -z, +x, +z, -x, +y, -y
      const wrong = cells.filter(([row, column], i) => faces[i].some((value, at) => at % 4 < 3 &&
        value !== picture.rgb[3 * ((128 * row + Math.floor(at / 512)) * 512 + 128 * column + Math.floor(at / 4) % 128) + at % 4]));
      check(faces.length === 6 && wrong.length === 0, "fold: the faces are those of the driver's cross, to the bit", JSON.stringify(wrong));
      const fold = () => browser.value(`${live}.querySelector(".fold .face .face").style.transform`);
      const flat = await fold();
      await browser.value(`${live}.querySelector("input[name=fold]").focus()`);
      await browser.key("End");
      check(flat === "rotateY(0deg)" && await fold() === "rotateY(-90deg)", "fold: the slider folds them to a cube", `${flat}, ${await fold()}`);
      await browser.value(`${live}.querySelector(".fold").focus()`);
      await browser.key("ArrowRight");
      same(await settled('document.querySelector(".live").dataset.drawn.includes("--yaw ")') ? await differs(browser, "cubemap") : "no such picture", "",
        "fold: looking around turns the driver's camera");
    },

    async boxes() {
      const args = "--scene statue:200 --debug traversal --pixel 60,50 --pixel-code --steps 1 --width 120 --height 120";
      if (!await open("bvh_median", "boxes", args, "split=median|sah")) return;
      const {printed} = native("bvh_median", args.split(" "));
      const wanted = printed.split("\n").filter((line) => /^(step|rk_bvh)/.test(line));
      const story = () => browser.value(`[...${live}.querySelectorAll(".story pre:not(.code) span")].map((step) => step.textContent)`);
      same((await story()).join("\n"), wanted.join("\n"), "boxes: the steps are the driver's");
      for (let i = 0; i < 4; i++) await browser.value(`${live}.querySelectorAll(".story button")[1].click()`);
      same(await settled(`${live}.dataset.drawn.includes("--steps 5 ")`) ? await differs(browser, "bvh_median") : "no such picture", "",
        "boxes: the picture has the boxes of the steps so far, to the bit");
      const now = await browser.value(`[${live}.querySelector(".story pre:not(.code) .now"), ${live}.querySelector(".story .code .now")].map((line) => line.textContent)`);
      check(now[0].startsWith("step 5: box") && /(near|far)->box/.test(now[1]), "boxes: beside it is the line that tests the box", now.join("\n"));
    },
  };
  let said = "";
  try {
    weave({driver: "bloom", args: ""}, "bloom-radius=1..9", "widget=none");
  } catch (error) {
    said = String(error.stderr);
  }
  check(/page\.md:3: there is no widget none/.test(said), "a widget that does not exist stops the weaver", said);
  for (const name of only ? only.split(" ") : Object.keys(widgets)) await widgets[name]();
};
