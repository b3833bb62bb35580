// The page of a run as its reader has it: clicks, keys, dark and narrow, with texts that try to
// become markup. Screenshots stay in the folder that INSITU_SCREENSHOTS names, if it does.
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <gtest/gtest.h>
#include <iostream>
#include <memory>

#include "api/runs/coupled.h"
#include "browser.h"
#include "output/files/json_text.h"
#include "output/image/png.h"
#include "output/page/run_page.h"

namespace {

using insitu::output::JsonText;
using insitu::output::RunPage;

const std::string hostile = "</script><img src=x onerror=\"window.hacked=1\">' \u2028\" &amp;";

const std::string scene = R"(
insitu: 1
probes:
  - {name: gauges, points: {line: {from: [0.1, 0.1, 0.1], to: [0.9, 0.9, 0.9], count: 40}}, every: 2}
  - {name: "odd & 'x' #1%", points: [[0.1, 0.1, 0.1], [9, 9, 9]], every: 2}
tracers:
  - {name: drifters, velocity: velocity, seeds: {sphere: {center: [0.4, 0.4, 0.4], radius: 0.3, count: 300}},
     until: {duration: 0.1}, every: 2}
frames:
  - {name: "blast #1", size: [200, 160], volume: {field: density}, scalar_bar: true, time_label: true, every: 4}
  - {name: shells, size: [200, 160], isosurfaces: [{field: pressure, values: [0.05]}], every: 8}
  - {name: fails, volume: {field: "<b>no</b> such"}, every: 10}
)";

constexpr int cycles = 24;

class PageInBrowser : public testing::Test {
protected:
  static void SetUpTestSuite() {
    const std::string program = test::find_chromium();
    if (program.empty())
      return;
    folder_ = std::make_unique<test::Folder>();
    browser_ = std::make_unique<test::Browser>(program);
    runs::Coupled run({.scene = scene, .output = folder_->path()});
    run.mesh.cell_field(hostile, run.solver.pressure);
    (void)run.execute();
    while (run.solver.cycle() < cycles)
      (void)run.step(); // one frame fails
    run.session.close();
  }
  static void TearDownTestSuite() {
    browser_.reset();
    folder_.reset();
  }
  void SetUp() override {
    if (!browser_)
      GTEST_SKIP() << "no chromium on this machine";
    browser().size(1280, 900);
    browser().dark(false);
    browser().open(*folder_ / "index.html");
  }

  static test::Browser& browser() { return *browser_; }
  static std::string where() { return browser().text("document.getElementById('where').value"); }
  static std::string source(int image = 0) {
    return browser().text("document.querySelectorAll('#frames img')[" + std::to_string(image) +
                          "].getAttribute('src')");
  }
  static void keep(const std::string& name) {
    if (const char* folder = std::getenv("INSITU_SCREENSHOTS"))
      browser().screenshot(std::string(folder) + "/" + name);
  }

  static std::unique_ptr<test::Folder> folder_;
  static std::unique_ptr<test::Browser> browser_;
};
std::unique_ptr<test::Folder> PageInBrowser::folder_;
std::unique_ptr<test::Browser> PageInBrowser::browser_;

TEST_F(PageInBrowser, ShowsTheRunAndFetchesNothingElse) {
  EXPECT_EQ(browser().text("document.title"), "Run of scene");
  EXPECT_EQ(browser().text("document.getElementById('state').textContent"),
            "Finished, with 3 failures");
  for (const char* id : {"frames", "messages", "probes", "particles", "cost", "plan", "files"})
    EXPECT_TRUE(
        browser().evaluate("!document.getElementById('" + std::string(id) + "').hidden").as<bool>())
        << id;
  EXPECT_TRUE(browser().wait("[...document.images].every((i) => i.naturalWidth === 200)"));
  EXPECT_EQ(browser().evaluate("document.querySelectorAll('.plot path').length > 10").as<bool>(),
            true);
  EXPECT_EQ(where(),
            browser().text("`cycle 24, time ${formatNumber(insitu.at(-1).time)} (7 of 7)`"));
  for (const std::string& address : browser().requests)
    EXPECT_TRUE(address.starts_with("file://" + folder_->path()) || address == "data:,") << address;
  EXPECT_GE(browser().requests.size(), 4u); // the page, run.js, two images
  for (const std::string& problem : browser().problems)
    ADD_FAILURE() << problem;
  keep("light.png");
}

