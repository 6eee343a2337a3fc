// firn view: the server, and its pages in a real browser.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <httplib.h>
#include <signal.h>
#undef _res  // a macro of <resolv.h>, which Eigen uses as a name

#include <chrono>
#include <filesystem>
#include <fstream>
#include <regex>
#include <thread>

#include "experiments/system/input_file.h"
#include "tests/app/pages/browser.h"
#include "tests/app/program.h"
#include "tests/support/phone_layout.h"
#include "tests/support/replaced.h"
#include "tests/support/small_cases.h"

namespace firn::cli {
namespace {

using std::chrono::duration;
using std::chrono::milliseconds;
using std::chrono::steady_clock;
using testing::HasSubstr;
using testing::MatchesRegex;
using testing::Not;

// A running `firn view`, ended by Ctrl-C.
class Viewer {
 public:
  Viewer(const Folder& folder, std::vector<std::string> arguments) : folder_(folder) {
    arguments.insert(arguments.begin(), "view");
    arguments.push_back("--no-open");
    pid_ = folder.start(arguments);
    for (int i = 0; i < 600 && address_.empty(); ++i) {
      std::this_thread::sleep_for(milliseconds(50));
      const std::string out = read_own_file((folder.path() / ".out").string());
      if (out.ends_with("\n")) address_ = out.substr(0, out.size() - 1);
    }
    EXPECT_FALSE(address_.empty()) << read_text(folder.path() / ".err");
  }
  ~Viewer() {
    if (pid_ != 0) end();
  }
  Viewer(const Viewer&) = delete;
  Viewer& operator=(const Viewer&) = delete;

  const std::string& address() const { return address_; }
  // "127.0.0.1:PORT" and "/TOKEN/"
  std::string host() const { return address_.substr(7, address_.find('/', 7) - 7); }
  std::string path() const { return address_.substr(address_.find('/', 7)); }
  httplib::Client client() const { return httplib::Client("http://" + host()); }
  int version() const {
    const auto answer = client().Get(path() + "version");
    return answer ? nlohmann::json::parse(answer->body).at("version").get<int>() : -1;
  }
  // Until another version than `old` is served.
  bool renews(int old, milliseconds within) const {
    const auto until = steady_clock::now() + within;
    while (version() == old) {
      if (steady_clock::now() > until) return false;
      std::this_thread::sleep_for(milliseconds(20));
    }
    return true;
  }
  // Until the first page has been made.
  void wait_for_page() const { EXPECT_TRUE(renews(1, std::chrono::seconds(60))); }

  Outcome end() {
    ::kill(pid_, SIGINT);
    const Outcome outcome = folder_.wait(pid_);
    pid_ = 0;
    return outcome;
  }

