#include "experiments/results/recorder.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <exception>
#include <filesystem>
#include <mutex>
#include <thread>
#include <utility>

#include "experiments/results/checkpoint.h"
#include "experiments/results/results_schema.h"
#include "experiments/system/input_file.h"
#include "firn/math.h"

namespace firn {
namespace {

using namespace std::chrono_literals;

constexpr auto kFlushEvery = 1s;                       // what a crash can lose
constexpr std::size_t kQueueLimit = 64 * 1024 * 1024;  // bytes waiting to be written

// Whether a file is a results file, or one whose first block a power failure has lost: that block
// reads as zeros, or the file is empty.
bool may_be_results(const std::string& file) {
  constexpr std::size_t kSize = kHdf5Signature.size();
  std::string start = first_bytes(file, kSize);
  start.resize(kSize, '\0');
  return start == kHdf5Signature || start == std::string(kSize, '\0');
}

// Only then does it go before the file.
bool has_complete_copy(const std::string& file) {
  if (!has_saved_copy(file)) return false;
  try {
    const hdf5::File copy = results::open_file(saved_copy(file), hdf5::File::Access::read);
    return copy.text_attribute("/", "status") == "finished" || !read_checkpoints(copy).empty();
  } catch (const hdf5::Error&) {
    return false;
  }
}

[[noreturn]] void rethrow(const std::string& file, const hdf5::Error& e) {
  if (e.system_error() != 0) throw WriteError(file, e.system_error());
  throw WriteError(file, e.what());
}

}  // namespace

bool recover_results(const ResultsLock& lock) {
  if (!has_complete_copy(lock.file())) return false;
  lock.restore_copy();
  return true;
}

std::string rename_earlier_results(const std::string& file) {
  namespace fs = std::filesystem;
  const fs::path path(file);
  std::error_code error;
  const bool exists = fs::exists(path, error);
  if (exists && !fs::is_regular_file(path, error))
    throw InputError(file + ": is not a regular file; choose another name for the results");
  const bool empty = !exists || fs::file_size(path, error) == 0;
  if (empty && !has_saved_copy(file)) return {};
  if (!empty && !may_be_results(file))
    throw InputError(file + ": exists and is not a results file; choose another name");
  const ResultsLock lock(file);
  if (has_complete_copy(file))
    lock.replace_by_copy();
  else
    lock.remove_copy();
  sync_folder_of(file);  // an earlier copy must not reappear next to the new run
  if (fs::file_size(path, error) == 0) return {};
  for (int i = 1;; ++i) {
    fs::path kept = path;
    kept.replace_filename(
        fmt::format("{}.{}{}", path.stem().string(), i, path.extension().string()));
    if (fs::exists(kept, error)) continue;
    fs::rename(path, kept, error);
    if (error) throw WriteError(file, error.value());
    return kept.string();
  }
}

struct Recorder::Impl {
  Impl(const Lock& held, bool is_new, const std::vector<Column>& columns)
      : name(held->file()),
        lock(held),
        file(is_new ? hdf5::File::create(name)
                    : results::open_file(name, hdf5::File::Access::write)) {
    for (const Column& c : columns) {
      tables.push_back(is_new ? file.create_table(c.path, c.row, c.unit) : file.open_table(c.path));
      std::size_t width = 1;
      for (std::size_t n : c.row) width *= n;
      if (tables.back().row_size() != width) throw hdf5::Error(c.path + " has another row size");
      frame_size += width;
    }
    file.flush();
    writer = std::thread([this] { write_frames(); });
  }

  ~Impl() { stop_writer(); }

  void stop_writer() {
    {
      const std::lock_guard guard(mutex);
      stop = true;
    }
    changed.notify_all();
    if (writer.joinable()) writer.join();
  }

  // The background thread.
  void write_frames() {
    std::unique_lock guard(mutex);
    auto flush_due = std::chrono::steady_clock::time_point::max();  // max: nothing to flush
    const auto wanted = [this] { return stop || !queue.empty(); };
    while (true) {
      if (flush_due == std::chrono::steady_clock::time_point::max())
        changed.wait(guard, wanted);
      else
        changed.wait_until(guard, flush_due, wanted);
      if (stop && queue.empty()) return;
      const std::deque<std::vector<double>> frames = std::exchange(queue, {});
      busy = true;
      guard.unlock();
      std::exception_ptr thrown;
      try {
        append(frames);
        const auto now = std::chrono::steady_clock::now();
        flush_due = std::min(flush_due, now + kFlushEvery);
        if (now >= flush_due) {
          file.flush();
          flush_due = std::chrono::steady_clock::time_point::max();
        }
      } catch (...) {
        thrown = std::current_exception();
      }
      guard.lock();
      busy = false;
      failure = thrown;
      changed.notify_all();
      if (failure) return;
    }
  }

