#include "reports/documents/run_page.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <regex>

#include "experiments/case_reader/case_from_results.h"
#include "experiments/case_reader/read_case.h"
#include "experiments/run/run.h"
#include "reports/documents/run_plots.h"
#include "tests/reports/browser.h"
#include "tests/support/replaced.h"
#include "tests/support/scratch_folder.h"

namespace firn {
namespace {

namespace fs = std::filesystem;
// Pages are long: a failure names what is missing, not where.
void expect_in(const std::string& text, const std::string& word) {
  EXPECT_TRUE(text.find(word) != std::string::npos) << word;
}

// Two cubes come one after the other, fall through a gate and onto a floor next to a moving panel.
constexpr const char* kFall = R"(
[case]
name = "two <fall> & \"rest\""
duration = "0.6 s"
timestep = "1e-4 s"
[materials.ice]
density = "1000 kg/m^3"
young_modulus = "0.01 GPa"
[interactions.ice-ice]
static_friction = 0.1
restitution = 0.3
[shapes.cube]
kind = "box"
size = "0.1 0.1 0.1 m"
material = "ice"
[[inlets]]
name = "mold"
shape = "cube"
position = "0 0 0.7 m"
batches = 2
interval = "0.4 s"
[[sensors]]
name = "half way"
point = "0 0 0.4 m"
normal = [0, 0, -1]
[[boundaries]]
name = "floor"
material = "ice"
kind = "plane"
normal = [0, 0, 1]
[[boundaries]]
name = "panel"
material = "ice"
kind = "box"
position = "0.5 0 0.2 m"
size = "0.1 0.3 0.3 m"
motions = [{ kind = "translation", velocity = "0.1 0 0 m/s" }]
[[boundaries]]
name = "wheel"
material = "ice"
kind = "box"
position = "0.9 0 0.2 m"
size = "0.1 0.3 0.3 m"
motions = [{ kind = "rotation", axis = [0, 0, 1], angular_velocity = "-90 deg/s" }]
[output]
frame_interval = "10 ms"
)";

class RunPage : public testing::Test {
 protected:
  void SetUp() override {
    RunOptions options;
    options.results_file = file();
    const RunSummary summary = run(read_case_text(kFall, "fall.toml", "."), options);
    ASSERT_EQ(summary.status, RunStatus::finished) << summary.reason;
  }
  std::string file() const { return folder_ / "fall.h5"; }