TEST_F(PageInBrowser, TheSliderObeysMouseAndKeys) {
  browser().click("#slider", 0);
  EXPECT_TRUE(where().starts_with("cycle 0,")) << where();
  EXPECT_EQ(source(0), "blast%20%231_000000.png");
  EXPECT_EQ(source(1), "shells_000000.png");
  EXPECT_TRUE(browser().wait("document.images[0].naturalWidth === 200")) << "a name with # and %";
  browser().press("ArrowRight"); // the slider has the focus
  EXPECT_TRUE(where().starts_with("cycle 4,")) << where();
  EXPECT_EQ(source(0), "blast%20%231_000004.png");
  EXPECT_EQ(source(1), "shells_000000.png") << "the last one before it";
  EXPECT_EQ(browser().text("document.querySelectorAll('figcaption')[1].textContent"),
            "shells, of cycle 0");
  browser().press("End");
  EXPECT_TRUE(where().starts_with("cycle 24,")) << where();
  browser().click("#slider", 0.5);
  EXPECT_TRUE(where().starts_with("cycle 12,")) << where();
  browser().click("#previous");
  EXPECT_TRUE(where().starts_with("cycle 8,")) << where();
  browser().click("#next");
  EXPECT_TRUE(where().starts_with("cycle 12,")) << where();
  browser().click("h1"); // nothing has the focus: the keys move the frames
  browser().press("ArrowLeft");
  EXPECT_TRUE(where().starts_with("cycle 8,")) << where();
  browser().press("Home");
  EXPECT_TRUE(where().starts_with("cycle 0,")) << where();
  browser().press("ArrowLeft");
  EXPECT_TRUE(where().starts_with("cycle 0,")) << where();
  EXPECT_TRUE(browser().problems.empty()) << browser().problems.front();
}

TEST_F(PageInBrowser, PlaysToTheEndAndPauses) {
  browser().evaluate("document.getElementById('speed').value = 25");
  browser().click("#play"); // at the end: from the start
  EXPECT_EQ(browser().text("document.getElementById('play').ariaLabel"), "Pause");
  EXPECT_TRUE(browser().wait("document.getElementById('slider').value > 1"));
  EXPECT_TRUE(browser().wait("document.getElementById('play').ariaLabel === 'Play'"));
  EXPECT_TRUE(where().starts_with("cycle 24,")) << where();
  browser().evaluate("document.getElementById('speed').value = 2");
  browser().click("#play");
  EXPECT_TRUE(browser().wait("document.getElementById('slider').value > 0"));
  browser().click("#play");
  const std::string stopped = where();
  EXPECT_FALSE(browser().wait("document.getElementById('where').value !== '" + stopped + "'", 0.8));
}

TEST_F(PageInBrowser, TextsOfTheSolverStayTexts) {
  EXPECT_EQ(browser().evaluate("window.hacked === undefined").as<bool>(), true);
  EXPECT_EQ(browser().evaluate("document.images.length").as<int>(), 2);
  EXPECT_EQ(browser().evaluate("document.querySelectorAll('b').length").as<int>(), 0);
  EXPECT_EQ(browser().evaluate("document.querySelectorAll('script').length").as<int>(), 2);
  EXPECT_EQ(browser()
                .evaluate("[...document.querySelectorAll('#probes select')[0].options].some((o) => "
                          "o.textContent === " +
                          JsonText().value(hostile).text() + ")")
                .as<bool>(),
            true);
  EXPECT_NE(
      browser().text("document.getElementById('messages').textContent").find("<b>no</b> such"),
      std::string::npos);
}

