// Chromium without a window, for the tests of pages.
"use strict";

const {spawn} = require("child_process");
const path = require("path");

const MINUTES_5 = 300000; // what a busy machine may need

// With a mouse, which Chromium without a window lacks, so that nothing shows on pointing at it.
const MOUSE = "--blink-settings=primaryHoverType=2,availableHoverTypes=2,primaryPointerType=4,availablePointerTypes=4";

// A browser that is told what to do by its own protocol, through two pipes.
class Browser {
  constructor(chromium, folder, more = []) {
    const options = [...more, "--headless", "--disable-gpu", "--remote-debugging-pipe", "--window-size=1200,900",
      `--user-data-dir=${path.join(folder, "profile")}`, ...(process.getuid() === 0 ? ["--no-sandbox"] : [])];
    this.process = spawn(chromium, options, {stdio: ["ignore", "ignore", "ignore", "pipe", "pipe"]});
    this.waiting = new Map();
    let text = "";
    this.process.stdio[4].on("data", (data) => {
      const messages = (text + data).split("\0");
      text = messages.pop();
      for (const message of messages.map((part) => JSON.parse(part))) {
        if (this.waiting.has(message.id)) this.waiting.get(message.id)(message.result || message);
        this.waiting.delete(message.id);
      }
    });
    this.last = 0;
  }
  send(method, params = {}) {
    this.process.stdio[3].write(`${JSON.stringify({id: ++this.last, method, params, sessionId: this.session})}\0`);
    return new Promise((resolve) => this.waiting.set(this.last, resolve));
  }
  // In the place of the page before: each one of the site that stays open holds a compiler.
  async open(page, before = "") {
    const left = this.target;
    this.session = undefined;
    const {targetId} = await this.send("Target.createTarget", {url: "about:blank"});
    if (left) await this.send("Target.closeTarget", {targetId: left});
    this.target = targetId;
    this.session = (await this.send("Target.attachToTarget", {targetId, flatten: true})).sessionId;
    await this.send("Page.enable");
    await this.send("Page.addScriptToEvaluateOnNewDocument", {source: before});
    await this.send("Page.navigate", {url: page});
  }
  async value(expression) {
    const answer = await this.send("Runtime.evaluate", {expression, awaitPromise: true, returnByValue: true});
    if (answer.exceptionDetails) throw new Error(`${expression}: ${answer.exceptionDetails.exception.description}`);
    return answer.result.value;
  }
  // Until the expression is true; false after five minutes, which a busy machine may need.
  async until(expression) {
    for (const begun = Date.now(); Date.now() < begun + MINUTES_5;) {
      if (await this.value(expression).catch(() => false)) return true;
      await new Promise((resolve) => setTimeout(resolve, 100));
    }
    return false;
  }
  // A key by its name, or a letter.
  async key(key) {
    const text = key === "Enter" ? "\r" : key.length === 1 ? key : undefined;
    for (const type of ["keyDown", "keyUp"]) await this.send("Input.dispatchKeyEvent", {type, key, text: type === "keyDown" ? text : undefined});
  }
  // A letter with Ctrl.
  async press(letter) {
    const key = {key: letter, code: `Key${letter.toUpperCase()}`, windowsVirtualKeyCode: letter.toUpperCase().charCodeAt(0)};
    for (const type of ["keyDown", "keyUp"]) await this.send("Input.dispatchKeyEvent", {type, ...key, modifiers: 2});
  }
  async insert(text) {
    await this.send("Input.insertText", {text});
  }
  // As on a phone or on a desk, light or dark.
  async view(width, scheme) {
    const mobile = width < 600;
    await this.send("Emulation.setDeviceMetricsOverride", {width, height: 900, deviceScaleFactor: 1, mobile});
    await this.send("Emulation.setTouchEmulationEnabled", {enabled: mobile});
    await this.send("Emulation.setEmulatedMedia", {features: [{name: "prefers-color-scheme", value: scheme}]});
  }
  async mouse(type, x, y) {
    await this.send("Input.dispatchMouseEvent", {type, x, y, button: "left", buttons: 1, clickCount: 1});
  }
  async close() {
    await this.send("Target.closeTarget", {targetId: this.target});
    this.target = undefined;
  }
  async quit() {
    const ended = new Promise((resolve) => this.process.on("exit", resolve));
    this.session = undefined;
    this.send("Browser.close");
    await ended;
  }
}

module.exports = {Browser, MOUSE};
