#include "experiments/system/interruption.h"

#include <fmt/format.h>
#include <semaphore.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <mutex>
#include <thread>
#include <vector>

#include "experiments/system/terminal.h"

namespace firn::interruption {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int kStatus = 130;
constexpr auto kPause = std::chrono::milliseconds(10);
// Time for the work to reach its next check of the flag, and to return after it has saved.
constexpr auto kPatience = std::chrono::milliseconds(1200);

std::atomic<bool> interrupted = false;
static_assert(std::atomic<bool>::is_always_lock_free, "set from a signal handler");
std::atomic<bool> ending = false;
std::atomic<int> polled = 0, not_polled = 0;
sem_t arrived;  // of this process alone: a forked child that gets a signal does not post it

struct Registry {
  std::recursive_mutex mutex;
  std::vector<std::string> temporary, advice;
};

// Never destroyed: the watching thread may use it while the program ends.
Registry& registry() {
  static auto* const all = new Registry;
  return *all;
}

void on_signal(int) {
  const int before = errno;
  interrupted = true;
  sem_post(&arrived);
  errno = before;
}

// Other threads may add a file to a folder while it is removed.
void remove_from_others(const std::string& path) {
  constexpr int kAttempts = 100;
  std::error_code error;
  for (int k = 0; k < kAttempts; ++k) {
    std::filesystem::remove_all(path, error);
    if (!error) return;
  }
}

[[noreturn]] void end_at_once() {
  Registry& all = registry();
  ending = true;
  const std::lock_guard lock(all.mutex);
  for (const std::string& path : all.temporary) remove_from_others(path);
  print_lines(stderr, "firn: interrupted{}\n",
              all.advice.empty() ? "" : fmt::format("; {}", all.advice.back()));
  _exit(kStatus);
}

// Ends the program unless the work under way saves and returns.
void watch() {
  while (sem_wait(&arrived) != 0) {
  }
  if (polled == 0) end_at_once();
  for (Clock::time_point until = Clock::now() + kPatience; Clock::now() < until;) {
    if (polled > 0 && not_polled == 0) until = Clock::now() + kPatience;
    std::this_thread::sleep_for(kPause);
  }
  end_at_once();
}

}  // namespace

void install() {
  sem_init(&arrived, 0, 0);
  registry();
  std::thread(watch).detach();
  struct sigaction action = {};
  action.sa_handler = on_signal;
  action.sa_flags = static_cast<int>(SA_RESETHAND);  // the second one has its usual effect
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
}

const std::atomic<bool>& requested() { return interrupted; }

Polled::Polled() { ++polled; }
Polled::~Polled() { --polled; }
NotPolled::NotPolled() { ++not_polled; }
NotPolled::~NotPolled() { --not_polled; }

Uninterrupted::Uninterrupted() { registry().mutex.lock(); }
Uninterrupted::~Uninterrupted() { registry().mutex.unlock(); }

void wait_for_end() {
  while (ending) std::this_thread::sleep_for(kPause);
}

Temporary::Temporary(std::string path) : path_(std::move(path)) {
  Registry& all = registry();
  const std::lock_guard lock(all.mutex);
  all.temporary.push_back(path_);
}

void Temporary::keep() {
  Registry& all = registry();
  const std::lock_guard lock(all.mutex);
  const auto mine = std::ranges::find(all.temporary, path_);
  if (mine != all.temporary.end()) all.temporary.erase(mine);
}

Advice::Advice(const std::string& text) : text_(text) {
  Registry& all = registry();
  const std::lock_guard lock(all.mutex);
  all.advice.push_back(text_);
}

// Advice that was given earlier may end earlier.
Advice::~Advice() {
  Registry& all = registry();
  const std::lock_guard lock(all.mutex);
  const auto mine = std::find(all.advice.rbegin(), all.advice.rend(), text_);
  if (mine != all.advice.rend()) all.advice.erase(std::next(mine).base());
}

}  // namespace firn::interruption
