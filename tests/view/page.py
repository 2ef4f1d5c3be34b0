#!/usr/bin/env python3
"""Opens the live page in a real Chromium and does what an operator does.

    page.py SCENARIO URL FOLDER

Prints lines of JSON on stdout: what happened, then what was found; pictures go into FOLDER. It judges nothing: the test
that starts it does. Ends with 0 unless something that must come did not come in time. Needs playwright and a Chromium
(/usr/bin/chromium, or what DROVER_CHROMIUM names).
"""
import json
import os
import sys
from contextlib import contextmanager
from urllib.parse import urlsplit

from playwright.sync_api import sync_playwright

# Root has no sandbox. The rest keeps the browser from talking to anybody but our page, and its load low.
ARGUMENTS = [
    "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking",
    "--disable-component-update", "--disable-sync",
]
DESK = {"width": 1280, "height": 800}
PHONE = {"width": 390, "height": 844}
PATIENCE_MS = 20_000

SPEEDS = "() => drover.moment.robots.map((robot) => Math.max(...robot.truth.twist_b.map(Math.abs)))"
STATES = "() => drover.moment.robots.map((robot) => robot.state)"
TRUTH = "() => [drover.moment.time_s, drover.moment.robots.map((robot) => robot.truth)]"
IS_MOVING = "() => drover.moment?.robots.filter((robot) => Math.abs(robot.truth?.twist_b[0]) > 0.1).length > 1"

# How far each robot is from where it was at the first call, metres.
WAYS = """() => {
  const places = drover.moment.robots.map((robot) => robot.truth);
  if (!places.every(Boolean)) return [];
  window.first_places ??= places;
  return places.map((at, i) => Math.hypot(at.x_m - first_places[i].x_m, at.y_m - first_places[i].y_m));
}"""

# Pixels of the map in the colour of a driving robot; and in that of what is solid, walls apart.
DRAWN = """() => {
  const canvas = document.getElementById("world");
  const colour = getComputedStyle(document.documentElement).getPropertyValue("--active").trim();
  const wanted = [1, 3, 5].map((at) => parseInt(colour.slice(at, at + 2), 16));
  const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
  let count = 0;
  for (let at = 0; at < data.length; at += 4) count += wanted.every((part, i) => data[at + i] === part);
  return count;
}"""

SOLID = DRAWN.replace("--active", "--solid")

# Seconds of the run per second, over two seconds, from the arrival of a moment to the arrival of another.
RATE = """async () => {
  const next = async () => {
    const before = drover.moment;
    while (drover.moment === before) await new Promise((done) => setTimeout(done, 5));
    return [performance.now() / 1000, drover.moment.time_s];
  };
  const [from, from_s] = await next();
  while (performance.now() / 1000 - from < 2) await new Promise((done) => setTimeout(done, 20));
  const [to, to_s] = await next();
  return (to_s - from_s) / (to - from);
}"""


def say(**words):
    print(json.dumps(words), flush=True)


class Window:
    """A page, and all that it asks for and complains about."""

    def __init__(self, browser, folder, size=None, **more):
        self.context = browser.new_context(viewport=size or DESK, **more)
        self.page = self.context.new_page()
        self.page.set_default_timeout(PATIENCE_MS)
        self.folder = folder
        self.complaints = []
        self.hosts = set()
        self.page.on("request", lambda request: self.note(request.url))
        self.page.on("websocket", lambda socket: self.note(socket.url))
        self.page.on("pageerror", lambda error: self.complaints.append(f"uncaught: {error}"))
        self.page.on("console", self.hear)

    def note(self, url):
        if urlsplit(url).scheme not in ("data", "blob"):
            self.hosts.add(urlsplit(url).netloc)

    def hear(self, message):
        if message.type in ("error", "warning"):
            self.complaints.append(f"{message.type}: {message.text}")

    def open(self, url):
        return self.page.goto(url)

    def wait(self, expression):
        self.page.wait_for_function(expression)

    def wait_text(self, selector, text):
        wanted = f"() => document.querySelector({json.dumps(selector)}).textContent.includes({json.dumps(text)})"
        self.page.wait_for_function(wanted)

    def ask(self, expression):
        return self.page.evaluate(expression)

    def sleep(self, seconds):
        self.page.wait_for_timeout(seconds * 1000)

    def hooks(self):
        return self.ask("() => ({ ...document.body.dataset })")

    def text(self, selector):
        return self.page.locator(selector).inner_text()

    def shoot(self, name):
        self.page.screenshot(path=os.path.join(self.folder, f"{name}.png"))

    def shoot_both(self, name):
        """In light and in dark colours."""
        for scheme in ("dark", "light"):
            self.page.emulate_media(color_scheme=scheme)
            self.sleep(0.4)
            self.shoot(f"{name}-{scheme}")

    def shown(self):
        """Which controls can be seen."""
        names = ["stop", "pause", "speed", "restart", "seek"]
        return {name: self.page.locator(f"#{name}").is_visible() for name in names}

    def tell(self, **found):
        say(complaints=self.complaints, hosts=sorted(self.hosts), hooks=self.hooks(), shown=self.shown(), **found)


