#include "experiments/recorder.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <condition_variable>
#include <cstring>
#include <deque>
#include <exception>
#include <filesystem>
#include <fstream>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include "experiments/checkpoint.h"
#include "solver/types.h"

namespace firn {
namespace {

using namespace std::chrono_literals;

constexpr auto kFlushEvery = 1s;                       // what a crash can lose
constexpr std::size_t kQueueLimit = 64 * 1024 * 1024;  // bytes waiting to be written

// Keeps a second writer away for as long as it lives. A lock of the open file description: readers,
// HDF5's own locks and other descriptors of this process do not meet it.
class WriteLock {
 public:
  explicit WriteLock(const std::string& file)
      : descriptor_(::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666)) {
    if (descriptor_ < 0)
      throw InputError(fmt::format("{}: cannot be written: {}", file, std::strerror(errno)));
    struct flock whole = {};
    whole.l_type = F_WRLCK;
    whole.l_whence = SEEK_SET;
    if (::fcntl(descriptor_, F_OFD_SETLK, &whole) != 0 && (errno == EAGAIN || errno == EACCES)) {
      ::close(descriptor_);
      throw InputError(file + ": another run is writing this file");
    }
  }
  WriteLock(const WriteLock&) = delete;
  WriteLock& operator=(const WriteLock&) = delete;
  ~WriteLock() { ::close(descriptor_); }

 private:
  int descriptor_;
};

bool is_hdf5(const std::string& file) {
  std::ifstream stream(file, std::ios::binary);
  char signature[8] = {};
  stream.read(signature, sizeof(signature));
  return std::string_view(signature, sizeof(signature)) == std::string_view("\x89HDF\r\n\x1a\n", 8);
}

}  // namespace

void recover_results(const std::string& file) {
  if (!has_kept_copy(file)) return;
  std::optional<WriteLock> nobody_writes;  // or its file would be taken from under it
  std::error_code unreadable;              // as a name that is too long
  if (std::filesystem::exists(file, unreadable)) nobody_writes.emplace(file);
  restore_kept_copy(file);
}

std::string keep_earlier_results(const std::string& file) {
  namespace fs = std::filesystem;
  const fs::path path(file);
  std::error_code error;
  if (!fs::exists(path, error)) return {};
  if (!fs::is_regular_file(path, error))
    throw InputError(file + ": is not a regular file; choose another name for the results");
  if (fs::file_size(path, error) == 0) return {};
  if (!is_hdf5(file))
    throw InputError(file + ": exists and is not a results file; choose another name");
  const WriteLock nobody_writes(file);
  for (int i = 1;; ++i) {
    fs::path kept = path;
    kept.replace_filename(
        fmt::format("{}.{}{}", path.stem().string(), i, path.extension().string()));
    if (fs::exists(kept, error)) continue;
    fs::rename(path, kept, error);
    if (error)
      throw InputError(
          fmt::format("{}: cannot be kept as {}: {}", file, kept.string(), error.message()));
    return kept.string();
  }
}

struct Recorder::Impl {
  Impl(const std::string& path, bool is_new, const std::vector<Column>& columns)
      : name(path),
        lock(std::make_unique<WriteLock>(path)),
        file(is_new ? hdf5::File::create(path)
                    : hdf5::File::open(path, hdf5::File::Access::write)) {
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
    } catch (const std::exception& e) {
      throw WriteError(fmt::format("results file {}: {}", name, e.what()));
    }
  }

  std::string name;
  std::unique_ptr<WriteLock> lock;
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

Recorder Recorder::create(const std::string& file, const std::vector<Column>& columns) {
  try {
    return Recorder(std::make_unique<Impl>(file, true, columns));
  } catch (const hdf5::Error& e) {
    throw InputError(fmt::format("{}: cannot be written: {}", file, e.what()));
  }
}

Recorder Recorder::reopen(const std::string& file, const std::vector<Column>& columns) {
  try {
    return Recorder(std::make_unique<Impl>(file, false, columns));
  } catch (const hdf5::Error& e) {
    throw InputError(fmt::format("{}: cannot be gone on with: {}", file, e.what()));
  }
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
    throw WriteError(fmt::format("results file {}: {}", impl_->name, e.what()));
  } catch (const std::filesystem::filesystem_error& e) {  // the copy of a checkpoint
    throw WriteError(fmt::format("results file {}: {}", impl_->name, e.what()));
  }
}

void Recorder::truncate(std::size_t frames) {
  with_file([&](hdf5::File& file) {
    for (hdf5::Table& table : impl_->tables) {
      if (table.rows() < frames) throw hdf5::Error("it has fewer frames than its checkpoint");
      table.truncate(frames);
    }
    // Before the space of the rows that went is used again.
    file.flush();
  });
}

void Recorder::close() {
  with_file([](hdf5::File&) {});
  impl_->stop_writer();
  impl_->tables.clear();
  with_file([](hdf5::File& file) { file.close(); });
  impl_->lock.reset();
}

}  // namespace firn
