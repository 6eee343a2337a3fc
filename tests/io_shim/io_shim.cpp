// Stands between a program and the system calls that change files (LD_PRELOAD). Only files below
// the folder FIRN_IO_FOLDER are concerned. All processes of a test share one count.
//
//   FIRN_IO_COUNT=FILE        8 bytes, mapped: the number of calls so far; must exist
//   FIRN_IO_FAIL=K:ERRNO:N    calls K to K + N - 1 (from 1) do nothing and fail with ERRNO
//   FIRN_IO_SIGNAL=K:SIGNAL   the process gets the signal before its call K
//   FIRN_IO_LOG=FILE          one record a successful call, read by
//                             tests/app/robustness/io_faults.cpp
#include <dlfcn.h>
#include <fcntl.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <climits>
#include <cstdarg>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <mutex>
#include <string>

namespace {

template <class Function>
Function* real(const char* name) {
  return reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name));
}

int open_real(const char* path, int flags, mode_t mode) {
  static auto* const call = real<int(const char*, int, ...)>("open");
  return call(path, flags, mode);
}

ssize_t write_real(int file, const void* data, std::size_t size) {
  static auto* const call = real<ssize_t(int, const void*, std::size_t)>("write");
  return call(file, data, size);
}

struct Settings {
  std::string folder;  // with a slash at its end
  std::atomic<std::uint64_t>* count = nullptr;
  std::uint64_t fail_from = 0, fail_until = 0;
  std::uint64_t signal_at = 0;
  int error = 0, signal = 0;
  int log = -1;
  std::mutex mutex;  // one record at a time, in the order of the calls

  Settings() {
    const char* text = std::getenv("FIRN_IO_FOLDER");
    if (text == nullptr) return;
    if (const char* name = std::getenv("FIRN_IO_COUNT")) {
      const int file = open_real(name, O_RDWR | O_CLOEXEC, 0);
      void* bytes = mmap(nullptr, 8, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
      if (file < 0 || bytes == MAP_FAILED) std::abort();
      count = static_cast<std::atomic<std::uint64_t>*>(bytes);
      ::close(file);
    }
    if (const char* fail = std::getenv("FIRN_IO_FAIL")) {
      unsigned long long first = 0, calls = 0;
      if (std::sscanf(fail, "%llu:%d:%llu", &first, &error, &calls) != 3) std::abort();
      fail_from = first;
      fail_until = first + calls;
    }
    if (const char* text_of_signal = std::getenv("FIRN_IO_SIGNAL")) {
      unsigned long long at = 0;
      if (std::sscanf(text_of_signal, "%llu:%d", &at, &signal) != 2) std::abort();
      signal_at = at;
    }
    if (const char* name = std::getenv("FIRN_IO_LOG"))
      log = open_real(name, O_WRONLY | O_APPEND | O_CREAT | O_CLOEXEC, 0600);
    folder = std::string(text) + "/";
  }
};

Settings& settings() {
  static Settings& all = *new Settings;  // for calls after the end of main, too
  return all;
}

std::string absolute(const char* path) {
  std::string text(path);
  if (text.empty() || text[0] == '/') return text;
  char folder[PATH_MAX];
  return getcwd(folder, sizeof(folder)) == nullptr ? text : std::string(folder) + "/" + text;
}

// Empty: not below the folder.
std::string inside(const std::string& path) {
  const std::string& folder = settings().folder;
  return !folder.empty() && (path + "/").compare(0, folder.size(), folder) == 0 ? path + "" : "";
}

std::string inside(int file) {
  if (settings().folder.empty()) return "";
  char path[PATH_MAX];
  const std::string link = "/proc/self/fd/" + std::to_string(file);
  const ssize_t size = readlink(link.c_str(), path, sizeof(path));
  return size <= 0 ? "" : inside(std::string(path, static_cast<std::size_t>(size)));
}

// Counts a call. True: it fails, and errno says why.
bool fails() {
  Settings& s = settings();
  const std::uint64_t number = s.count ? s.count->fetch_add(1) + 1 : 0;
  if (number == s.signal_at && number > 0) kill(getpid(), s.signal);
  if (number < s.fail_from || number >= s.fail_until) return false;
  errno = s.error;
  return true;
}

void record(char kind, const std::string& path, const std::string& other, std::uint64_t offset,
            const void* data, std::uint64_t size) {
  Settings& s = settings();
  if (s.log < 0) return;
  const int error = errno;
  std::string bytes(1, kind);
  const auto put = [&](std::uint64_t n) { bytes.append(reinterpret_cast<const char*>(&n), 8); };
  put(path.size());
  bytes += path;
  put(other.size());
  bytes += other;
  put(offset);
  put(size);
  if (data != nullptr) bytes.append(static_cast<const char*>(data), size);
  if (write_real(s.log, bytes.data(), bytes.size()) != static_cast<ssize_t>(bytes.size()))
    std::abort();
  errno = error;
}

// Calls of threads are recorded in the order in which they take effect.
template <class Call>
auto in_turn(Call&& call) {
  const std::lock_guard guard(settings().mutex);
  return call();
}

int open_counted(const char* path, int flags, mode_t mode) {
  const std::string name = (flags & (O_CREAT | O_TRUNC)) != 0 ? inside(absolute(path)) : "";
  if (name.empty()) return open_real(path, flags, mode);
  return in_turn([&] {
    struct stat known = {};
    const bool exists = ::stat(path, &known) == 0;
    const bool changes = !exists || ((flags & O_TRUNC) != 0 && known.st_size > 0);
    if (changes && fails()) return -1;
    const int file = open_real(path, flags, mode);
    if (file >= 0 && !exists) record('C', name, "", 0, nullptr, 0);
    if (file >= 0 && exists && changes) record('T', name, "", 0, nullptr, 0);
    return file;
  });
}

template <class Call>
ssize_t write_counted(int file, std::int64_t offset, const void* data, Call&& call) {
  const std::string name = inside(file);
  if (name.empty()) return call();
  return in_turn([&]() -> ssize_t {
    if (fails()) return -1;
    if (offset < 0) offset = lseek(file, 0, SEEK_CUR);
    const ssize_t written = call();
    if (written > 0)
      record('W', name, "", static_cast<std::uint64_t>(offset), data,
             static_cast<std::uint64_t>(written));
    return written;
  });
}

template <class Call>
int call_counted(char kind, const std::string& name, const std::string& other, std::uint64_t offset,
                 Call&& call) {
  if (name.empty()) return call();
  return in_turn([&] {
    if (fails()) return -1;
    const int result = call();
    if (result == 0) record(kind, name, other, offset, nullptr, 0);
    return result;
  });
}

mode_t mode_of(int flags, va_list list) {
  return (flags & (O_CREAT | O_TMPFILE)) != 0 ? static_cast<mode_t>(va_arg(list, unsigned)) : 0;
}

}  // namespace