def phone_tells(browser, url, folder, name):
    """What a phone shows of the same run."""
    phone = Window(browser, folder, PHONE, device_scale_factor=2, is_mobile=True, has_touch=True)
    phone.open(url)
    phone.wait("() => Number(document.body.dataset.links) > 0")
    phone.sleep(1)
    phone.shoot_both(f"{name}-phone")
    width = "() => document.documentElement.scrollWidth"
    box = phone.page.locator("#stop").bounding_box()
    found = {"width": phone.ask(width), "stop": box, "complaints": phone.complaints, "robots": phone.hooks()["robots"]}
    phone.context.close()
    return found


def watch(browser, url, folder):
    """Robots drive, links and trails are drawn."""
    window = Window(browser, folder)
    window.open(url)
    window.wait("() => drover.moment !== null")
    window.wait(f"() => {{ const ways = ({WAYS})(); return ways.length > 0 && ways.every((way) => way > 0.1); }}")
    window.wait("() => Number(document.body.dataset.links) > 0 && Number(document.body.dataset.trails) > 0")
    window.sleep(1)
    drawn, ways, words = window.ask(DRAWN), window.ask(WAYS), window.text("#connection")
    window.shoot_both("flock-desk")
    window.page.locator("#robots tbody").nth(1).click()
    window.sleep(0.3)
    window.shoot("flock-desk-selected")
    phone = phone_tells(browser, url, folder, "flock")
    window.tell(drawn=drawn, ways=ways, connection=words, phone=phone)


def stop(browser, url, folder):
    """STOP is pressed while they drive."""
    window = Window(browser, folder)
    window.open(url)
    window.wait(IS_MOVING)
    before = window.ask(SPEEDS)
    window.page.click("#stop")
    window.wait_text("#stop-result", "all 5")
    speeds, states, results = [], set(), set()
    for _ in range(20):
        speeds.append(max(window.ask(SPEEDS)))
        states.update(window.ask(STATES))
        results.add(window.text("#stop-result"))
        window.sleep(0.1)
    stopped = window.ask("() => drover.moment.run.stop")
    window.shoot_both("stopped-desk")
    window.tell(before=before, speeds=speeds, states=sorted(states), results=sorted(results), stop=stopped)


def pace(browser, url, folder):
    """Pause, resume, twice as fast, and anew."""
    window = Window(browser, folder)
    window.open(url)
    window.wait(IS_MOVING)
    window.page.click("#pause")
    window.wait("() => document.body.dataset.phase === 'paused'")
    held = window.ask(TRUTH)
    window.sleep(1)
    held_later = window.ask(TRUTH)
    window.shoot("paused-desk")
    window.page.click("#pause")
    window.wait("() => document.body.dataset.phase === 'running'")
    rate = window.ask(RATE)
    window.page.select_option("#speed", "2")
    window.wait("() => drover.moment.run.rate === 2")
    fast = window.ask(RATE)
    time_s = window.ask("() => drover.moment.time_s")
    began = "() => drover.setting.started_unix_us"
    before = window.ask(began)
    window.page.click("#restart")
    window.wait(f"() => drover.setting.started_unix_us !== {before} && drover.moment !== null")
    anew = {"time_s": window.ask("() => drover.moment.time_s"), "began": window.ask(began), "before": before}
    window.wait(IS_MOVING)
    window.tell(held=held, held_later=held_later, rate=rate, fast=fast, time_s=time_s, anew=anew)