TEST_F(PageInBrowser, PlotsAreChosenAndReadByKeys) {
  const std::string first = "document.querySelector('#probes .plot')";
  EXPECT_TRUE(browser().text(first + ".ariaLabel").starts_with("density of gauges: 13 values"))
      << browser().text(first + ".ariaLabel");
  EXPECT_EQ(browser().text("document.querySelector('#probes .note').textContent"),
            "16 of 40 points; the table has all");
  const std::string curves =
      "document.querySelector('#probes .card').querySelectorAll('.curve').length";
  EXPECT_EQ(browser().evaluate(curves).as<int>(), 5);
  browser().click("#probes .legend button:nth-child(2)");
  EXPECT_EQ(browser().evaluate(curves).as<int>(), 6);
  browser().evaluate("(() => { const s = document.querySelector('#probes select'); s.value = "
                     "'pressure'; s.dispatchEvent(new Event('change')); })()");
  EXPECT_TRUE(browser().text(first + ".ariaLabel").starts_with("pressure of gauges"));
  EXPECT_EQ(browser().evaluate(curves).as<int>(), 6) << "the chosen points stay";
  browser().evaluate(first + ".focus()");
  browser().press("Home");
  EXPECT_EQ(browser().text("document.querySelector('#probes .readout').textContent"),
            "cycle 0, time 0");
  browser().press("ArrowRight");
  EXPECT_TRUE(browser()
                  .text("document.querySelector('#probes .readout').textContent")
                  .starts_with("cycle 2,"));
  EXPECT_TRUE(where().starts_with("cycle 24,")) << "the frames stay where they were";
  browser().press("Enter");
  EXPECT_TRUE(where().starts_with("cycle 0,")) << "the nearest frame: " << where();
  browser().evaluate("(() => { const s = document.getElementById('axis'); s.value = 'time'; "
                     "s.dispatchEvent(new Event('change')); })()");
  EXPECT_NE(browser().text(first + ".ariaLabel").find("from time 0 to"), std::string::npos);
  EXPECT_TRUE(browser().problems.empty()) << browser().problems.front();
}

// WCAG 2.1: contrast of at least 4.5 for text; names for all controls; no sideways scrolling at 320
// pixels.
TEST_F(PageInBrowser, CanBeReadInTheDarkAndOnAPhone) {
  const std::string contrast = R"((() => {
    const light = (c) => { const [r, g, b] = c.match(/[\d.]+/g).map((v) => { v /= 255;
      return v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4; });
      return 0.2126 * r + 0.7152 * g + 0.0722 * b; };
    const ground = (e) => { for (; e; e = e.parentElement) {
      const c = getComputedStyle(e).backgroundColor; if (c !== 'rgba(0, 0, 0, 0)') return c; } };
    let least = 100;
    for (const e of document.querySelectorAll('h1, h2, p, td, th, a, figcaption, .note, label, .legend button')) {
      if (!e.checkVisibility()) continue;
      const a = light(getComputedStyle(e).color), b = light(ground(e));
      least = Math.min(least, (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05));
    }
    return least; })())";
  EXPECT_GE(browser().evaluate(contrast).as<double>(), 4.5);
  EXPECT_EQ(browser().text("getComputedStyle(document.body).backgroundColor"),
            "rgb(255, 255, 255)");
  browser().dark(true);
  EXPECT_GE(browser().evaluate(contrast).as<double>(), 4.5);
  EXPECT_EQ(browser().text("getComputedStyle(document.body).backgroundColor"), "rgb(20, 23, 28)");
  keep("dark.png");
  EXPECT_EQ(browser()
                .evaluate("[...document.querySelectorAll('button, select, input, [role=img], "
                          "section, img')].filter((e) => !(e.ariaLabel || e.textContent.trim() || "
                          "e.alt || e.labels?.length)).length")
                .as<int>(),
            0)
      << "controls without a name";
  browser().dark(false);
  browser().size(320, 640);
  browser().open(*folder_ / "index.html");
  EXPECT_LE(browser().evaluate("document.documentElement.scrollWidth").as<int>(), 320)
      << browser().text("[...document.querySelectorAll('main *')].filter((e) => "
                        "e.getBoundingClientRect().right > 320).map((e) => e.outerHTML.slice(0, "
                        "80)).join(' | ')");
  EXPECT_TRUE(browser().wait("document.images[0].naturalWidth === 200"));
  keep("narrow.png");
  browser().click("#slider", 0);
  EXPECT_TRUE(where().starts_with("cycle 0,")) << where();
}

TEST_F(PageInBrowser, IsDrawn) {
  ASSERT_TRUE(browser().wait("[...document.images].every((i) => i.naturalWidth === 200)"));
  const std::string shot = *folder_ / "shot.png";
  browser().size(1280, 900);
  browser().screenshot(shot);
  const insitu::output::PngImage image = insitu::output::read_png(shot);
  ASSERT_EQ(image.width, 1280);
  ASSERT_GE(image.height, 900);
  // The first frame stands on the page as it stands in its file, scaled by nothing.
  const YAML::Node box = browser().evaluate("(() => { scrollTo(0, 0); const b = "
                                            "document.images[0].getBoundingClientRect(); return "
                                            "[b.left, b.top, b.width, b.height]; })()");
  const insitu::output::PngImage frame = insitu::output::read_png(*folder_ / "blast #1_000024.png");
  ASSERT_EQ(box[2].as<double>(), frame.width);
  // The middle, away from the rounded corners; the place may be a fraction of a pixel off.
  const int x0 = int(box[0].as<double>() + 0.5), y0 = int(box[1].as<double>() + 0.5);
  long sum = 0, background = 0;
  for (int y = 40; y < 120; ++y)
    for (int x = 40; x < 160; ++x)
      for (int c = 0; c < 3; ++c) {
        sum += std::abs(int(image.pixel(x0 + x, y0 + y)[c]) - int(frame.pixel(x, y)[c]));
        background += std::abs(int(image.pixel(2, 2)[c]) - int(frame.pixel(x, y)[c]));
      }
  EXPECT_LT(sum * 10, background) << "the frame is not to be seen";
}