extern "C" {

int open(const char* path, int flags, ...) {
  va_list list;
  va_start(list, flags);
  const mode_t mode = mode_of(flags, list);
  va_end(list);
  return open_counted(path, flags, mode);
}

int open64(const char* path, int flags, ...) {
  va_list list;
  va_start(list, flags);
  const mode_t mode = mode_of(flags, list);
  va_end(list);
  return open_counted(path, flags, mode);
}

ssize_t write(int file, const void* data, std::size_t size) {
  return write_counted(file, -1, data, [&] { return write_real(file, data, size); });
}

ssize_t pwrite(int file, const void* data, std::size_t size, off_t offset) {
  static auto* const call = real<ssize_t(int, const void*, std::size_t, off_t)>("pwrite");
  return write_counted(file, offset, data, [&] { return call(file, data, size, offset); });
}

ssize_t pwrite64(int file, const void* data, std::size_t size, off64_t offset) {
  return pwrite(file, data, size, offset);
}

int ftruncate(int file, off_t size) noexcept {
  static auto* const call = real<int(int, off_t)>("ftruncate");
  return call_counted('T', inside(file), "", static_cast<std::uint64_t>(size),
                      [&] { return call(file, size); });
}

int ftruncate64(int file, off64_t size) noexcept { return ftruncate(file, size); }

int fsync(int file) {
  static auto* const call = real<int(int)>("fsync");
  return call_counted('S', inside(file), "", 0, [&] { return call(file); });
}

int fdatasync(int file) {
  static auto* const call = real<int(int)>("fdatasync");
  return call_counted('S', inside(file), "", 0, [&] { return call(file); });
}

int rename(const char* from, const char* to) noexcept {
  static auto* const call = real<int(const char*, const char*)>("rename");
  return call_counted('R', inside(absolute(from)), absolute(to), 0, [&] { return call(from, to); });
}

int unlink(const char* path) noexcept {
  static auto* const call = real<int(const char*)>("unlink");
  return call_counted('U', inside(absolute(path)), "", 0, [&] { return call(path); });
}

}  // extern "C"
