"""The report looked at and clicked in headless Chromium, from disk and with no network."""

import shutil

import pytest

import phblocks as ph

pytestmark = pytest.mark.browser

SORTED = "() => [...document.querySelectorAll(`#ledger tbody tr`)].map(r => Number(r.cells[1].dataset.value))"


@pytest.fixture(scope="module")
def path(four_bar, tmp_path_factory):
    solution = ph.simulate(four_bar().compile(), t_end=1.0, dt=0.02)
    return solution.report(tmp_path_factory.mktemp("report") / "x.html")


@pytest.fixture(scope="module")
def browser():
    from playwright.sync_api import sync_playwright  # an error without the extra: this is run on purpose

    with sync_playwright() as playwright:
        chromium = playwright.chromium.launch(executable_path=shutil.which("chromium"), args=["--no-sandbox"])
        yield chromium
        chromium.close()


@pytest.fixture
def page(browser, path):
    """The page; whatever the console says, or is asked of the network, fails the test."""
    context = browser.new_context(viewport={"width": 900, "height": 900}, offline=True)
    opened, said, asked = context.new_page(), [], []
    opened.on("console", lambda message: message.type == "error" and said.append(message.text))
    opened.on("pageerror", lambda error: said.append(str(error)))
    opened.on("request", lambda request: asked.append(request.url))
    opened.goto(path.as_uri())
    yield opened
    assert said == []
    assert asked == [path.as_uri()]
    context.close()


def ink(page):
    """How many pixels of the animation are not white, and a number that changes with the picture."""
    return page.evaluate("""() => {
        const c = document.getElementById("stage");
        const d = c.getContext("2d").getImageData(0, 0, c.width, c.height).data;
        let inked = 0, sum = 0;
        for (let i = 3; i < d.length; i += 4) if (d[i]) { inked += 1; sum = (sum + i * d[i - 1]) % 1000003; }
        return [inked, sum];
    }""")


def wait_until(page, condition):
    """Look again and again: Playwright's own waiting is forbidden by the page's content security policy."""
    for _ in range(500):
        if condition():
            return
        page.wait_for_timeout(20)
    raise AssertionError("nothing happened for ten seconds")


def test_slider(page):
    first = ink(page)
    assert first[0] > 1000
    page.locator("#time").fill("25")
    assert page.locator("#clock").text_content() == "t = 0.500 s"
    assert page.locator("#stage").get_attribute("data-frame") == "25"
    assert ink(page) != first


def test_play_and_pause(page):
    button = page.locator("#play")
    button.click()
    assert button.text_content() == "Pause"
    wait_until(page, lambda: int(page.locator("#time").input_value()) > 5)
    button.click()
    assert button.text_content() == "Play"
    stopped = page.locator("#time").input_value()
    page.wait_for_timeout(150)
    assert page.locator("#time").input_value() == stopped != "0"
    page.locator("#speed").select_option("4")
    button.click()
    wait_until(page, lambda: button.text_content() == "Play")
    assert page.locator("#time").input_value() == "50"


def test_trails(page):
    page.locator("#time").fill("40")
    with_trails = ink(page)[0]
    page.locator("#trails").uncheck()
    assert ink(page)[0] < with_trails


def test_tables_sort(page):
    before = page.evaluate(SORTED)
    heading = page.locator("#ledger th button").nth(1)
    heading.click()
    assert page.evaluate(SORTED) == sorted(before)
    heading.click()
    assert page.evaluate(SORTED) == sorted(before, reverse=True)
    assert page.locator("#ledger th").nth(1).get_attribute("aria-sort") == "descending"


def test_nothing_is_wider_than_the_window(page):
    assert page.evaluate("document.documentElement.scrollWidth <= window.innerWidth")


def test_names_are_never_code(browser, bar, tmp_path):
    name = "</script><img src=x onerror=window.hit=1><script>window.hit=1</script>"
    d = ph.Diagram(name)
    beam = d.add(ph.Beam("<b onclick=alert(1)>", bar, (0.0, 0.0), (1.0, 0.0), elements=2))
    d.pin(beam.start, d.ground)
    page = browser.new_page()
    page.goto(ph.simulate(d.compile(), t_end=0.1, dt=0.05).report(tmp_path / "x.html").as_uri())
    page.wait_for_timeout(100)
    assert page.evaluate("window.hit") is None
    assert page.locator("h1").text_content() == name
    assert page.locator("img, b").count() == 0