 private:
  const Folder& folder_;
  pid_t pid_ = 0;
  std::string address_;
};

TEST(ViewServer, ServesItsPageAlone) {
  const Folder folder;
  folder.write("case.toml", two_boxes);
  const Viewer viewer(folder, {"case.toml"});
  EXPECT_THAT(viewer.address(), MatchesRegex("http://127\\.0\\.0\\.1:[0-9]+/[0-9a-f]+/"));
  EXPECT_EQ(viewer.path().size(), 34u);
  viewer.wait_for_page();

  httplib::Client client = viewer.client();
  const auto page = client.Get(viewer.path());
  ASSERT_TRUE(page);
  EXPECT_EQ(page->status, 200);
  EXPECT_THAT(page->body, HasSubstr("two boxes"));
  EXPECT_EQ(page->get_header_value("Cache-Control"), "no-store");
  EXPECT_EQ(page->get_header_value("X-Frame-Options"), "DENY");
  EXPECT_EQ(page->get_header_value("Cross-Origin-Resource-Policy"), "same-origin");
  EXPECT_FALSE(page->has_header("Access-Control-Allow-Origin"));

  std::string wrong = viewer.path();
  wrong[1] = wrong[1] == '0' ? '1' : '0';
  for (const std::string& path :
       {std::string("/"), std::string("/version"), wrong, viewer.path() + "case.toml",
        viewer.path() + "../case.toml", viewer.path() + "..%2fcase.toml", viewer.path() + "page",
        std::string("//etc/passwd"), viewer.path().substr(0, 33)}) {
    const auto refused = client.Get(path);
    ASSERT_TRUE(refused) << path;
    EXPECT_EQ(refused->status, 404) << path;
    EXPECT_THAT(refused->body, Not(HasSubstr("two boxes"))) << path;
  }
  EXPECT_EQ(client.Post(viewer.path())->status, 405);
  EXPECT_EQ(client.Delete(viewer.path())->status, 405);
  for (const std::string host : {"example.com", "127.0.0.1.example.com", "example.com:80", ""})
    EXPECT_EQ(client.Get(viewer.path(), {{"Host", host}})->status, 403) << host;
  for (const std::string host : {"localhost:9000", "127.0.0.1", "[::1]:80"})  // a forwarded port
    EXPECT_EQ(client.Get(viewer.path(), {{"Host", host}})->status, 200) << host;
  for (const std::string origin : {"http://example.com", "null", "https://127.0.0.1"})
    EXPECT_EQ(client.Get(viewer.path(), {{"Origin", origin}})->status, 403) << origin;
  EXPECT_EQ(client.Get(viewer.path(), {{"Origin", "http://" + viewer.host()}})->status, 200);
}

TEST(ViewServer, IsBoundToLoopback) {
  const Folder folder;
  folder.write("case.toml", two_boxes);
  const Viewer viewer(folder, {"case.toml"});
  const std::string port = viewer.host().substr(viewer.host().find(':') + 1);
  std::stringstream hex;
  hex << std::hex << std::uppercase << std::setfill('0') << std::setw(4) << std::stoi(port);
  // Lines of listening sockets: "sl local_address ...", an address of 0100007F is 127.0.0.1.
  const std::string sockets = read_text("/proc/net/tcp") + read_own_file("/proc/net/tcp6");
  EXPECT_THAT(sockets, HasSubstr(" 0100007F:" + hex.str() + " "));
  EXPECT_THAT(sockets, Not(HasSubstr(" 00000000:" + hex.str() + " ")));
}

TEST(ViewServer, HasAnotherAddressEachTime) {
  const Folder folder;
  folder.write("case.toml", two_boxes);
  std::string first;
  {
    const Viewer viewer(folder, {"case.toml"});
    first = viewer.path();
  }
  const Viewer viewer(folder, {"case.toml"});
  EXPECT_NE(viewer.path(), first);
}

TEST(ViewServer, EndsOnCtrlC) {
  const Folder folder;
  folder.write("case.toml", two_boxes);
  Viewer viewer(folder, {"case.toml"});
  viewer.wait_for_page();
  const auto from = steady_clock::now();
  const Outcome outcome = viewer.end();
  EXPECT_LT(duration<double>(steady_clock::now() - from).count(), 2);
  EXPECT_EQ(outcome.status, 0) << outcome.err;
}

TEST(ViewCommand, RefusesWhatCannotBeShown) {
  const Folder folder;
  folder.write("case.toml", two_boxes);
  const auto refused = [&](const std::vector<std::string>& arguments, const std::string& text) {
    const Outcome outcome = folder.firn(arguments);
    EXPECT_EQ(outcome.status, 2) << text;
    EXPECT_EQ(lines(outcome.err), 1u) << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr(text));
  };
  refused({"view", "gone.h5"}, "gone.h5: does not exist");
  refused({"view", "gone"}, "gone: does not exist");
  refused({"view", "gone.toml"}, "gone.toml: cannot be opened: No such file or directory");
  refused({"view", "gone.h5", "--set", "a=1"}, "--set");
  refused({"view", "case.toml", "--port", "70000"}, "--port");
  refused({"view", "case.toml", "--set", "a"}, "--set");
}

TEST(ViewCommand, FollowsEveryFileOfACase) {
  const Folder folder;
  folder.write("machine.toml", test::replaced(two_boxes, "name = \"two boxes\"", "name = \"x\""));
  folder.write("case.toml",
               "include = \"machine.toml\"\n[case]\nname = \"outer\"\n[shapes.stone]\nkind = "
               "\"mesh\"\nfile = \"stone.stl\"\nlength_unit = \"mm\"\nmaterial = \"ice\"\n");
  const Viewer viewer(folder, {"case.toml"});
  viewer.wait_for_page();
  const auto body = [&] { return viewer.client().Get(viewer.path())->body; };
  EXPECT_THAT(body(), HasSubstr("stone.stl"));  // it is missing
  EXPECT_THAT(body(), HasSubstr("role=\"alert\""));

  const auto after = [&](const std::string& name, const std::string& text) {
    const int version = viewer.version();
    folder.write(name, text);
    EXPECT_TRUE(viewer.renews(version, std::chrono::seconds(10))) << name;
    return body();
  };
  const std::string stone =
      "solid s\nfacet normal 0 0 0\nouter loop\nvertex 0 0 0\nvertex 0 10 0\nvertex 10 0 "
      "0\nendloop\nendfacet\nfacet normal 0 0 0\nouter loop\nvertex 0 0 0\nvertex 10 0 0\nvertex 0 "
      "0 10\nendloop\nendfacet\nfacet normal 0 0 0\nouter loop\nvertex 10 0 0\nvertex 0 10 "
      "0\nvertex 0 0 10\nendloop\nendfacet\nfacet normal 0 0 0\nouter loop\nvertex 0 10 0\nvertex "
      "0 "
      "0 0\nvertex 0 0 10\nendloop\nendfacet\nendsolid s\n";
  const std::string good = after("stone.stl", stone);
  EXPECT_THAT(good, HasSubstr("<h1>outer</h1>"));
  EXPECT_THAT(good, Not(HasSubstr("role=\"alert\"")));
  // The page of the include, of the mesh, of the case, then an error in each.
  EXPECT_THAT(
      after("machine.toml", test::replaced(two_boxes, "name = \"floor\"", "name = \"table\"")),
      HasSubstr("table"));
  EXPECT_THAT(after("stone.stl", test::replaced(stone, "vertex 0 0 10", "vertex 0 0 11")),
              HasSubstr("open edge"));
  EXPECT_THAT(after("stone.stl", stone), Not(HasSubstr("role=\"alert\"")));
  const std::string wrong =
      after("machine.toml", test::replaced(two_boxes, "restitution", "restitutoin"));
  EXPECT_THAT(wrong, HasSubstr("restitutoin"));
  EXPECT_THAT(wrong, HasSubstr("<mark>"));
  EXPECT_THAT(wrong, HasSubstr("aria-label=\"machine.toml about line"));
  EXPECT_THAT(wrong, HasSubstr("<body class=\"alerted outdated\">"));
  EXPECT_THAT(good, HasSubstr("<body>"));
  EXPECT_THAT(wrong, HasSubstr("<h1>outer</h1>"));  // the last good scene
  EXPECT_THAT(wrong, HasSubstr("id=\"replay-data-case\""));
}

TEST(ViewInABrowser, RedrawsACaseAndShowsErrorsAtTheirLine) {
  const Folder folder;
  const std::string good =
      std::string(two_boxes) +
      "[[boundaries]]\nname = \"slider\"\nmaterial = \"plastic\"\nkind = \"box\"\nposition = \"0.1 "
      "0 0.05 m\"\nsize = \"10 10 10 mm\"\nmotions = [{ kind = \"translation\", velocity = \"1 0 0 "
      "m/s\" }]\n[[sensors]]\nname = \"exit\"\npoint = \"0 0 0.01 m\"\nnormal = [0, 0, -1]\n";
  folder.write("case.toml", good);
  const Viewer viewer(folder, {"case.toml"});
  Browser browser;
  browser.open(viewer.address());
  const std::string view = "document.querySelector('.replay')";
  ASSERT_TRUE(browser.becomes(view + "?.dataset.ready === 'yes'"));
  EXPECT_EQ(browser.value(view + ".dataset.shown"), "2");
  EXPECT_TRUE(browser.becomes("document.body.innerText.includes('sensor: exit')"));
  EXPECT_TRUE(browser.becomes("document.body.innerText.includes('motion: slider')"));

  // The keyboard turns the view; what is seen survives a reload.
  browser.value("document.querySelector('.replay canvas').focus()");
  const std::string before = browser.value("FirnReplayViews.states()[0]");
  browser.press("\uE012");  // arrow to the left
  EXPECT_TRUE(browser.becomes("FirnReplayViews.states()[0] !== '" + before + "'"));
  const std::string angle =
      "new URLSearchParams(FirnReplayViews.states()[0]).get('view').split(',')[0]";
  const std::string turned = browser.value(angle);

  const auto saved = steady_clock::now();
  folder.write("case.toml", test::replaced(good, "name = \"slider\"", "name = \"pusher\""));
  ASSERT_TRUE(browser.becomes("document.body.innerText.includes('motion: pusher')"));
  RecordProperty("seconds_to_redraw",
                 std::to_string(duration<double>(steady_clock::now() - saved).count()));
  ASSERT_TRUE(
      browser.becomes("typeof FirnReplayViews !== 'undefined' && FirnReplayViews.states().length"));
  EXPECT_EQ(browser.value(angle), turned);

  folder.write("case.toml", test::replaced(good, "kind = \"plane\"", "kind = \"plan\""));
  ASSERT_TRUE(browser.becomes("document.querySelector('[role=alert] mark')"));
  EXPECT_THAT(
      browser.value("document.querySelector('[role=alert] mark').innerText").get<std::string>(),
      HasSubstr("kind = \"plan\""));
  ASSERT_TRUE(browser.becomes(view + "?.dataset.ready === 'yes'"));
  // Next to the last good scene, which is dimmed: file and line, reached by the keyboard.
  EXPECT_THAT(
      browser.value("document.querySelector('[role=alert] p').innerText").get<std::string>(),
      HasSubstr("case.toml:36: "));
  EXPECT_THAT(
      browser.value("document.querySelector('[role=alert] mark').innerText").get<std::string>(),
      HasSubstr("36 > kind"));
  EXPECT_LT(
      browser.value("Number(getComputedStyle(document.querySelector('.replay canvas')).opacity)")
          .get<double>(),
      0.6);
  const std::string alert = "document.querySelector('[role=alert]')",
                    scene = "document.querySelector('.replay canvas')";
  const auto both_in_sight = [&] {
    browser.value("scrollTo(0, " + scene + ".getBoundingClientRect().top + scrollY - 400)");
    return browser.becomes(alert + ".getBoundingClientRect().top >= 0 && " + alert +
                           ".getBoundingClientRect().bottom <= innerHeight && " + scene +
                           ".getBoundingClientRect().top < innerHeight");
  };
  EXPECT_TRUE(both_in_sight());
  EXPECT_EQ(browser.value(alert + ".tabIndex"), 0);
  browser.resize(500, 900);
  browser.value(test::set_phone_width);
  EXPECT_TRUE(both_in_sight());
  EXPECT_LE(browser.value("document.body.scrollWidth").get<int>(), 400);
  browser.resize(1200, 1000);
  folder.write("case.toml", good);
  ASSERT_TRUE(browser.becomes("!document.querySelector('[role=alert]')"));

  ASSERT_TRUE(browser.becomes(view + "?.dataset.ready === 'yes'"));
  browser.resize(500, 900);
  EXPECT_TRUE(browser.becomes(
      "document.documentElement.scrollWidth <= document.documentElement.clientWidth"))
      << browser.value("document.documentElement.scrollWidth");
  EXPECT_EQ(browser.console_errors(), "");
}

// The list shows a boundary in the scene and its name, a click in the scene names it in the list,
// and a key shows all names.
TEST(ViewInABrowser, NamesBoundaries) {
  const Folder folder;
  folder.write("case.toml", std::string(two_boxes) +
                                "[[boundaries]]\nname = \"slider\"\nmaterial = \"plastic\"\nkind = "
                                "\"box\"\nposition = \"0.06 0 0.02 m\"\nsize = \"40 40 40 mm\"\n");
  const Viewer viewer(folder, {"case.toml"});
  Browser browser;
  browser.open(viewer.address());
  ASSERT_TRUE(browser.becomes("document.querySelector('.replay')?.dataset.ready === 'yes'"));
  EXPECT_EQ(browser.value("document.querySelector('.replay-legend').textContent"), "");  // one kind
  const std::string names =
      "[...document.querySelectorAll('.replay-labels span')].map((s) => s.textContent).join()";
  const std::string entry = "document.querySelectorAll('.replay-list label')[1]";
  EXPECT_EQ(browser.value(names), "");
  browser.value(entry + ".dispatchEvent(new MouseEvent('mouseenter'))");
  EXPECT_TRUE(browser.becomes(names + " === 'slider'"));
  EXPECT_EQ(browser.value(entry + ".className"), "replay-strong");
  browser.value(entry + ".dispatchEvent(new MouseEvent('mouseleave'))");
  EXPECT_TRUE(browser.becomes(names + " === ''"));

  const std::string found = browser.value(R"((() => {
      const canvas = document.querySelector('.replay canvas'), box = canvas.getBoundingClientRect(), found = new Set();
      HTMLElement.prototype.setPointerCapture = () => {};  // a pointer that does not exist cannot be captured
      for (let k = 0; k < 900; ++k) {
        const at = {pointerId: 1, clientX: box.left + box.width * (k % 30 + 0.5) / 30,
                    clientY: box.top + box.height * (Math.floor(k / 30) + 0.5) / 30, bubbles: true};
        canvas.dispatchEvent(new PointerEvent('pointerdown', at));
        canvas.dispatchEvent(new PointerEvent('pointerup', at));
        found.add(document.querySelector('.replay-here').value);
      }
      return [...found].sort().join();
    })())");
  EXPECT_THAT(found, HasSubstr("Here: floor,Here: slider"));
  browser.value("document.querySelector('.replay canvas').focus()");
  browser.press("\uE00C");  // Escape
  EXPECT_TRUE(browser.becomes(names + " === ''"));
  EXPECT_EQ(browser.value("document.querySelector('.replay-here').value"), "");
  browser.press("n");
  EXPECT_TRUE(browser.becomes(names + " === 'floor,slider'"));
  EXPECT_EQ(browser.console_errors(), "");
}