  const test::ScratchFolder folder_{"run-page"};
};

TEST_F(RunPage, ShowsWhatWasRunAndWhatCameOut) {
  const std::string html = run_page(file()).html();
  for (const char* word :
       {"seed 1", "finished", "peak_normal_force", "half_way_count", "id=\"replay\"",
        "id=\"replay-data-run\"", "id=\"passages\"", "id=\"energy\"", "id=\"loads-on-boundaries\"",
        "id=\"diagnostics\"", "firn measure fall.h5",
        "duration = ", "<dt>time step</dt><dd>100 us</dd>"})
    expect_in(html, word);
  expect_in(html, "two &lt;fall&gt; &amp; &quot;rest&quot;");
  EXPECT_EQ(html.find("<fall>"), std::string::npos);
}

// The case's own counts first, then facts; a response of zero is no headline.
TEST_F(RunPage, LeadsWithWhatTheCaseIsAbout) {
  const std::string html = run_page(file()).html();
  const std::size_t batches = html.find("mold batches"), sensor = html.find("half way count"),
                    force = html.find("peak normal force"), facts = html.find("simulated time");
  ASSERT_NE(batches, html.npos);
  EXPECT_LT(batches, sensor);
  EXPECT_LT(sensor, force);
  EXPECT_LT(force, facts);
  EXPECT_LT(facts, html.find("id=\"replay\""));
  EXPECT_EQ(html.find("<b>0</b>"), html.npos);
  EXPECT_EQ(html.find("0.29999999999999999"), html.npos);
}

// Cards are sentences that stand alone; why a value is undefined stands only where one is.
TEST_F(RunPage, SaysInWordsWhatItsNumbersAre) {
  const std::string html = run_page(file()).html();
  expect_in(html, "batches that the inlet has inserted");
  expect_in(html, "<dd>2 were inserted, 0 left through outlets</dd>");
  const auto words_of_page = [](const std::string& page) {  // without the scripts
    return page.substr(0, page.find("</main>"));
  };
  EXPECT_EQ(words_of_page(html).find("that came"), std::string::npos);
  expect_in(html, "undefined ones: not passed yet");  // the second cube is on its way
  const std::string text = test::replaced(kFall, "duration = \"0.6 s\"", "duration = \"0.9 s\"");
  RunOptions options;
  options.results_file = folder_ / "long.h5";
  ASSERT_EQ(run(read_case_text(text, "long.toml", "."), options).status, RunStatus::finished);
  EXPECT_EQ(words_of_page(run_page(options.results_file).html()).find("not passed yet"),
            std::string::npos);
}

TEST_F(RunPage, SaysWhatSpoilsShapesAndContacts) {
  EXPECT_EQ(run_page(file()).html().find("likely cause"), std::string::npos);
  const std::string text = test::replaced(test::replaced(kFall, "0.01 GPa", "0.3 MPa"),
                                          "kind = \"box\"", "kind = \"box\"\nrounding = \"8 mm\"");
  RunOptions options;
  options.results_file = folder_ / "soft.h5";
  ASSERT_EQ(run(read_case_text(text, "soft.toml", "."), options).status, RunStatus::finished);
  const std::string html = run_page(options.results_file).html();
  expect_in(html, "shape cube: the contact parts deviate by 5.86 mm");
  expect_in(html, "edges rounded");
  expect_in(html, "likely cause: the stiffness");
}

TEST_F(RunPage, AsksNoNetworkForAnything) {
  const std::string html = run_page(file()).html();
  const std::regex outside(R"re((src|href)\s*=\s*["']?\s*(https?:|//))re");
  std::smatch found;
  EXPECT_FALSE(std::regex_search(html, found, outside)) << found.str();
  expect_in(html, "default-src 'none'");
}

TEST_F(RunPage, LeavesFramesOutToKeepTheBudget) {
  const Recording recording(file());
  const Case c = read_case(recording);
  page::Page whole("whole", ""), small("small", "");
  const ReplaySize all = add_replay(whole, recording, c);
  EXPECT_EQ(all.frames, recording.frame_times().size());
  EXPECT_EQ(all.recorded_frames, all.frames);
  ReplayViewOptions options;
  options.budget = all.characters * 3 / 4;
  const ReplaySize some = add_replay(small, recording, c, options);
  EXPECT_LE(some.characters, options.budget);
  EXPECT_LT(some.frames, all.frames);
  EXPECT_GT(some.frames, 2U);
  expect_in(small.html(), "of the 61 frames");
}

TEST_F(RunPage, ShowsHowFarWhatTurnsHasTurned) {
  const Recording recording(file());
  const std::vector<page::Figure> figures = motion_figures(recording, read_case(recording));
  ASSERT_EQ(figures.size(), 1U);  // the panel only slides
  EXPECT_EQ(figures[0].alt, "angle within one turn against time: wheel at most 54 deg");
}

// A ram that a motor presses onto an anvil, next to the fall.
constexpr const char* kRamOnAnvil = R"(
[[motion_frames]]
name = "slide"
position = "-1 0 0.5 m"
[motion_frames.free]
mass = "0.5 kg"
center = "-1 0 0.5 m"
inertia = "1e-3 1e-3 1e-3 kg m^2"
[[motion_frames.free.joints]]
kind = "translation"
direction = [0, 0, 1]
stiffness = "100 N/m"
damping = "20 N s/m"
friction = "0.5 N"
motors = [{ speed = "-0.5 m/s", max_load = "5 N" }]
[[boundaries]]
name = "ram"
kind = "box"
material = "ice"
size = "0.1 0.1 0.1 m"
position = "-1 0 0.5 m"
motion_frame = "slide"
[[boundaries]]
name = "anvil"
kind = "box"
material = "ice"
size = "0.2 0.2 0.1 m"
position = "-1 0 0.398 m"
[[boundary_contacts]]
between = ["ram", "anvil"]
stiffness = "1e5 N/m"
static_friction = 0.2
restitution = 0.5
)";

TEST_F(RunPage, ShowsAllTermsOfTheBalanceOfFreeBodies) {
  RunOptions options;
  options.results_file = folder_ / "ram.h5";
  const std::string text = test::replaced(kFall, "duration = \"0.6 s\"", "duration = \"0.2 s\"");
  const RunSummary summary = run(read_case_text(text + kRamOnAnvil, "ram.toml", "."), options);
  ASSERT_EQ(summary.status, RunStatus::finished) << summary.reason;
  const std::string alt = energy_figures(Recording(options.results_file)).back().alt;
  expect_in(alt, "energy of free bodies against time: kinetic at most ");
  expect_in(alt, "elastic where parts touch at most ");
  std::size_t curves = 0;
  const std::string word = " at most ";
  for (std::size_t at = 0; (at = alt.find(word, at)) != std::string::npos; at += word.size())
    ++curves;
  EXPECT_EQ(curves, energy_terms(FreeBodyEnergy{}).size()) << alt;
  const std::string html = run_page(options.results_file).html();
  expect_in(html, "<dt>steps without convergence of joints</dt><dd>0</dd>");
  EXPECT_EQ(html.find("energy balance of free bodies"), html.npos);  // no warning
}

TEST_F(RunPage, DrawsSamples) {
  RunOptions options;
  options.results_file = folder_ / "samples.h5";
  const std::string samples = R"(
[[motion_frames]]
name = "cup"
[motion_frames.free]
mass = "1 kg"
center = "0 0 0 m"
inertia = "1 1 1 kg m^2"
[[motion_frames.free.joints]]
kind = "translation"
direction = [1, 0, 0]
stiffness = "100 N/m"
spring_reference = "20 mm"
[output.samples]
interval = "1 ms"
boundaries = ["floor", "panel"]
motion_frames = ["cup"]
)";
  const RunSummary summary = run(read_case_text(kFall + samples, "fall.toml", "."), options);
  ASSERT_EQ(summary.status, RunStatus::finished) << summary.reason;
  const Recording recording(options.results_file);
  const std::vector<page::Figure> figures = sample_figures(recording, read_case(recording));
  // Nothing touches the panel or the cup, which the spring pulls with 100 N/m * 20 mm.
  ASSERT_EQ(figures.size(), 2U);
  expect_in(figures[0].alt, "force of contacts against time: floor at most ");
  expect_in(figures[1].alt, "acceleration against time: cup at most 2 m/s^2");
  expect_in(figures[1].caption, "cup: mean over each sample, not filtered.");
}

