#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""page_test.py PAGE.html [--picture FILE.png] [--size WIDTHxHEIGHT] [--dark] [--look mesh|solid|heat|glass]
[--max-bytes N]

Opens a page of spheretree from disk in headless Chromium and fails if it asks the network for anything, writes an error
to the console, or if its 3D view does not answer: every level of the slider must change what is drawn, and so must the
buttons of the worst spots. Exit code 77, skipped, without chromium and chromedriver."""
import argparse
import base64
import json
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import urllib.request

FLAGS = ["--headless", "--no-sandbox", "--disable-quic", "--no-first-run", "--disable-background-networking", "--disable-component-update",
         "--disable-sync", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist"]


class Browser:
    """The few commands of the WebDriver protocol that this needs; https://www.w3.org/TR/webdriver2/"""

    def __init__(self, size, dark):
        self.folder = tempfile.mkdtemp(prefix="page_test.")
        # A session of its own, so that its children end with it.
        self.driver = subprocess.Popen(["chromedriver", "--port=0"], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True,
                                       start_new_session=True)
        port = None
        while port is None:
            line = self.driver.stdout.readline()
            if not line:
                raise RuntimeError("chromedriver does not start")
            found = re.search(r"started successfully on port (\d+)", line)
            port = found and found.group(1)
        self.url = f"http://127.0.0.1:{port}/session"
        flags = FLAGS + [f"--user-data-dir={self.folder}", f"--window-size={size.replace('x', ',')}"]
        if dark:
            flags.append("--force-dark-mode")
        options = {"args": flags, "perfLoggingPrefs": {"enableNetwork": True, "enablePage": False}}
        answer = self.call("POST", "", {"capabilities": {"alwaysMatch": {
            "browserName": "chrome", "goog:chromeOptions": options, "goog:loggingPrefs": {"browser": "ALL", "performance": "ALL"}}}})
        self.url += "/" + answer["sessionId"]
        if dark:
            self.call("POST", "/goog/cdp/execute", {"cmd": "Emulation.setEmulatedMedia", "params": {
                "features": [{"name": "prefers-color-scheme", "value": "dark"}]}})

    def call(self, method, path, body=None):
        data = None if body is None else json.dumps(body).encode()
        request = urllib.request.Request(self.url + path, data, {"Content-Type": "application/json"}, method=method)
        with urllib.request.urlopen(request, timeout=120) as answer:
            return json.load(answer)["value"]

    def run(self, script):
        return self.call("POST", "/execute/sync", {"script": script, "args": []})

    def log(self, kind):
        return self.call("POST", "/se/log", {"type": kind})

    def close(self):
        try:
            self.call("DELETE", "")
        except OSError:
            pass
        os.killpg(self.driver.pid, signal.SIGTERM)
        self.driver.wait()
        shutil.rmtree(self.folder, ignore_errors=True)


def wait_for(browser, condition, what, seconds=90):
    end = time.monotonic() + seconds
    while not browser.run("return Boolean(" + condition + ")"):
        if time.monotonic() > end:
            raise AssertionError("in vain waited for " + what)
        time.sleep(0.1)


# A number that depends on every pixel of the 3D view; drawn at once, so that no frame is awaited.
SEEN = """sphereView.render(); const gl = sphereView.renderer.getContext(), w = gl.drawingBufferWidth, h = gl.drawingBufferHeight;
const p = new Uint8Array(4 * w * h); gl.readPixels(0, 0, w, h, gl.RGBA, gl.UNSIGNED_BYTE, p);
let sum = 7, lit = 0; for (let i = 0; i < p.length; ++i) { sum = (sum * 31 + p[i]) >>> 0; if (i % 4 === 3 && p[i]) ++lit; }
return [sum, lit / (w * h)];"""