def reconnect(browser, url, folder):
    """The server is killed, and another one started."""
    window = Window(browser, folder)
    window.open(url)
    window.wait(IS_MOVING)
    before = window.ask("() => drover.setting.started_unix_us")
    say(event="connected")
    window.wait("() => document.body.dataset.connected === 'no'")
    window.wait_text("#connection", "gone")
    window.page.click("#stop")
    words, result, hint = window.text("#connection"), window.text("#stop-result"), window.text("#stop-hint")
    before_phase = window.ask("() => getComputedStyle(document.getElementById('phase'), '::before').content")
    window.shoot_both("gone-desk")
    window.page.set_viewport_size(PHONE)
    window.sleep(0.3)
    window.shoot("gone-phone")
    window.page.set_viewport_size(DESK)
    say(event="gone", words=words, result=result, hint=hint, before_phase=before_phase)
    window.wait("() => document.body.dataset.connected === 'yes'")
    window.wait(f"() => drover.setting.started_unix_us !== {before} && drover.moment !== null")
    window.wait("() => document.body.dataset.robots === '5'")
    window.tell(words=window.text("#connection"), result=window.text("#stop-result"))


def fleet(browser, url, folder):
    """Many robots."""
    window = Window(browser, folder)
    window.open(url)
    window.wait("() => drover.moment?.robots.length > 0")
    count = window.ask("() => drover.setting.robots.length")
    window.wait(f"() => Number(document.body.dataset.robots) === {count}")
    window.wait(f"() => Number(document.body.dataset.links) > 0 && ({IS_MOVING})()")
    fps = []
    for _ in range(3):
        window.sleep(1.1)
        fps.append(float(window.hooks()["fps"]))
    window.shoot_both(f"diffuse-{count}-desk")
    phone = phone_tells(browser, url, folder, f"diffuse-{count}")
    window.tell(fps=fps, drawn=window.ask(DRAWN), phone=phone)


def movers(browser, url, folder):
    """Discs go across the place."""
    window = Window(browser, folder)
    window.open(url)
    window.wait("() => document.body.dataset.movers")
    seen = []
    for _ in range(2):
        seen.append(window.ask("() => [drover.moment.movers_m, document.body.dataset.movers]"))
        window.sleep(3)
    window.shoot_both("movers-desk")
    window.tell(seen=seen, solid=window.ask(SOLID))


def replay(browser, url, folder):
    """A recording: other moments of it."""
    window = Window(browser, folder)
    window.open(url)
    window.wait("() => drover.moment !== null")
    window.page.click("#pause")
    window.wait("() => drover.moment.run.rate === 0")
    seen = []
    for share in (0.75, 0.25):
        sought = window.ask("() => drover.setting.duration_s") * share
        window.page.locator("#seek").fill(f"{round(sought / 0.05) * 0.05:.2f}")
        window.sleep(0.5)
        seen.append({"sought": sought, "moment": window.ask(TRUTH), "words": window.text("#seek-time")})
    window.page.click("#pause")
    window.wait("() => drover.moment.run.rate === 1")
    window.sleep(1)
    later = window.ask("() => drover.moment.time_s")
    window.shoot_both("replay-desk")
    window.tell(seen=seen, later=later)


def token(browser, url, folder):
    """Without the token, with a wrong one, with the right one."""
    window = Window(browser, folder)
    bare = url.split("?")[0]
    refused = []
    for without in (bare, f"{bare}?token=00000000000000000000000000000000"):
        answer = window.open(without)
        refused.append({"status": answer.status, "words": answer.text()})
    window.complaints.clear()  # A browser complains about each 401.
    status = window.open(url).status
    window.wait("() => document.body.dataset.connected === 'yes' && Number(document.body.dataset.robots) > 0")
    window.tell(refused=refused, status=status)


SCENARIOS = {each.__name__: each for each in (watch, stop, pace, reconnect, fleet, movers, replay, token)}


@contextmanager
def chromium():
    path = os.environ.get("DROVER_CHROMIUM", "/usr/bin/chromium")
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=path, args=ARGUMENTS)
        try:
            yield browser
        finally:
            browser.close()


if __name__ == "__main__":
    scenario, address, pictures = sys.argv[1:]
    with chromium() as running:
        SCENARIOS[scenario](running, address, pictures)
