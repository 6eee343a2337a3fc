#include "experiments/results/results_lock.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <vector>

namespace firn {
namespace {

namespace fs = std::filesystem;

constexpr const char* kSaved = ".saved";
constexpr const char* kUnfinished = ".saving";  // a copy that is not whole yet
constexpr std::size_t kBlock = 1 << 20;         // bytes copied at a time

// Calls `write(data, size)` with all bytes of a file. Throws WriteError when it cannot be read.
template <class Write>
void each_block(int from, const std::string& name, Write&& write) {
  std::vector<char> block(kBlock);
  for (off_t offset = 0;;) {
    const ssize_t size = ::pread(from, block.data(), block.size(), offset);
    if (size < 0 && errno == EINTR) continue;
    if (size < 0) throw WriteError(name, fmt::format("cannot be copied: {}", errno_text(errno)));
    if (size == 0) return;
    write(block.data(), static_cast<std::size_t>(size));
    offset += size;
  }
}

}  // namespace

std::string saved_copy(const std::string& results_file) { return results_file + kSaved; }

bool has_saved_copy(const std::string& results_file) {
  std::error_code unreadable;  // as a name that is too long
  return fs::exists(saved_copy(results_file), unreadable);
}

ResultsLock::ResultsLock(const std::string& file) : file_(file) {
  struct flock whole = {};
  whole.l_type = F_WRLCK;
  whole.l_whence = SEEK_SET;
  do {  // again when the file was renamed between the two calls
    descriptor_ = Descriptor(::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666));
    if (descriptor_.number() < 0) refuse_output(file, errno);
    if (::fcntl(descriptor_.number(), F_OFD_SETLK, &whole) != 0 &&
        (errno == EAGAIN || errno == EACCES))
      throw InputError(file + ": another run is writing this file");
  } while (!in_place());
}

bool ResultsLock::in_place() const {
  struct stat locked = {}, named = {};
  return ::fstat(descriptor_.number(), &locked) == 0 && ::stat(file_.c_str(), &named) == 0 &&
         locked.st_dev == named.st_dev && locked.st_ino == named.st_ino;
}

void ResultsLock::require_in_place() const {
  if (!in_place()) throw WriteError(file_, "it was removed or replaced while the run wrote it");
}

void ResultsLock::save_copy() const {
  std::error_code error;  // the write reports the error
  if (const fs::path folder = fs::path(file_).parent_path(); !folder.empty())
    fs::create_directories(folder, error);
  try {
    OutputFile copy(saved_copy(file_), OutputFile::When::at_commit, file_ + kUnfinished);
    each_block(descriptor_.number(), file_, [&](const char* data, std::size_t size) {
      copy.write(data, static_cast<std::streamsize>(size));
    });
    copy.commit();
  } catch (const OutputPathError& e) {  // the folder was fine when the run began
    throw WriteError(saved_copy(file_), e.error);
  }
}

void ResultsLock::replace_by_copy() const {
  if (::rename(saved_copy(file_).c_str(), file_.c_str()) != 0) throw WriteError(file_, errno);
  sync_folder_of(file_);
}

// In place: a kill leaves the copy, from which the next one restores again.
void ResultsLock::restore_copy() const {
  const std::string copy = saved_copy(file_);
  const Descriptor from(::open(copy.c_str(), O_RDONLY | O_CLOEXEC));
  if (from.number() < 0)
    throw WriteError(file_, fmt::format("{} cannot be read: {}", copy, errno_text(errno)));
  const int to = descriptor_.number();
  if (::ftruncate(to, 0) != 0 || ::lseek(to, 0, SEEK_SET) != 0) throw WriteError(file_, errno);
  each_block(from.number(), copy,
             [&](const char* data, std::size_t size) { write_all(to, data, size, file_); });
}

void ResultsLock::remove_copy() const {
  sync_file(descriptor_.number(), file_);
  remove_if_there(file_ + kUnfinished);
  remove_if_there(saved_copy(file_));
}

}  // namespace firn
