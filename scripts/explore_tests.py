"""The page of `mapgen explore` in Chromium. Called by explore-tests.sh: explore_tests.py MAPGEN [FOLDER FOR PICTURES]."""

import csv
import json
import math
import os
import random
import struct
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from explore_browser import Browser

MAPGEN = Path(sys.argv[1]).resolve()
PICTURES = Path(sys.argv[2]) if len(sys.argv) > 2 and sys.argv[2] else None

IDLE = "explorer.map.tiles.scene !== null && explorer.map.tiles.busy === 0"
# Whether the tile in the middle is there, of the level whose cells are pixels.
SHARP = "(map) => { const z = map.z, at = (part) => Math.floor(part * 2 ** z); return map.tiles.kept.has(`${z}/${at(explorer.state.u)}/${at(explorer.state.v)}`); }"
TEXT = "document.getElementById('{}').textContent"

told = []


def tell(text):
    told.append(text)
    print(text, flush=True)


class Explorer:
    """The program at work."""

    def __init__(self, *arguments):
        self.process = subprocess.Popen(
            [MAPGEN, "explore", "--threads", "2", *arguments], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True
        )
        self.address = self.process.stdout.readline().strip()

    def memory(self):
        """Its resident memory, in megabytes."""
        status = Path(f"/proc/{self.process.pid}/status").read_text()
        return next(int(line.split()[1]) for line in status.splitlines() if line.startswith("VmRSS")) / 1024

    def busy(self):
        """Its processor time, in seconds."""
        fields = Path(f"/proc/{self.process.pid}/stat").read_text().rsplit(")", 1)[1].split()
        return (int(fields[11]) + int(fields[12])) / 100

    def close(self):
        self.process.terminate()
        self.process.wait(timeout=30)


def shoot(browser, name):
    if PICTURES:
        PICTURES.mkdir(parents=True, exist_ok=True)
        browser.picture(PICTURES / f"{name}.png")


def rectangle(browser, name="cells"):
    script = f"(() => {{ const r = document.getElementById('{name}').getBoundingClientRect(); return [r.left, r.top, r.width, r.height]; }})()"
    return browser.run(script)


def loads(browser, explorer):
    browser.open(explorer.address)
    browser.until("document.getElementById('busy')?.textContent.startsWith('computing, ')", "the sign of computing")
    browser.until("window.explorer !== undefined && explorer.map.firstMap !== null", "the first map")
    first = browser.run("explorer.map.firstMap")
    browser.until(IDLE, "all tiles")
    whole = browser.run("performance.now()")
    browser.until("document.getElementById('busy').hidden", "the end of that sign")
    load = os.getloadavg()[0]
    tell(f"first map {first:.0f} ms after the page was asked for, every pixel with its own cell after {whole:.0f} ms (two threads; load of the machine {load:.1f})")
    browser.until(f"{TEXT.format('cell')}.startsWith('Under the cross: ω')", "the cell that is spoken")


def zooms(browser):
    """By 10⁶ in ten steps, towards a border: wherever it is, cells of two kinds stay in sight as long as one looks at it."""
    left, top, width, height = rectangle(browser)
    begun = time.monotonic()
    # Where two neighbouring cells of a row differ, nearest to the middle; the border between them.
    border = """(() => {
        const map = explorer.map, W = map.canvas.width, H = map.canvas.height, s = 2 ** -explorer.state.zoom;
        let best = null;
        for (let y = 0; y < H; y += 7) for (let x = 2; x < W; x += 1) {
            const kind = (px) => {
                const u = explorer.state.u - s / 2 + (px + 0.5) / W * s, v = explorer.state.v - s / 2 + (1 - (y + 0.5) / H) * s;
                const cell = map.cell(u, v);
                return cell === null ? "" : cell.text.split(",")[0];
            };
            const far = Math.hypot(x - W / 2, y - H / 2);
            if ((best === null || far < best[2]) && kind(x) !== kind(x - 1)) best = [x / W, (y + 0.5) / H, far];
        }
        return best;
    })()"""
    for step in range(10):
        found = browser.run(border)
        assert found is not None, f"no border in sight after {step} steps"
        x, y = left + found[0] * width, top + found[1] * height
        before = browser.run("explorer.state.zoom")
        # 10^0.6 a step, about the place of the border: turns of the wheel, of at most two zooms each.
        browser.mouse("mouseWheel", x, y, deltaX=0, deltaY=-240 * 0.6 / 0.30103)
        browser.until(f"explorer.state.zoom > {before} + 1.9", "a zoom")
        # What is in the middle comes first, and is sharp; what is about it has been seen roughly by then.
        browser.until(f"(({SHARP})(explorer.map))", "the middle of a step")
    seconds = (time.monotonic() - begun) / 10
    browser.until(IDLE, "all tiles", patience=240)
    factor = 2 ** browser.run("explorer.state.zoom")
    tell(f"zoomed by {factor:.3g} in ten steps along a border, {seconds:.2f} s a step until what is in the middle is sharp")
    assert 0.98e6 < factor < 1.02e6
    shoot(browser, "zoomed")
    kinds = browser.run("(() => { const map = explorer.map; const found = new Set(); for (const [z, x, y] of map.visible(map.z)) { const tile = map.tiles.get(z, x, y); if (tile) tile.class.forEach((c) => found.add(c)); } return found.size; })()")
    assert kinds >= 2, "the border is lost"


