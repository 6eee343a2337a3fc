// Reaction to Ctrl-C and SIGTERM. Code that can save its state polls requested() during the
// lifetime of a `Polled`, saves and returns. At all other times the program removes its temporary
// files and exits at once with status 130. A second signal kills the program.
#pragma once

#include <atomic>
#include <string>

namespace firn::interruption {

// Installs the handlers of SIGINT and SIGTERM. To be called once, in main(). Without the call,
// signals keep their default effect, and the classes below have none.
void install();

// True after a signal.
const std::atomic<bool>& requested();

// During the lifetime of an object, the caller polls requested() at least once per second, and
// saves and returns after a signal.
class Polled {
 public:
  Polled();
  ~Polled();
  Polled(const Polled&) = delete;
  Polled& operator=(const Polled&) = delete;
};

// A long section within the lifetime of a `Polled` that does not poll and has nothing to save.
class NotPolled {
 public:
  NotPolled();
  ~NotPolled();
  NotPolled(const NotPolled&) = delete;
  NotPolled& operator=(const NotPolled&) = delete;
};

// During its lifetime the program does not exit at once. Used from before the creation of a file to
// its registration as a Temporary: an exit in between would leave the file. Nests within a thread.
class Uninterrupted {
 public:
  Uninterrupted();
  ~Uninterrupted();
  Uninterrupted(const Uninterrupted&) = delete;
  Uninterrupted& operator=(const Uninterrupted&) = delete;
};

// Does not return while the program exits at once. To be called before an error is reported: the
// removal of temporary files can cause errors in other threads.
void wait_for_end();

// A file, or a folder with its contents, that is removed if the program exits at once.
class Temporary {
 public:
  explicit Temporary(std::string path);
  ~Temporary() { keep(); }
  Temporary(const Temporary&) = delete;
  Temporary& operator=(const Temporary&) = delete;
  void keep();  // ends the registration; the file is not removed

 private:
  std::string path_;
};

// Text that is printed at such an exit: "everything finished is kept in runs/a: the same command
// resumes".
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