def check_view(browser):
    wait_for(browser, "document.documentElement.dataset.ready && window.sphereView", "the 3D view")
    wait_for(browser, "sphereView.canvas.width > 100", "the size of the 3D view")
    pictures = []
    for level in range(browser.run("return sphereView.levelCount()")):
        browser.run(f"const s = document.querySelector('.level'); s.value = {level}; s.dispatchEvent(new Event('input', {{bubbles: true}}))")
        pictures.append(browser.run(SEEN))
    assert min(lit for _, lit in pictures) > 0.01, f"the view is empty: {pictures}"
    assert len({picture for picture, _ in pictures}) == len(pictures), f"levels look the same: {pictures}"
    for look in ("solid", "mesh", "heat", "glass"):
        browser.run(f"const s = document.querySelector('.look'); s.value = '{look}'; s.dispatchEvent(new Event('change', {{bubbles: true}}))")
        pictures.append(browser.run(SEEN))
    jumped = browser.run("const b = document.querySelector('.spots button:enabled'); if (b) b.click(); return Boolean(b)")
    if jumped:
        assert browser.run(SEEN) != pictures[-1], "the button of the worst spot does nothing"
        assert browser.run("return document.querySelector('.says').textContent.length") > 5, "the worst spot is not named"
        browser.run("document.querySelector('.all').click()")


def check_layout(browser):
    """Nothing is wider than the window but what scrolls by itself, at the width of a desk and of a phone; no button's
    words are cut."""
    for width in (1400, 390):
        browser.call("POST", "/goog/cdp/execute", {"cmd": "Emulation.setDeviceMetricsOverride", "params": {
            "width": width, "height": 900, "deviceScaleFactor": 1, "mobile": False}})
        wide = browser.run("""const limit = document.documentElement.clientWidth + 1;
            return [...document.querySelectorAll('body *')].filter(e => !e.closest('.scroll, .skip, svg') && e.getBoundingClientRect().right > limit)
              .map(e => e.tagName + '.' + e.className + ' ' + e.textContent.slice(0, 40));""")
        assert not wide, f"beyond the window of {width} pixels: {wide[:5]}"
        charts = browser.run("""const limit = document.documentElement.clientWidth + 1;
            return [...document.querySelectorAll('svg')].filter(e => e.getBoundingClientRect().right > limit).map(e => e.ariaLabel);""")
        assert not charts, f"charts beyond the window of {width} pixels: {charts[:5]}"
        decides = browser.run("""return [...document.querySelectorAll('table')].filter(t => t.tHead.rows[0].cells.length > 1)
            .filter(t => t.tHead.rows[0].cells[1].getBoundingClientRect().right > innerWidth).map(t => t.tHead.textContent);""")
        assert not decides, f"the deciding column is beyond the window of {width} pixels: {decides[:5]}"
        cut = browser.run("""return [...document.querySelectorAll('button, summary, th')].filter(e => e.scrollWidth > e.clientWidth + 1)
            .map(e => e.textContent);""")
        assert not cut, f"cut at {width} pixels: {cut[:5]}"
    browser.call("POST", "/goog/cdp/execute", {"cmd": "Emulation.clearDeviceMetricsOverride", "params": {}})


def check_hiding(browser):
    """A page of a batch: an object can be hidden, by its button in the table or by a double click, and comes back."""
    if not browser.run("return Boolean(document.querySelector('[data-eye]'))"):
        return
    browser.run("document.querySelector('.all').click()")
    whole = browser.run(SEEN)
    browser.run("document.querySelector('[data-eye]').click()")
    assert browser.run(SEEN) != whole, "a hidden object is still there"
    end, largest = browser.run("""const shown = sphereView.objects.filter(o => o.shown);
        return [document.querySelector('.legend .most').textContent, Math.max(...shown.map(o => o.most)).toPrecision(3) + ' mm'];""")
    assert end == largest, f"the colours end at {end}, the worst that is shown is {largest}"
    browser.run("document.querySelector('[aria-label=\"Hidden objects\"] button').click()")
    assert browser.run(SEEN) == whole, "an object does not come back"
    hidden = browser.run("""const v = sphereView, c = v.canvas;
        for (let y = 0; y < c.clientHeight; y += 8) for (let x = 0; x < c.clientWidth; x += 8)
          if (v.objectAt(x, y) >= 0) {
            const r = c.getBoundingClientRect();
            c.dispatchEvent(new MouseEvent('dblclick', {clientX: r.left + x, clientY: r.top + y, bubbles: true}));
            return v.objects.filter(o => !o.shown).length;
          }
        return -1;""")
    assert hidden == 1, f"a double click hides {hidden} objects"
    assert browser.run(SEEN) != whole
    browser.run("document.querySelector('[data-eye][aria-pressed=true]').click()")
    assert browser.run(SEEN) == whole, "the table's button does not bring it back"