def tiles_are_sweeps(browser):
    """What the page has of a tile, against a sweep of the tile's range, with the values that the page itself works out."""
    chosen = browser.run("""(async () => {
        const { value } = await import("./plane.js");
        const { limits } = await import("./state.js");
        const map = explorer.map;
        return map.visible(map.z).slice(0, 3).map(([z, x, y]) => {
            const tile = map.tiles.get(z, x, y);
            return { scene: explorer.state.scene, place: [z, x, y], xs: Array.from({ length: 64 }, (_, i) => value(limits()[0], z, x, i)),
                ys: Array.from({ length: 64 }, (_, i) => value(limits()[1], z, y, i)), class: [...tile.class], radius: [...tile.radius].map(String), margin: [...tile.margin].map(String) };
        });
    })()""")
    names = browser.run("explorer.map.colours.classes")
    cells = 0
    for tile in chosen:
        scene = {key: tile["scene"][key] for key in ("model", "sweep", "compute")}
        for axis, values in (("x", tile["xs"]), ("y", tile["ys"])):
            scene["sweep"][axis] = {"parameter": scene["sweep"][axis]["parameter"], "from": values[0], "to": values[-1], "points": 64}
        with tempfile.TemporaryDirectory() as folder:
            Path(folder, "tile.json").write_text(json.dumps(scene))
            subprocess.run([MAPGEN, "sweep", "tile.json", "--out", "tile.csv", "--quiet"], cwd=folder, check=True)
            with open(Path(folder, "tile.csv"), newline="") as table:
                rows = list(csv.DictReader(table))
        assert len(rows) == 64 * 64
        x, y = (scene["sweep"][axis]["parameter"] for axis in "xy")
        bits = lambda text: struct.pack("<d", float(text)) if text not in ("", "NaN") else b""
        for i, row in enumerate(rows):
            assert float(row[x]) == tile["xs"][i % 64] and float(row[y]) == tile["ys"][i // 64], (tile["place"], i)
            assert row["class"] == (names[tile["class"][i]] if tile["class"][i] < 255 else ""), (tile["place"], i)
            assert bits(row["spectral_radius"]) == bits(tile["radius"][i]) and bits(row["margin"]) == bits(tile["margin"][i])
            cells += 1
    tell(f"{len(chosen)} tiles in sight are a sweep's to the bit, {cells} cells at zoom {browser.run('explorer.state.zoom'):.1f}")
    assert len(chosen) == 3


def orbits_are_printed(browser):
    """A click shows what mapgen orbit prints for the same point, in numbers and as pictures."""
    browser.run("explorer.map.whole()")
    browser.until(IDLE, "the whole map")
    left, top, width, height = rectangle(browser)
    browser.click(left + 0.5 * width, top + 0.6 * height)
    browser.until("!document.getElementById('pointbody').hidden", "the orbit")
    browser.until(f"{TEXT.format('pointnote')}.includes('physical')", "all families")
    model = browser.run("({ ...explorer.state.scene.model, omega: explorer.state.at[0], gamma2: explorer.state.at[1] })")
    shown = json.loads(browser.run(TEXT.format("json")))
    flags = [f"--{key}={value!r}" for key, value in model.items()]
    which = browser.run("explorer.state.which")
    printed = json.loads(subprocess.run([MAPGEN, "orbit", f"--family={which}", "--json", *flags], capture_output=True, check=True, text=True).stdout)
    assert shown == printed, "the orbit shown is not the one that is printed"
    parts = {name: browser.run(f"document.querySelectorAll('#{name} path, #{name} circle').length") for name in ("chain", "profile", "trace", "phase", "multipliers")}
    assert all(count > 5 for count in parts.values()), parts
    listed = len(printed["solutions"][browser.run("explorer.state.number")]["stability"]["multipliers"])
    assert parts["multipliers"] >= listed
    # The chain moves.
    height = "[...document.querySelectorAll('#chain circle')].map((mass) => mass.getAttribute('cy')).join()"
    before = browser.run(height)
    browser.until(f"{height} !== {before!r}", "motion")
    shoot(browser, "orbit")
    # A run from it.
    browser.run("document.getElementById('periods').value = '400'; document.getElementById('start').click()")
    browser.until("!document.getElementById('runbody').hidden", "a run")
    note = browser.run(TEXT.format("runnote"))
    assert "to the end" in note, note
    browser.run("document.getElementById('runform').scrollIntoView()")
    time.sleep(0.2)
    shoot(browser, "run")
    tell(f"a click shows the orbit that mapgen orbit prints ({listed} multipliers); a run from it: {note}")
    # The address brings all of it back.
    time.sleep(0.5)
    state = browser.run("JSON.stringify(explorer.state)")
    browser.call("Page.reload")
    browser.until("window.explorer !== undefined && explorer.state.run !== null && !document.getElementById('runbody').hidden", "what was shown before")
    again = browser.run("JSON.stringify(explorer.state)")
    assert json.loads(state) == json.loads(again), (state, again)
    tell("loaded again, the address brings back map, orbit and run")


def keys_suffice(browser, explorer):
    """From the address to the multipliers without a mouse: map, zoom, orbit, a parameter, a run."""
    browser.open("about:blank")
    browser.open(explorer.address)
    browser.until("window.explorer !== undefined && explorer.map.firstMap !== null", "the first map")

    def tab_to(name):
        for stops in range(80):
            if browser.run(f"document.activeElement?.id === '{name}'"):
                outline = browser.run("getComputedStyle(document.activeElement).outlineStyle")
                assert outline != "none", f"{name}: focus is not seen"
                return stops
            browser.key("Tab")
        raise AssertionError(f"{name} is not reached by Tab")

    stops = tab_to("map")
    assert stops <= 6, f"the map is stop {stops}"
    before = browser.run("[explorer.state.u, explorer.state.v, explorer.state.zoom]")
    for key in ["ArrowRight", "ArrowDown", "+", "+"]:
        browser.key(key)
    after = browser.run("[explorer.state.u, explorer.state.v, explorer.state.zoom]")
    assert after[0] > before[0] and after[1] < before[1] and after[2] == before[2] + 2, (before, after)
    browser.key("ArrowLeft", modifiers=8)
    cell = browser.run("explorer.state.u")
    assert 0 < after[0] - cell < 1 / 500, "Shift moves by more than a cell"
    browser.until(IDLE, "tiles")
    spoken = TEXT.format("cell")
    browser.until(f"{spoken}.includes('ω = ') && !{spoken}.includes('computing')", "what is spoken")
    browser.key("Enter")
    browser.until("!document.getElementById('pointbody').hidden", "the orbit under the cross")
    assert browser.run("document.activeElement.id") == "pointname", "the focus has not gone to the orbit"
    tab_to("solution")
    tab_to("periods")
    browser.key("Enter")
    browser.until("!document.getElementById('runbody').hidden", "a run")
    browser.key("Escape")
    assert browser.run("document.getElementById('point').hidden && document.activeElement.id === 'map'"), "Escape does not lead back"
    tab_to("value-asymmetry")
    browser.run("document.activeElement.select()")
    for key in "0.5":
        browser.key(key)
    browser.key("Enter")
    browser.until("explorer.state.scene.model.asymmetry === 0.5", "another asymmetry")
    browser.run("document.activeElement.select()")
    for key in "1.5":
        browser.key(key)
    browser.key("Enter")
    browser.until("document.getElementById('wrong').textContent.includes('asymmetry = 1.5 is out of range')", "what is wrong")
    assert browser.run("explorer.state.scene.model.asymmetry") == 0.5
    # It stays in its field, and Undo puts back what the map shows.
    assert browser.run("document.getElementById('value-asymmetry').value") == "1.5"
    tab_to("restore")
    browser.key("Enter")
    assert browser.run("document.getElementById('value-asymmetry').value") == "0.5"
    assert browser.run(TEXT.format("wrong")) == ""
    tell(f"keys alone: to the map in {stops} steps; moved, zoomed, looked at an orbit, ran it, changed a parameter, was told of a wrong one")


def unnamed(browser):
    """Controls without a name for those who cannot see them."""
    tree = browser.call("Accessibility.getFullAXTree")["nodes"]
    roles = {"button", "slider", "textbox", "checkbox", "combobox", "spinbutton", "link", "image", "img", "application"}
    found = [node for node in tree if node.get("role", {}).get("value") in roles and not node.get("ignored")]
    nameless = [node["role"]["value"] for node in found if not node.get("name", {}).get("value")]
    assert len(found) > 25 and not nameless, (len(found), nameless)
    tell(f"{len(found)} controls and pictures, each with a name for screen readers")


def fingers(browser):
    """Two fingers zoom, one moves, a tap looks at a point."""
    browser.run("explorer.map.whole()")
    left, top, width, height = rectangle(browser)
    browser.call("Emulation.setTouchEmulationEnabled", enabled=True, maxTouchPoints=2)

    def touch(kind, *points):
        listed = [{"x": left + x * width, "y": top + y * height, "id": i} for i, (x, y) in enumerate(points)]
        browser.call("Input.dispatchTouchEvent", type=kind, touchPoints=listed)

    touch("touchStart", (0.45, 0.5))
    touch("touchStart", (0.45, 0.5), (0.55, 0.5))
    for step in range(1, 6):
        touch("touchMove", (0.45 - 0.06 * step, 0.5), (0.55 + 0.06 * step, 0.5))
    touch("touchEnd")
    browser.until("explorer.state.zoom > 2", "a zoom by two fingers")
    zoom, u = browser.run("[explorer.state.zoom, explorer.state.u]")
    # From a tenth of the map's width to seven tenths.
    assert abs(2**zoom - 7) < 1.5 and abs(u - 0.5) < 0.05, (zoom, u)
    touch("touchStart", (0.5, 0.5))
    for step in range(1, 4):
        touch("touchMove", (0.5 - 0.1 * step, 0.5))
    touch("touchEnd")
    browser.until(f"explorer.state.u > {u} + 0.02", "a move by one finger")
    assert browser.run("explorer.state.zoom") == zoom
    touch("touchStart", (0.6, 0.6))
    touch("touchEnd")
    browser.until("!document.getElementById('pointbody').hidden", "the orbit under a finger")
    browser.run("document.getElementById('leave').click()")
    browser.call("Emulation.setTouchEmulationEnabled", enabled=False)
    tell(f"two fingers zoom (by {2**zoom:.1f}), one moves, a tap looks at a point")


def nonsense_is_told(browser):
    """What is typed and is no number is told as the program tells it of a scene, and stays in its field; nothing is taken up of it."""
    told_of = 0
    before = browser.run("JSON.stringify(explorer.state.scene)")
    for field, typed, told in [
        ("value-asymmetry", "x", 'asymmetry = "x" is not a number'),
        ("value-gamma1", "", 'gamma1 = "" is not a number'),
        ("value-sites", "21.5", "sites = 21.5 is not a whole number"),
        ("threshold", "1%", 'threshold = "1%" is not a number'),
        ("x-from", "0,4", 'from = "0,4" is not a number'),
        ("x-to", "-1", "is not a range: give finite values with from < to"),
        ("words", "0+9", "`9` is not an impact"),
    ]:
        browser.run(f"""(() => {{ const field = document.getElementById('{field}'); field.value = {json.dumps(typed)};
            field.dispatchEvent(new Event('change', {{ bubbles: true }})); }})()""")
        browser.until(f"{TEXT.format('wrong')}.includes({json.dumps(told)})", f"{told}, instead of {browser.run(TEXT.format('wrong'))}")
        assert browser.run(f"document.getElementById('{field}').value") == typed
        assert browser.run(f"document.getElementById('{field}').getAttribute('aria-invalid')") == "true"
        told_of += 1
        # Another field that is right does not wipe it.
        if field == "threshold":
            browser.run("document.querySelector('#families input[value=single-sided]').click()")
            time.sleep(0.4)
            assert browser.run(f"document.getElementById('{field}').value") == typed
        assert browser.run("JSON.stringify(explorer.state.scene)") == before
        browser.run("document.getElementById('restore').click()")
        assert browser.run(f"document.getElementById('{field}').value") != typed
    assert told_of == 7
    tell(f"{told_of} kinds of nonsense in fields are told in the program's words, and wiped by nobody but Undo")


def clicks_open_what_is_told(browser):
    """A click opens the very point that the text under the map names, whatever the length of that text: the map does not move."""
    clicks = 0
    for width, height in [(1400, 900), (1300, 800)]:
        browser.size(width, height)
        for panel in [False, True]:
            browser.run("document.getElementById('leave').click(); explorer.map.whole()")
            if panel:
                browser.run("explorer.map.choose(0.5, 0.5)")
                browser.until("!document.getElementById('pointbody').hidden", "an orbit")
            time.sleep(0.3)
            browser.until(IDLE, "the whole map")
            left, top, across, up = rectangle(browser)
            random.seed(width)
            for _ in range(8):
                x, y = (int(start + (0.02 + 0.96 * random.random()) * side) for start, side in [(left, across), (top, up)])
                browser.mouse("mouseMoved", x, y)
                browser.until(f"{TEXT.format('under')}.startsWith('Under the pointer: ω')", "what is under the pointer")
                told_at = browser.run(TEXT.format("under"))
                assert rectangle(browser) == [left, top, across, up], (told_at, rectangle(browser))
                browser.click(x, y)
                at = browser.run("explorer.state.at")
                assert told_at.startswith(f"Under the pointer: ω = {at[0]}, γ₂ = {at[1]}: "), (told_at, at)
                clicks += 1
                if not panel:
                    # The panel makes the map narrower: what is under the pointer is told anew.
                    browser.until(f"{TEXT.format('under')} !== {json.dumps(told_at)}", "what is under the pointer now")
                    browser.run("document.getElementById('leave').click()")
                    browser.until(f"document.getElementById('cells').getBoundingClientRect().width === {across}", "the map alone")
    browser.run("document.getElementById('leave').click()")
    browser.size(1400, 900)
    time.sleep(0.5)
    assert clicks == 32
    tell(f"{clicks} clicks at two sizes open the point that the text names, and no text moves the map")


def small_screens(browser):
    """On a small screen what is opened comes into sight; axes have two numbers at least."""
    inside = "(() => {{ const r = document.getElementById('{}').getBoundingClientRect(); return r.top >= 0 && r.bottom <= innerHeight && r.height > 0; }})()"
    for width, height in [(800, 600), (375, 667), (320, 568)]:
        browser.size(width, height, mobile=width < 500)
        # A map of another size is laid out anew, and a click before that is lost.
        time.sleep(0.5)
        browser.run("scrollTo(0, 0); explorer.map.whole()")
        browser.until(IDLE, "the whole map")
        numbers = browser.run("[...document.querySelectorAll('#over text')].map((text) => text.textContent).filter((text) => /^[0-9.]+$/.test(text)).length")
        assert numbers >= 4, (width, numbers)
        # A page that changes its size scrolls once more after it has been told to.
        browser.until("(() => { scrollTo(0, 0); return document.getElementById('cells').getBoundingClientRect().bottom < innerHeight; })()", "the map in sight")
        left, top, across, up = rectangle(browser)
        browser.click(left + 0.6 * across, top + 0.6 * up)
        browser.until("!document.getElementById('point').hidden && !document.getElementById('pointbody').hidden", "the orbit")
        browser.until(inside.format("pointname") + " && " + inside.format("chain"), f"the point in sight, {width} by {height}")
        shoot(browser, f"point-{width}")
        browser.run("document.getElementById('leave').click()")
        browser.until("(() => { const r = document.getElementById('map').getBoundingClientRect(); return r.top > -20 && r.top < innerHeight / 2; })()", "the map again")
        browser.run("scrollTo(0, 0); document.getElementById('takealong').click()")
        for name in ["command", "scene"]:
            browser.run(f"document.querySelector('[data-take={name}]').click()")
            browser.until("!document.getElementById('taken').hidden", name)
            assert all(browser.run(inside.format(part)) for part in ["text", "copy", "untake"]), f"{width} by {height}: {name} is out of sight"
        shoot(browser, f"take-{width}")
        browser.run("document.getElementById('untake').click()")
        assert browser.run("document.documentElement.scrollWidth") <= width, f"wider than {width}"
    browser.size(1400, 900)
    time.sleep(0.5)
    tell("800 by 600, 375 by 667, 320 by 568: point, command and scene come into sight, axes have their numbers")


def follows(browser):
    """A point that is looked at stays while a slider moves: its orbit changes with it. What is refused leaves all as it was."""
    browser.run("explorer.map.whole(); explorer.map.choose(0.6, 0.4)")
    browser.until("!document.getElementById('pointbody').hidden && document.getElementById('json').textContent !== ''", "the orbit")
    at, before = browser.run("[explorer.state.at, JSON.parse(document.getElementById('json').textContent).parameters.asymmetry]")
    browser.run("""(() => { const slider = document.querySelector('#values input[type=range][aria-label^=asymmetry]');
        slider.value = '0.3'; slider.dispatchEvent(new Event('input', { bubbles: true })); })()""")
    browser.until("document.getElementById('json').textContent !== '' && JSON.parse(document.getElementById('json').textContent).parameters.asymmetry === 0.3", "the orbit at another asymmetry")
    assert before != 0.3 and browser.run("explorer.state.at") == at
    # Words, a force, other axes.
    browser.run("""(() => { const words = document.getElementById('words'); words.value = '0+3+,0-3-';
        words.dispatchEvent(new Event('change', { bubbles: true })); })()""")
    browser.until("explorer.state.scene.compute.families.includes('0+3+,0-3-')", "a word")
    browser.until("[...document.getElementById('solution').options].some((one) => one.textContent.startsWith('0+3+'))", "an orbit of the word")
    browser.run("""(() => { const words = document.getElementById('words'); words.value = '';
        words.dispatchEvent(new Event('change', { bubbles: true })); const select = document.getElementById('y-parameter');
        select.value = 'asymmetry'; select.dispatchEvent(new Event('change', { bubbles: true })); })()""")
    browser.until("explorer.state.scene.sweep.y.parameter === 'asymmetry' && document.getElementById('point').hidden", "another axis")
    assert browser.run("typeof explorer.state.scene.model.gamma2") == "number"
    browser.until(IDLE, "tiles over another plane", patience=240)
    shoot(browser, "plane")
    tell("an orbit follows a slider; a word and another axis are taken up")


def survives(browser, explorer, count=int(os.environ.get("PANS", "1000"))):
    """Random pans and zooms: memory of the page and of the program, and nothing left under way."""
    browser.run("document.getElementById('leave').click(); explorer.map.whole()")
    browser.until(IDLE, "the whole map")
    left, top, width, height = rectangle(browser)
    random.seed(1)

    def wander(steps):
        for _ in range(steps):
            x, y = left + random.random() * width, top + random.random() * height
            if random.random() < 0.5:
                browser.mouse("mouseWheel", x, y, deltaX=0, deltaY=random.uniform(-400, 380))
            else:
                browser.mouse("mousePressed", x, y, button="left", clickCount=1)
                browser.mouse("mouseMoved", x + random.uniform(-300, 300), y + random.uniform(-200, 200), button="left", buttons=1)
                browser.mouse("mouseReleased", x, y, button="left", clickCount=1)
            if random.random() < 0.02:
                browser.run("explorer.map.whole()")

    def settle():
        browser.until(IDLE, "rest")
        return browser.heap() / 2**20, explorer.memory()

    # Until as many tiles are kept as ever are.
    browser.run("explorer.map.whole()")
    wander(count // 2)
    page, program = settle()
    wander(count)
    later_page, later_program = settle()
    kept = browser.run("explorer.map.tiles.kept.size")
    tell(f"{count} pans and zooms: the page from {page:.1f} to {later_page:.1f} MB of memory ({kept} tiles kept), the program from {program:.1f} to {later_program:.1f} MB")
    # Tiles are as good as all of the page's memory: it may hold as many as it is allowed to, and no more.
    assert kept <= 701 and later_page < page + 12 and later_program < program + 24
    begun = explorer.busy()
    time.sleep(1.0)
    rest = explorer.busy() - begun
    assert rest < 0.2, f"still {rest} s of work in a second of rest"
    size = browser.run("explorer.map.tiles.pending.size")
    assert size == 0
    tell(f"at rest afterwards: {rest:.2f} s of processor time in a second, no request under way")


def dresses(browser):
    browser.run("explorer.map.whole()")
    browser.until(IDLE, "the whole map")
    ground = "getComputedStyle(document.body).backgroundColor"
    light = browser.run(ground)
    shoot(browser, "light")
    browser.media(prefers_color_scheme="dark")
    dark = browser.run(ground)
    shoot(browser, "dark")
    assert light != dark, "the system's theme is not followed"
    browser.media(prefers_color_scheme="light")
    for expected in (light, dark):
        browser.run("document.getElementById('theme').click()")
        assert browser.run(ground) == expected
    browser.run("document.getElementById('theme').click()")
    # Who does not like motion gets none unasked.
    browser.media(prefers_reduced_motion="reduce", prefers_color_scheme="dark")
    browser.call("Page.reload")
    browser.until("window.explorer !== undefined && " + IDLE, "the page")
    browser.run("explorer.map.choose(0.5, 0.4)")
    browser.until("!document.getElementById('pointbody').hidden", "the orbit")
    time.sleep(0.3)
    assert browser.run("document.getElementById('play').getAttribute('aria-pressed')") == "false"
    shoot(browser, "dark-orbit")
    browser.run("document.getElementById('leave').click()")
    browser.media(prefers_color_scheme="light")
    browser.size(420, 900, scale=2, mobile=True)
    browser.until(IDLE, "tiles of a small screen")
    time.sleep(0.5)
    assert browser.run("document.documentElement.scrollWidth") <= 420, "wider than a small screen"
    shoot(browser, "small")
    browser.size(1400, 900)
    tell("light and dark by system and by switch; no motion unasked where it is not liked; fits a small screen")


def overlays(browser):
    browser.run("explorer.map.whole(); document.getElementById('curves').click()")
    browser.until("explorer.state.over.includes('curves')", "borders", patience=240)
    count = browser.run("explorer.map.lines.length")
    assert count > 5, count
    time.sleep(0.2)
    shoot(browser, "borders")
    words = browser.run("[...document.querySelectorAll('#linekey li')].map((item) => item.textContent)")
    assert len(words) > 2 and "Neimark–Sacker" in words, words
    browser.run("document.getElementById('curves').click()")
    tell(f"{count} borders over the map")


def colours_by_numbers(browser):
    """Each pixel of the map has the colour of its cell's own number, on the scale that the program gives; the key says which."""
    browser.run("explorer.map.whole()")
    browser.until(IDLE, "the whole map")
    seen = 0
    for color in ["spectral_radius", "margin", "solutions"]:
        browser.run(f"(() => {{ const select = document.getElementById('color'); select.value = '{color}'; select.dispatchEvent(new Event('change')); }})()")
        time.sleep(0.1)
        tall = rectangle(browser)[3]
        browser.until(f"explorer.map.scale.is?.color === '{color}' && !document.getElementById('scale').hidden", "a scale")
        browser.until(IDLE, "all tiles")
        time.sleep(0.3)
        # Of a pixel: the number of the cell under it, and its red, green and blue; the scale, and its colours.
        found = browser.run("""(() => {
            const map = explorer.map, { is } = map.scale, s = 2 ** -explorer.state.zoom, list = [];
            for (let k = 0; k < 400; k += 1) {
                const x = (k * 97) % map.canvas.width, y = (k * 61) % map.canvas.height;
                const part = [explorer.state.u - s / 2 + (x + 0.5) / map.canvas.width * s, explorer.state.v - s / 2 + (1 - (y + 0.5) / map.canvas.height) * s];
                const cells = part.map((p) => Math.floor(p * 64 * 2 ** map.z)), tiles = cells.map((c) => Math.floor(c / 64));
                const tile = map.tiles.get(map.z, ...tiles);
                if (!tile) continue;
                const i = (cells[1] - 64 * tiles[1]) * 64 + cells[0] - 64 * tiles[0];
                const number = { spectral_radius: tile.radius[i] - 1, margin: tile.margin[i], solutions: tile.solutions[i] || NaN }[is.color];
                list.push([String(number), [0, 8, 16].map((shift) => (map.pixels[y * map.canvas.width + x] >> shift) & 255)]);
            }
            return { list, is, scale: map.colours.scale, below: map.colours.below, name: document.getElementById("scalename").textContent, ticks: [...document.querySelectorAll("#scaleticks span")].map((tick) => tick.textContent) };
        })()""")
        assert found["name"] == found["is"]["heading"] and found["ticks"] == [text for _, text in found["is"]["ticks"]], found["ticks"]
        bytes_of = lambda rgb: [rgb >> 16, rgb >> 8 & 255, rgb & 255]
        least, most = found["is"]["ends"]
        for text, rgb in found["list"]:
            number = float(text)
            if math.isnan(number):
                assert rgb == [255, 255, 255], (color, text, rgb)
                continue
            number = struct.unpack("f", struct.pack("f", number))[0]
            at = (math.log10(number) if number > 0 else -math.inf) if found["is"]["logarithm"] else number
            if found["is"]["logarithm"] and at < least:
                assert rgb == bytes_of(found["below"]), (color, text, rgb)
                continue
            step = min(1.0, max(0.0, (at - least) / (most - least))) * (len(found["scale"]) - 1)
            near = [bytes_of(found["scale"][n]) for n in {math.floor(step), math.ceil(step)}]
            assert rgb in near, (color, text, rgb, near)
            seen += 1
        shoot(browser, f"by-{color}")
        assert rectangle(browser)[3] == tall, "the key of the scale has moved the map"
    browser.run("(() => { const select = document.getElementById('color'); select.value = 'class'; select.dispatchEvent(new Event('change')); })()")
    browser.until("document.getElementById('scale').hidden", "classes")
    assert seen > 500, seen
    tell(f"coloured by three numbers: {seen} pixels have the colour of their cell's, the key its words")


def takes_along(browser):
    browser.run("document.getElementById('takealong').click()")
    begins = {"scene": "[", "command": "mapgen sweep view.toml", "python": "import vibrochain", "svg": "<svg", "csv": "gamma2,omega,class", "address": "http://127.0.0.1:"}
    for name, begin in begins.items():
        browser.run(f"document.querySelector('[data-take={name}]').click()")
        browser.until(f"document.getElementById('text').value.startsWith({json.dumps(begin)})", name)
    browser.run("document.getElementById('untake').click()")
    tell("scene, command, Python, SVG, CSV and address can be taken along")


explorer = Explorer()
browser = Browser("chromium")
try:
    loads(browser, explorer)
    shoot(browser, "first")
    zooms(browser)
    tiles_are_sweeps(browser)
    orbits_are_printed(browser)
    unnamed(browser)
    keys_suffice(browser, explorer)
    nonsense_is_told(browser)
    dresses(browser)
    clicks_open_what_is_told(browser)
    small_screens(browser)
    fingers(browser)
    takes_along(browser)
    colours_by_numbers(browser)
    overlays(browser)
    survives(browser, explorer)
    follows(browser)
    # What is refused is told to people, and the browser's console has it, too: the wrong values that were typed.
    complaints = [text for text in browser.complaints() if not ("400" in text and text.rstrip().endswith("/view"))]
    assert not complaints, complaints
    hosts = browser.hosts()
    home = "/".join(explorer.address.split("/")[:3])
    assert set(hosts) <= {home, "about:blank"} and home in hosts, hosts
    tell(f"no complaint on the console; nobody was asked but {home.rsplit(':', 1)[0]}")
except BaseException:
    shoot(browser, "failed")
    for text in browser.complaints():
        print("console:", text)
    raise
finally:
    browser.close()
    explorer.close()
print(f"the explorer in a browser: {len(told)} findings, all well")
