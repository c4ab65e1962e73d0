"""A user of the pilot's page in headless Chromium (browser.mjs), controlled by a test."""

import json
import os
import shutil
import unittest

import programs
from programs import wait_until
from rig import HERE, BOOT_S

PLAYWRIGHT = os.environ.get("LSS_E2E_PLAYWRIGHT", "")
CHROMIUM = shutil.which("chromium")
NODE = shutil.which("node")
PATIENCE_S = 70  # a little more than that of browser.mjs

needs_browser = unittest.skipUnless(CHROMIUM and NODE and os.path.isdir(PLAYWRIGHT),
                                    "needs chromium, node and the page that was built")


class Browser:
    def __init__(self, scenario):
        self.answers = 0
        self.program = scenario.begin("browser", [NODE, os.path.join(HERE, "browser.mjs")], CHROMIUM=CHROMIUM,
                                      PLAYWRIGHT=PLAYWRIGHT, HOME=scenario.folder)
        self.answer("to start")

    def answer(self, what):
        def come():
            if not self.program.running():
                raise AssertionError(f"the browser ended\n{self.program.err()}")
            return self.program.json_lines()[self.answers:]
        answer = wait_until(come, PATIENCE_S, what, poll_s=0.01)[0]
        self.answers += 1
        return answer

    def do(self, *words):
        """The answer to a verb of browser.mjs; AssertionError with the page's text when that failed."""
        self.program.say(json.dumps(words))
        answer = self.answer(words)
        if "error" in answer:
            self.program.say(json.dumps(["ask", "document.body.innerText"]))
            raise AssertionError(f"{answer['error']}\n{self.answer('text').get('is')}")
        return answer["is"]

    def text(self, selector):
        return self.do("ask", f"document.querySelector({json.dumps(selector)}).textContent")

    def says(self, selector, words, limit_s=60):
        """When it did, CLOCK_MONOTONIC in ns: words on the page, and to be seen."""
        element = f"document.querySelector({json.dumps(selector)})"
        return self.do("until", f"{element}.checkVisibility() && {element}.textContent.includes({json.dumps(words)})",
                       limit_s * 1000 * programs.patience)

    def ends(self, phase):
        """Of the command that was pushed last."""
        self.do("until", "/completed|rejected|failed|unanswered|superseded/.test(document.querySelector('#running').textContent)",
                60_000 * programs.patience)
        text = self.text("#running")
        if phase not in text:
            raise AssertionError(f"{text}; problems: {self.text('#problems')}")

    def done(self, name):
        self.do("push", name)
        self.ends("completed")