def check_names(browser):
    """A name in the table shows the worst spot of the leaves, whose figure stands beside it, whatever level was shown
    before."""
    if not browser.run("return Boolean(document.querySelector('[data-object]'))"):
        return
    browser.run("const s = document.querySelector('.level'); s.value = 0; s.dispatchEvent(new Event('input', {bubbles: true}))")
    browser.run("document.querySelector('[data-object]').click()")
    level, last = browser.run("return [Number(document.querySelector('.level').value), sphereView.levelCount() - 1]")
    assert level == last, f"the worst spot of level {last} is shown at level {level}"
    assert browser.run("return document.querySelector('.says').textContent").startswith(
        browser.run("return document.querySelector('[data-object]').textContent")), "the spot has another name"
    browser.run("document.querySelector('.all').click()")


def check_replay(browser):
    """A page with a recording: the time slider moves the tool."""
    if not browser.run("return Boolean(document.querySelector('.time input'))"):
        return
    seen = set()
    for share in (0.1, 0.5, 0.9):
        browser.run(f"const s = document.querySelector('.time input'); s.value = {share} * s.max; s.dispatchEvent(new Event('input', {{bubbles: true}}))")
        seen.add(json.dumps(browser.run(SEEN)))
    assert len(seen) > 1, "the recording does not move"


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("page", type=pathlib.Path)
    parser.add_argument("--picture", type=pathlib.Path)
    parser.add_argument("--size", default="1280x2200")
    parser.add_argument("--dark", action="store_true")
    parser.add_argument("--look")
    parser.add_argument("--level", type=int)
    parser.add_argument("--run", default="", help="JavaScript before the picture")
    parser.add_argument("--max-bytes", type=int, default=5_000_000)
    options = parser.parse_args()
    if not shutil.which("chromium") or not shutil.which("chromedriver"):
        print("skipped: no chromium or no chromedriver")
        sys.exit(77)
    size = options.page.stat().st_size
    assert size <= options.max_bytes, f"{options.page} has {size} bytes"
    browser = Browser(options.size, options.dark)
    try:
        page = options.page.resolve().as_uri()
        begun = time.monotonic()
        browser.call("POST", "/url", {"url": page})
        has_view = browser.run("return Boolean(document.querySelector('.view'))")
        if has_view:
            wait_for(browser, "document.documentElement.dataset.ready && window.sphereView", "the 3D view")
        opened = time.monotonic() - begun
        check_layout(browser)
        if has_view:
            check_view(browser)
            check_hiding(browser)
            check_names(browser)
            check_replay(browser)
        if options.picture:
            for selector, value in (("look", options.look), ("level", options.level)):
                if value is not None:
                    browser.run(f"const s = document.querySelector('.{selector}'); s.value = '{value}'; "
                                "s.dispatchEvent(new Event('change', {bubbles: true})); s.dispatchEvent(new Event('input', {bubbles: true}))")
            if has_view:
                browser.run(options.run + "; sphereView.render()")
            options.picture.write_bytes(base64.b64decode(browser.call("GET", "/screenshot")))
        errors = [entry["message"] for entry in browser.log("browser") if entry["level"] in ("SEVERE", "WARNING")]
        assert not errors, f"on the console: {errors}"
        asked = set()
        for entry in browser.log("performance"):
            message = json.loads(entry["message"])["message"]
            if message["method"] == "Network.requestWillBeSent" and message["params"]["documentURL"].split("#")[0] == page:
                asked.add(message["params"]["request"]["url"].split(",")[0])
        foreign = {url for url in asked if url != page and not url.startswith(("data:", "blob:"))}
        assert page in asked and not foreign, f"requests: {asked}"
        print(f"{options.page.name}: {size} bytes, open with its view after {opened:.1f} s, no request, no error")
    finally:
        browser.close()


main()