TEST(ViewInABrowser, FollowsARunToItsEnd) {
  const Folder folder;
  folder.write("case.toml",
               test::replaced(two_boxes, "duration = \"50 ms\"", "duration = \"2 s\""));
  // Held back, so that the page is there before the end.
  const pid_t run = folder.start({"run", "case.toml", "-o", "run.h5"});
  for (int i = 0; i < 200 && !folder.contains("run.h5"); ++i)
    std::this_thread::sleep_for(milliseconds(20));
  ::kill(run, SIGSTOP);
  const Viewer viewer(folder, {"run.h5"});
  Browser browser;
  browser.open(viewer.address());
  ASSERT_TRUE(browser.becomes("document.readyState === 'complete'"));
  ::kill(run, SIGCONT);
  ASSERT_TRUE(
      browser.becomes("document.body.innerText.includes('finished')", std::chrono::seconds(120)));
  ASSERT_TRUE(browser.becomes("document.querySelector('.replay')?.dataset.ready === 'yes'"));
  EXPECT_EQ(browser.value("document.querySelector('.replay').dataset.frames"), "202");
  int status = 0;
  ::waitpid(run, &status, 0);
  EXPECT_EQ(status, 0);
  EXPECT_EQ(browser.console_errors(), "");
}

// Its cubes fall in from above the view: the picture before Play is that of the heap.
TEST(ViewInABrowser, BeginsWithParticlesInViewAndPlaysFromTheStart) {
  const Folder folder;
  ASSERT_EQ(folder.firn({"new", "s", "--from", "own-study"}).status, 0);
  ASSERT_EQ(folder.firn({"run", "s/case.toml", "-o", "run.h5", "-q"}).status, 0);
  const Viewer viewer(folder, {"run.h5"});
  Browser browser;
  browser.open(viewer.address());
  ASSERT_TRUE(browser.becomes("document.querySelector('.replay')?.dataset.ready === 'yes'"));
  const std::string clock = "parseFloat(document.querySelector('.replay-clock').value)";
  EXPECT_TRUE(browser.becomes(clock + " > 1"));
  EXPECT_EQ(browser.value("document.querySelector('.replay').dataset.shown"), "64");
  browser.value("document.querySelector('.replay-bar button').click()");
  EXPECT_TRUE(browser.becomes(clock + " < 0.5"));
  EXPECT_EQ(browser.console_errors(), "");
}