TEST_F(PageInBrowser, OfAKilledRunShowsWhatCameBefore) {
  const test::Folder folder;
  {
    RunPage page(folder.path(), 0);
    page.add(
        R"({"cycle":0,"time":0,"executions":1,"wall":1,"seconds":[0,0,0,0,0],"bytes":[],"peak":0})");
  }
  const std::string whole = test::content(folder / "run.js");
  test::put(folder / "run.js", whole + "//situ.push({\"cycle\":1,\"ti");
  browser().open(folder / "index.html");
  EXPECT_EQ(browser().evaluate("insitu.length").as<int>(), 1);
  EXPECT_NE(browser().text("document.getElementById('state').textContent").find("Not finished"),
            std::string::npos);
  EXPECT_TRUE(browser().problems.empty()) << browser().problems.front();
  std::filesystem::remove(folder / "run.js");
  browser().open(folder / "index.html");
  EXPECT_NE(browser().text("document.getElementById('notice').textContent").find("run.js"),
            std::string::npos);
}

TEST_F(PageInBrowser, FollowsARunThatGoesOn) {
  const test::Folder folder;
  RunPage page(folder.path(), 0);
  const auto add = [&](int cycle) {
    page.add("{\"cycle\":" + std::to_string(cycle) +
             R"(,"time":0,"executions":1,"wall":1,"seconds":[0,0,0,0,0],"bytes":[],"peak":0})");
  };
  add(0);
  browser().open(folder / "index.html");
  browser().click("#follow");
  add(1);
  add(2);
  EXPECT_TRUE(
      browser().wait("document.getElementById('summary').textContent.startsWith('cycles 0 to 2')"));
  EXPECT_TRUE(browser().problems.empty()) << browser().problems.front();
}

TEST_F(PageInBrowser, OfALongRunIsShownSoon) {
  const test::Folder folder;
  constexpr int entries = 50'000;
  {
    RunPage page(folder.path(), 0);
    for (int i = 0; i < entries; ++i) {
      JsonText j;
      j.open('{').key("cycle").value(i).key("time").value(0.1 * i);
      if (i == 0)
        j.key("session").raw(R"({"scene":"s","started":"","library":"","threads":1,"tables":[],)"
                             R"("endings":["alive","left"],"purposes":["tree","build"]})");
      j.key("executions").value(1).key("wall").value(0.01);
      j.key("seconds").raw("[0.001,0.002,0.001,0.003,0.0005]").key("bytes").raw("[1000000,2000]");
      j.key("peak").value(2000000);
      j.key("tracers").raw(R"([{"name":"t","seeded":100,"endings":[90,10]}])").key("probes");
      j.raw(R"([{"name":"p","total":2,"all_columns":1,"columns":["a"],"points":[{"point":0,"at":)"
            R"([0,0,0]},{"point":1,"at":[1,1,1]}],"values":[[)" +
            std::to_string(i % 997) + "],[" + std::to_string(i % 13) + "]]}]");
      j.key("frames").raw(R"([{"name":"f","kind":"color","file":"f.png"}])").close();
      page.add(j.text());
    }
  }
  const auto begin = std::chrono::steady_clock::now();
  browser().open(folder / "index.html");
  EXPECT_EQ(browser().evaluate("document.querySelectorAll('.curve').length").as<int>(), 2);
  const double seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  std::cout << entries << " entries, "
            << double(std::filesystem::file_size(folder / "run.js")) / 1e6 << " MB: shown in "
            << seconds << " s\n";
  EXPECT_LT(seconds, 20.0); // about 1 s on an idle machine
  browser().press("Home");
  EXPECT_TRUE(where().starts_with("cycle 0,")) << where();
}

} // namespace
