// Extreme numbers in every key of a case: a few sane steps, or a refusal.
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <random>
#include <sstream>

#include "experiments/case_reader/read_case.h"
#include "experiments/results/results_file.h"
#include "experiments/run/run.h"
#include "experiments/text/toml_document.h"
#include "tests/app/robustness/hostile_inputs.h"
#include "tests/support/error_of.h"
#include "tests/support/read_text.h"
#include "tests/support/results_folder.h"

namespace firn {
namespace {

// A quantity is text that begins with a number: "20 mm", "0 0 1 m/s".
bool is_quantity(const std::string& text) {
  return !text.empty() && std::string("0123456789.+-").find(text.front()) != std::string::npos;
}

void collect(toml::node& node, std::vector<toml::node*>& all) {
  if (toml::table* table = node.as_table()) {
    for (auto&& [key, value] : *table) collect(value, all);
  } else if (toml::array* array = node.as_array()) {
    for (toml::node& element : *array) collect(element, all);
  } else if (node.is_number() || (node.is_string() && is_quantity(node.as_string()->get()))) {
    all.push_back(&node);
  }
}

// Another number for the n-th one of a quantity, whose unit stays.
std::string with_number(const std::string& quantity, const std::string& number, unsigned n) {
  std::istringstream in(quantity);
  std::vector<std::string> words;
  std::size_t numbers = 0;
  for (std::string word; in >> word;) {
    words.push_back(word);
    if (numbers + 1 == words.size() && is_quantity(word)) ++numbers;
  }
  if (numbers == 0) return number;
  words[n % numbers] = number;
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : " ") + word;
  return text;
}

class ExtremeValues : public ResultsFolder {
 protected:
  // One number of the case replaced. Returns whether the case was taken.
  bool attempt(const std::string& text, std::mt19937_64& random) {
    toml::table document = toml::parse(text);
    std::vector<toml::node*> numbers;
    collect(document, numbers);
    toml::node& node = *numbers[random() % numbers.size()];
    static const std::vector<std::string> extremes = {
        "0",     "-1",    "1e-320", "1e-300", "1e-200", "1e-100", "1e-30", "1e-15",
        "1e-12", "1e-9",  "1e-6",   "1e6",    "1e9",    "1e12",   "9e13",  "1e15",
        "1e18",  "2e19",  "1e30",   "1e60",   "1e100",  "1e200",  "1e308", "-1e-300",
        "-1e-9", "-1e12", "-1e308", "0.999",  "1",      "3"};
    static const std::int64_t whole[] = {0,
                                         -1,
                                         1,
                                         2,
                                         1000,
                                         2147483646,
                                         2147483647,
                                         2147483648,
                                         1 << 30,
                                         1'000'000'000,
                                         std::numeric_limits<std::int64_t>::max(),
                                         std::numeric_limits<std::int64_t>::min()};
    const std::string& extreme = extremes[random() % extremes.size()];
    if (auto* quantity = node.as_string())
      *quantity = with_number(quantity->get(), extreme, static_cast<unsigned>(random()));
    else if (auto* integer = node.as_integer())
      *integer = whole[random() % std::size(whole)];
    else
      *node.as_floating_point() = std::stold(extreme);
    std::ostringstream changed;
    changed << document;
    SCOPED_TRACE(changed.str());
    const auto begin = std::chrono::steady_clock::now();
    const bool taken = run_a_little(changed.str());
    const double seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    EXPECT_LT(seconds, 60);
    return taken;
  }

  bool run_a_little(const std::string& text) {
    try {
      const Case c = read_case_text(text, "case.toml", path("."));
      std::atomic<bool> stop = false;
      RunOptions o = options("run.h5");
      std::filesystem::remove(o.results_file);
      o.interrupt = &stop;
      std::uint64_t steps = 0;
      o.each_step = [&](const Solver& solver, bool) {
        steps = solver.steps();
        if (steps >= 10) stop = true;
        for (std::size_t i = 0; i < solver.particles().position.size(); ++i)
          EXPECT_TRUE(solver.particles().position[i].allFinite());
      };
      const RunSummary s = run(c, o);
      if (s.status == RunStatus::failed) {
        EXPECT_NE(s.reason, "");
      } else {
        EXPECT_GT(s.simulated, 0);
      }
      return true;
    } catch (const InputError& error) {
      const std::string said = error.what();
      EXPECT_EQ(said.find('\n'), said.npos);
      EXPECT_LT(said.size(), 1000u);
      return false;
    }
  }

  void attempts(int count, unsigned seed) {
    std::vector<std::string> cases = {cli::hostile::rich_case};
    for (const char* name : {"scene", "small_drain", "bonds", "two_boxes"})
      cases.push_back(test::read_text(FIRN_SOURCE_DIR "/tests/fuzz/corpus/case/" +
                                      std::string(name) + ".toml"));
    std::mt19937_64 random(seed);
    int taken = 0;
    for (int i = 0; i < count; ++i) {
      taken += attempt(cases[random() % cases.size()], random);
      if (HasFailure()) return;
    }
    EXPECT_GT(taken, count / 20);
    EXPECT_LT(taken, count - count / 20);
  }
};

TEST_F(ExtremeValues, RunAFewStepsOrAreRefused) { attempts(150, 3); }

using ExtremeValuesLong = ExtremeValues;
TEST_F(ExtremeValuesLong, RunAFewStepsOrAreRefused) { attempts(5000, 17); }

// What was found.
TEST_F(ExtremeValues, TimeAdvances) {
  const std::string base = cli::hostile::rich_case;
  const auto refusal = [&](const std::string& key, const std::string& value) {
    const std::string message = test::error_if_any([&] {
      read_case_text(base, "case.toml", path("."), {{key, value}});
    });
    return message.empty() ? "accepted" : message;
  };
  const auto expect = [&](const std::string& key, const std::string& value, const char* said) {
    EXPECT_NE(refusal(key, value).find(said), std::string::npos) << refusal(key, value);
  };
  expect("case.duration", "9e13 s", "\"9e13 s\" is beyond 1000000000 s");
  expect("case.timestep", "1e-300 s", "expected a time of at least 1e-12 s");
  expect("case.timestep", "1e-12 s", "accepted");
  expect("case.duration", "1e9 s", "steps; expected at most 1e+12");
  expect("case.duration", "1 ns", "shorter than the time step");
  expect("stages.settle.max_duration", "1 ns", "shorter than the time step");
  expect("case.timestep", "1 s", "shorter than the time step");
}

// A frame interval beyond the end: the first and the last frame.
TEST_F(ExtremeValues, FramesBeyondTheEndAreTheFirstAndTheLast) {
  for (const char* every : {"1 h", "1e9 s", "4.1 ms"}) {
    const Case c = read_case_text(cli::hostile::rich_case, "case.toml", path("."),
                                  {{"output.frame_interval", every}});
    const RunSummary s = run(c, options("frames.h5"));
    ASSERT_EQ(s.status, RunStatus::finished) << s.reason;
    EXPECT_EQ(Recording(path("frames.h5")).frame_times().size(), 2u) << every;
  }
}

}  // namespace
}  // namespace firn
