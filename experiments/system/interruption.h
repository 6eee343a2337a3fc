// What Ctrl-C and SIGTERM do. Work that can save its state looks at a flag while it holds a
// `Polled`, saves and returns. At any other time nothing is to be saved: the program removes its
// temporary files and ends at once with status 130. A second signal kills.
#pragma once

#include <atomic>
#include <string>

namespace firn::interruption {

// Handles SIGINT and SIGTERM from now on; in main(), once. Programs that do not call it keep the
// usual effect of signals, and all below does nothing.
void install();

const std::atomic<bool>& requested();

// The work under way looks at requested() at least every second, saves and returns.
class Polled {
 public:
  Polled();
  ~Polled();
  Polled(const Polled&) = delete;
  Polled& operator=(const Polled&) = delete;
};

// A part of such work that takes long, looks at nothing and has nothing to save.
class NotPolled {
 public:
  NotPolled();
  ~NotPolled();
  NotPolled(const NotPolled&) = delete;
  NotPolled& operator=(const NotPolled&) = delete;
};

// While it lives, the program is not ended at once. Holds from before a file is created until it is
// registered as a Temporary: a signal in between would leave it behind. Nests within a thread.
class Uninterrupted {
 public:
  Uninterrupted();
  ~Uninterrupted();
  Uninterrupted(const Uninterrupted&) = delete;
  Uninterrupted& operator=(const Uninterrupted&) = delete;
};

// Does not return when the program is being ended at once: the end of the work that its removed
// files have caused must not come first.
void wait_for_end();

// A file, or a folder with all it holds, that is removed if the program is ended at once.
class Temporary {
 public:
  explicit Temporary(std::string path);
  ~Temporary() { keep(); }
  Temporary(const Temporary&) = delete;
  Temporary& operator=(const Temporary&) = delete;
  void keep();  // from now on

 private:
  std::string path_;
};

// What the user can do then: "everything finished is kept in runs/a: the same command resumes".
class Advice {
 public:
  explicit Advice(const std::string& text);
  ~Advice();
  Advice(const Advice&) = delete;
  Advice& operator=(const Advice&) = delete;

 private:
  std::string text_;
};

}  // namespace firn::interruption