TEST_F(RunPage, DrawsMeasuredCurves) {
  RunOptions options;
  options.results_file = folder_ / "curves.h5";
  const std::string curves = R"(
[[measure]]
kind = "curve"
name = "push"
boundary = "floor"
x = "time"
y = "force"
[[measure]]
kind = "curve"
name = "beat"
boundary = "floor"
x = "time"
y = "force"
x_period = "0.2 s"
points = 10
)";
  const Case c = read_case_text(kFall + curves, "fall.toml", ".");
  const RunSummary summary = run(c, options);
  ASSERT_EQ(summary.status, RunStatus::finished) << summary.reason;
  const std::vector<page::Figure> figures = measured_curve_figures(summary.responses, c);
  ASSERT_EQ(figures.size(), 2U);
  expect_in(figures[0].alt, "force against time: at most ");
  expect_in(figures[1].caption, "beat: mean over all passes, and from the least to the largest");
  // A band, which the first one lacks.
  EXPECT_EQ(figures[0].svg.find("fill-opacity"), std::string::npos);
  expect_in(figures[1].svg, "fill-opacity");
  const std::string html = run_page(options.results_file).html();
  expect_in(html, ">Curves</h2>");
}

TEST(RunPlots, DrawingKeepsPeaks) {
  std::vector<double> x, y;
  for (int i = 0; i < 100'000; ++i) {
    x.push_back(i);
    y.push_back(i == 54'321 ? 7 : i == 70'001 ? -3 : 0);
  }
  const Curve c = downsampled_curve(x, y, 600);
  EXPECT_LE(c.x.size(), 601U);
  EXPECT_EQ(c.x.front(), 0);
  EXPECT_EQ(c.x.back(), 99'999);
  EXPECT_TRUE(std::ranges::is_sorted(c.x));
  EXPECT_EQ(c.x[static_cast<std::size_t>(std::ranges::max_element(c.y) - c.y.begin())], 54'321);
  EXPECT_EQ(c.x[static_cast<std::size_t>(std::ranges::min_element(c.y) - c.y.begin())], 70'001);
}

// Colors, hidden boundaries and a particle by the address, then what the page says of itself.
TEST_F(RunPage, PlaysInABrowser) {
  if (!has_browser())
    GTEST_SKIP() << "chromium is not installed: the replay is not tried in a browser";
  const fs::path page = folder_ / "fall.html";
  run_page(file()).write(page.string());
  const std::string view =
      element(document_of(page, "#t=0.5&color=speed&hide=panel&particle=0"), "replay-run");
  expect_in(view, "data-ready=\"yes\"");
  expect_in(view, "data-frames=\"61\"");
  expect_in(view, "data-shown=\"2\"");
  expect_in(view, "in \"half way\"");
  // Center 0.3 m lower: sqrt(2 h / g) = 0.2473 s, looked at every 16 steps.
  expect_in(view, "0.248 s");
}

// Should markup of a file ever reach a page, its scripts do not run: the page names the hashes of
// the scripts of Firn.
TEST(PageInABrowser, RunsNoScriptButItsOwn) {
  if (!has_browser()) GTEST_SKIP() << "chromium is not installed: no script is tried";
  const fs::path folder = test::scratch_path("page with a foreign script");
  fs::create_directories(folder);
  page::Page page("mine", "");
  page.add_script("document.body.dataset.own = 'ran';");
  std::string html = page.html();
  html.insert(html.find("<main"),
              "<script>document.body.dataset.foreign = 'ran';</script>"
              "<img src=x onerror=\"document.body.dataset.foreign = 'ran'\">"
              "<svg onload=\"document.body.dataset.foreign = 'ran'\"></svg>");
  std::ofstream(folder / "page.html") << html;
  const std::string dom =
      output_of("timeout 120 chromium --headless --no-sandbox --user-data-dir='" + folder.string() +
                "/profile' --virtual-time-budget=2000 --dump-dom 'file://" +
                (folder / "page.html").string() + "' 2>/dev/null");
  expect_in(dom, "data-own=\"ran\"");
  EXPECT_EQ(dom.find("data-foreign=\"ran\""), std::string::npos);
  fs::remove_all(folder);
}

}  // namespace
}  // namespace firn
