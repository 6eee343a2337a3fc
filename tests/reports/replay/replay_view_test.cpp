// Replays: maps of where bodies are hit, several on a page, fingers.
#include "reports/replay/replay_view.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "experiments/case_reader/case_from_results.h"
#include "experiments/case_reader/read_case.h"
#include "experiments/run/run.h"
#include "tests/reports/browser.h"
#include "tests/support/results_folder.h"

namespace firn {
namespace {

// A cube falls on a slab; both are monitored.
constexpr const char* kHit = R"(
[case]
name = "hit"
duration = "0.3 s"
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
position = "0.06 0.06 0.2 m"
[[boundaries]]
name = "slab"
material = "ice"
kind = "box"
position = "0 0 -0.05 m"
size = "0.4 0.4 0.1 m"
[statistics.boundary_maps]
boundaries = ["slab"]
edge = "5 cm"
interval = "0.1 s"
wear_coefficient = 1e-4
hardness = "50 MPa"
[statistics.particle_maps]
edge = "5 cm"
[output]
frame_interval = "10 ms"
)";

class ReplayPage : public ResultsFolder {
 protected:
  void SetUp() override {
    ResultsFolder::SetUp();
    RunOptions o = options("hit.h5");
    const RunSummary summary = run(read_case_text(kHit, "hit.toml", "."), o);
    ASSERT_EQ(summary.status, RunStatus::finished) << summary.reason;
  }
  // A page with so many replays of the run, "one", "two" ..., and what a test does in it. The end
  // of `script` writes its findings to the document's title.
  std::string written(int replays, const std::string& script) const {
    const Recording recording(path("hit.h5"));
    const Case c = read_case(recording);
    page::Page page("replays", "");
    for (int i = 1; i <= replays; ++i)
      add_replay_view(page, page.section(fmt::format("Replay {}", i)),
                      {fmt::format("n{}", i), fmt::format("run {}", i)}, recording, c);
    if (!script.empty()) page.add_script(script);
    page.write(path("page.html"));
    return path("page.html");
  }
  static std::string title_of(const std::string& dom) {
    const std::size_t begin = dom.find("<title>") + 7;
    return dom.substr(begin, dom.find("</title>") - begin);
  }
};

TEST_F(ReplayPage, MapsAreColoredAndTheirScalesShown) {
  if (!has_browser()) GTEST_SKIP() << "chromium is not installed: maps are not drawn";
  const std::string file = written(1, "");
  const std::string slab = element(document_of(file, "#t=0.2&map=peak_stress&log=1"), "replay-n1");
  EXPECT_NE(slab.find("Of the whole run: largest"), std::string::npos);
  EXPECT_NE(slab.find("Pa; "), std::string::npos);
  EXPECT_NE(slab.find("triangles touched, the others gray"), std::string::npos);
  const std::string cube = element(document_of(file, "#shape=cube&map=contacts"), "replay-n1");
  EXPECT_NE(cube.find("per triangle: largest"), std::string::npos);
}

TEST_F(ReplayPage, TheLargestIsFoundAndItsBoundaryShown) {
  if (!has_browser()) GTEST_SKIP() << "chromium is not installed: maps are not drawn";
  const std::string dom = document_of(written(1, R"(
const root = document.querySelector('.replay');
const look = () => {
  if (root.dataset.ready !== 'yes' || !root.querySelector('.replay-map select option:checked').value) {
    return setTimeout(look, 20);
  }
  [...root.querySelectorAll('button')].find((b) => b.textContent === 'Go to the largest').click();
  document.title = root.querySelector('output.replay-note').value.replace(/[0-9.]+ .?Pa/, 'V') + ' | ' +
      root.querySelector('.replay-list input').checked;
};
setTimeout(look, 500);
)"),
                                      "#t=0.2&map=peak_stress&hide=slab");
  EXPECT_EQ(title_of(dom), "Here, on \"slab\": V | true");
}

TEST_F(ReplayPage, OfSeveralOnlyTheLastThreeAreLive) {
  if (!has_browser()) GTEST_SKIP() << "chromium is not installed: replays are not opened";
  const std::string dom = document_of(written(4, R"(
const all = [...document.querySelectorAll('.replay')], found = [];
const ready = (root) => new Promise((done) => {
  const look = () => root.dataset.ready === 'yes' ? done() : setTimeout(look, 20);
  look();
});
(async () => {
  found.push(all.map((root) => root.querySelectorAll('canvas').length).join(''));
  for (const root of all) {
    root.querySelector('button').click();
    await ready(root);
  }
  found.push(all.map((root) => root.querySelectorAll('canvas').length).join(''));
  found.push(all[0].querySelector('button').textContent);
  location.hash = 'replay=n1&t=0.1';
  await ready(all[0]);
  found.push(all.map((root) => root.querySelectorAll('canvas').length).join(''));
  document.title = found.join(' | ');
})();
)"));
  EXPECT_EQ(title_of(dom), "0000 | 0111 | Show again the replay of run 1 (0.1 MB) | 1011");
}

// As fingers do it: one turns, two move and come near, and before the first tap one that goes up or
// down is the page's.
TEST_F(ReplayPage, FingersTurnMoveAndComeNear) {
  if (!has_browser()) GTEST_SKIP() << "chromium is not installed: fingers are not tried";
  const std::string dom = document_of(written(1, R"(
const root = document.querySelector('.replay');
HTMLElement.prototype.setPointerCapture = () => {};  // fingers that do not exist cannot be captured
const view = () => {
  [...root.querySelectorAll('button')].find((b) => b.textContent.includes('link') ||
      b.textContent === 'Copied').click();
  return new URLSearchParams(location.hash.slice(1)).get('view').split(',').map(Number);
};
const finger = (type, id, x, y) => root.querySelector('canvas').dispatchEvent(new PointerEvent(type,
    {pointerId: id, pointerType: 'touch', isPrimary: id === 1, clientX: x, clientY: y, bubbles: true,
     buttons: type === 'pointerup' ? 0 : 1}));
const look = () => {
  if (root.dataset.ready !== 'yes') return setTimeout(look, 20);
  const canvas = root.querySelector('canvas'), action = () => getComputedStyle(canvas).touchAction;
  const found = [action()], begin = view();
  finger('pointerdown', 1, 100, 100);
  finger('pointermove', 1, 100, 160);
  finger('pointercancel', 1, 100, 160);  // as when the browser scrolls
  found.push(view()[1] === begin[1] ? 'the page scrolls' : 'not', document.activeElement === canvas ? 'held' : 'free');
  finger('pointerdown', 1, 100, 100);
  finger('pointermove', 1, 160, 100);
  finger('pointerup', 1, 160, 100);
  const turned = view();
  found.push(turned[0] < begin[0] ? 'turned' : 'not', turned[2] === begin[2] ? 'as far' : 'not');
  found.push(document.activeElement === canvas ? action() : 'not in hand');
  finger('pointerdown', 1, 100, 100);
  finger('pointerdown', 2, 200, 100);
  finger('pointermove', 2, 300, 100);
  finger('pointerup', 2, 300, 100);
  finger('pointerup', 1, 100, 100);
  const near = view();
  found.push(Math.abs(2 * near[2] / turned[2] - 1) < 0.01 ? 'twice as near' : 'not');
  found.push(near[0] === turned[0] ? 'not turned' : 'turned', near[3] !== turned[3] ? 'moved' : 'not');
  document.title = found.join(' | ');
};
look();
)"));
  EXPECT_EQ(title_of(dom),
            "pan-y | the page scrolls | free | turned | as far | none | twice as near | not turned "
            "| moved");
}

}  // namespace
}  // namespace firn