  void append(const std::deque<std::vector<double>>& frames) {
    std::size_t offset = 0;
    std::vector<double> rows;
    for (hdf5::Table& table : tables) {
      rows.clear();
      for (const std::vector<double>& frame : frames) {
        const auto first = frame.begin() + static_cast<std::ptrdiff_t>(offset);
        rows.insert(rows.end(), first, first + static_cast<std::ptrdiff_t>(table.row_size()));
      }
      table.append(rows);
      offset += table.row_size();
    }
  }

  // With the mutex held: waits until the writer is idle and has nothing left to do.
  void drain(std::unique_lock<std::mutex>& guard) {
    changed.wait(guard, [this] { return failure || (queue.empty() && !busy); });
    if (!failure) return;
    try {
      std::rethrow_exception(failure);
    } catch (const hdf5::Error& e) {
      rethrow(name, e);
    }
  }

  std::string name;
  Lock lock;
  hdf5::File file;
  std::vector<hdf5::Table> tables;
  std::size_t frame_size = 0;  // values

  std::mutex mutex;  // guards what follows; the file belongs to the writer while it is busy
  std::condition_variable changed;
  std::deque<std::vector<double>> queue;
  bool busy = false, stop = false;
  std::exception_ptr failure;
  std::thread writer;
};

Recorder::Recorder(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Recorder::~Recorder() = default;
Recorder::Recorder(Recorder&&) noexcept = default;

Recorder Recorder::create(const Lock& lock, const std::vector<Column>& columns) {
  try {
    return Recorder(std::make_unique<Impl>(lock, true, columns));
  } catch (const hdf5::Error& e) {
    rethrow(lock->file(), e);
  }
}

Recorder Recorder::create(const std::string& file, const std::vector<Column>& columns) {
  return create(std::make_shared<ResultsLock>(file), columns);
}

Recorder Recorder::reopen(const Lock& lock, const std::vector<Column>& columns) {
  try {
    return Recorder(std::make_unique<Impl>(lock, false, columns));
  } catch (const hdf5::Error& e) {
    if (e.system_error() != 0) throw WriteError(lock->file(), e.system_error());
    throw InputError(fmt::format("{}: cannot be continued: {}", lock->file(), e.what()));
  }
}

Recorder Recorder::reopen(const std::string& file, const std::vector<Column>& columns) {
  return reopen(std::make_shared<ResultsLock>(file), columns);
}

void Recorder::push(std::vector<double> frame) {
  if (frame.size() != impl_->frame_size)
    throw std::logic_error("a frame has another size than the columns of the recorder");
  std::unique_lock guard(impl_->mutex);
  const std::size_t most =
      std::max<std::size_t>(2, kQueueLimit / (frame.size() * sizeof(double) + 1));
  impl_->changed.wait(guard, [&] { return impl_->failure || impl_->queue.size() < most; });
  if (impl_->failure) impl_->drain(guard);
  impl_->queue.push_back(std::move(frame));
  guard.unlock();
  impl_->changed.notify_all();
}

void Recorder::with_file(const std::function<void(hdf5::File&)>& use) {
  std::unique_lock guard(impl_->mutex);
  impl_->drain(guard);
  try {
    use(impl_->file);
  } catch (const hdf5::Error& e) {
    rethrow(impl_->name, e);
  }
}

const ResultsLock& Recorder::lock() const { return *impl_->lock; }

void Recorder::truncate(std::size_t frames) {
  with_file([&](hdf5::File& file) {
    for (hdf5::Table& table : impl_->tables) {
      if (table.rows() < frames) throw RunError("it has fewer frames than its checkpoint");
      table.truncate(frames);
    }
    // Before the space of the rows that went is used again.
    file.flush();
  });
}

void Recorder::close() {
  with_file([](hdf5::File& file) { file.flush(); });
  impl_->stop_writer();
  impl_->tables.clear();
  with_file([](hdf5::File& file) { file.close(); });
  impl_->lock->require_in_place();
  impl_->lock.reset();
}

}  // namespace firn
