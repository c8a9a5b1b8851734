// Firefox without a window, for the tests of pages.
"use strict";

const {spawn} = require("child_process");
const fs = require("fs");
const net = require("net");
const path = require("path");

// WebDriver's names of keys.
const CONTROL = "\uE009";
const KEYS = {Enter: "\uE006", ArrowLeft: "\uE012", ArrowUp: "\uE013", ArrowRight: "\uE014", ArrowDown: "\uE015"};
const MINUTES_5 = 300000; // what a busy machine may need
// Any free port; and a page may write to the clipboard, of this process alone, without a click.
const PREFERENCES = {"marionette.port": 0, "dom.events.testing.asyncClipboard": true};

// The same as Browser of browser.js, told by Marionette, Firefox's own protocol: messages are JSON behind their number of
// bytes and a colon.
class Firefox {
  constructor(firefox, folder) {
    const profile = path.join(folder, "profile"), lines = Object.entries(PREFERENCES).map((pair) => `user_pref(${JSON.stringify(pair).slice(1, -1)});\n`);
    fs.mkdirSync(profile);
    fs.writeFileSync(path.join(profile, "user.js"), lines.join(""));
    this.process = spawn(firefox, ["--headless", "--no-remote", "--marionette", "--profile", profile],
      {stdio: "ignore", env: {...process.env, HOME: folder}});
    this.waiting = new Map();
    this.last = 0;
    this.socket = this.connect(path.join(profile, "MarionetteActivePort"));
    this.session = this.send("WebDriver:NewSession", {capabilities: {alwaysMatch: {timeouts: {script: MINUTES_5, pageLoad: MINUTES_5}}}});
  }
  async connect(file) {
    let port = "";
    while (!port) {
      if (this.process.exitCode !== null) throw new Error("Firefox has ended before it could be told anything");
      await new Promise((resolve) => setTimeout(resolve, 100));
      port = fs.existsSync(file) && fs.readFileSync(file, "utf8");
    }
    const socket = net.connect(Number(port), "127.0.0.1");
    let bytes = Buffer.alloc(0);
    socket.on("data", (data) => {
      bytes = Buffer.concat([bytes, data]);
      for (let at; (at = bytes.indexOf(":") + 1) > 0;) {
        const end = at + Number(bytes.subarray(0, at - 1));
        if (bytes.length < end) return;
        const message = JSON.parse(bytes.subarray(at, end));
        bytes = bytes.subarray(end);
        if (Array.isArray(message)) this.take(message); // unlike the greeting
      }
    });
    socket.on("close", () => this.waiting.forEach(({reject}) => reject(new Error("Firefox has ended"))));
    return socket;
  }
  take([, id, error, result]) {
    const {resolve, reject} = this.waiting.get(id);
    this.waiting.delete(id);
    if (error) reject(new Error(`${error.error}: ${error.message}`));
    else resolve(result);
  }
  async send(command, params = {}) {
    const socket = await this.socket, id = ++this.last, text = JSON.stringify([0, id, command, params]);
    socket.write(`${Buffer.byteLength(text)}:${text}`);
    return new Promise((resolve, reject) => this.waiting.set(id, {resolve, reject}));
  }
  async open(page) {
    await this.session;
    await this.send("WebDriver:Navigate", {url: page});
  }
  async value(expression) {
    return (await this.send("WebDriver:ExecuteScript", {script: `return (${expression});`, args: [], sandbox: null})).value;
  }
  // Until the expression is true; false after five minutes.
  async until(expression) {
    for (const begun = Date.now(); Date.now() < begun + MINUTES_5;) {
      if (await this.value(expression).catch(() => false)) return true;
      await new Promise((resolve) => setTimeout(resolve, 100));
    }
    return false;
  }
  async keys(keys) {
    await this.send("WebDriver:PerformActions", {actions: [{type: "key", id: "keys", actions: keys.map(([type, value]) => ({type, value}))}]});
  }
  // A letter with Ctrl.
  async press(letter) {
    await this.keys([["keyDown", CONTROL], ["keyDown", letter], ["keyUp", letter], ["keyUp", CONTROL]]);
  }
  // A key by its name, or a letter.
  async key(key) {
    await this.keys(["keyDown", "keyUp"].map((type) => [type, KEYS[key] || key]));
  }
  async mouse(type, x, y) {
    const actions = [{type: "pointerMove", x: Math.round(x), y: Math.round(y), origin: "viewport"},
      {type: type === "mousePressed" ? "pointerDown" : "pointerUp", button: 0}];
    await this.send("WebDriver:PerformActions", {actions: [{type: "pointer", id: "mouse", parameters: {pointerType: "mouse"}, actions}]});
  }
  async insert(text) {
    await this.value(`navigator.clipboard.writeText(${JSON.stringify(text)})`);
    await this.press("v");
  }
  async quit() {
    if (this.process.exitCode !== null) return;
    const ended = new Promise((resolve) => this.process.on("exit", resolve));
    this.send("Marionette:Quit", {flags: ["eForceQuit"]}).catch(() => {});
    await ended;
  }
}

module.exports = {Firefox};