TEST(ViewInABrowser, FollowsAStudyToItsEnd) {
  const Folder folder;
  ASSERT_EQ(folder.firn({"new", "s", "--from", "own-study"}).status, 0);
  const std::string study = (std::filesystem::path(folder.path()) / "s/study.toml").string();
  const std::string runs = (std::filesystem::path(folder.path()) / "runs").string();
  const pid_t calibration = folder.start({"calibrate", study, "-o", runs, "--jobs", "1"});
  for (int i = 0; i < 200 && !folder.contains("runs/study.db"); ++i)
    std::this_thread::sleep_for(milliseconds(20));
  const Viewer viewer(folder, {runs});
  Browser browser;
  browser.open(viewer.address());
  EXPECT_TRUE(browser.becomes("document.body.innerText.includes('study is running')",
                              std::chrono::seconds(30)));
  // One run at least, and then the end.
  EXPECT_TRUE(
      browser.becomes("document.body.innerText.includes('design')", std::chrono::seconds(300)));
  ::kill(calibration, SIGINT);
  int status = 0;
  ::waitpid(calibration, &status, 0);
  EXPECT_TRUE(browser.becomes("document.body.innerText.includes('study is not running')",
                              std::chrono::seconds(30)));
  browser.resize(500, 900);  // as a phone: tables scroll by themselves
  browser.value(test::set_phone_width);
  EXPECT_EQ(browser.value(std::string(test::outside_of_phone) + ".length"), 0);
  EXPECT_EQ(browser.console_errors(), "");
}

}  // namespace
}  // namespace firn::cli
