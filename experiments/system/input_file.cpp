#include "experiments/system/input_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "firn/math.h"

namespace firn {
namespace {
thread_local InputFileRecord* record = nullptr;
}

FileStamp stamp_of(const std::string& file) {
  struct stat status = {};
  if (::stat(file.c_str(), &status) != 0) return {};
  FileStamp stamp;
  stamp.exists = true;
  stamp.device = status.st_dev;
  stamp.inode = status.st_ino;
  stamp.size = static_cast<std::uint64_t>(status.st_size);
  stamp.changed = std::int64_t{status.st_mtim.tv_sec} * 1'000'000'000 + status.st_mtim.tv_nsec;
  return stamp;
}

InputFileRecord::InputFileRecord() { record = this; }
InputFileRecord::~InputFileRecord() { record = nullptr; }

// The stamp is taken before the file is read, so that a later change differs from it.
void record_input_file(const std::string& file) {
  if (record != nullptr) record->files_.try_emplace(file, stamp_of(file));
}

std::string moved_file(const std::string& file) {
  constexpr std::string_view kOld = "experiments/", kRecords = "materials/";
  const std::size_t at = file.rfind(kOld);
  if (at == std::string::npos || (at > 0 && file[at - 1] != '/')) return {};
  const std::string name = file.substr(at + kOld.size());
  const std::string moved =
      file.substr(0, at) + (name.starts_with(kRecords) ? "data/" : "cases/") + name;
  std::error_code error;
  return std::filesystem::is_regular_file(moved, error) ? moved : std::string();
}

namespace {

class OpenInput {
 public:
  // O_NONBLOCK: opening a pipe without a writer must not block.
  OpenInput(const std::string& file, std::string_view wanted)
      : number_(::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY)) {
    const auto refuse = [&](const std::string& what) {
      if (number_ >= 0) ::close(number_);
      throw InputError(fmt::format("{}: {}; expected {}", shortened(file), what, wanted));
    };
    if (number_ < 0) {
      const int error = errno;
      const std::string moved = error == ENOENT ? moved_file(file) : std::string();
      if (!moved.empty()) refuse(fmt::format("has moved to {}", shortened(moved)));
      refuse(fmt::format("cannot be opened: {}", std::strerror(error)));
    }
    if (::fstat(number_, &status_) != 0)
      refuse(fmt::format("cannot be read: {}", std::strerror(errno)));
    if (S_ISDIR(status_.st_mode)) refuse("is a folder");
    if (!S_ISREG(status_.st_mode)) refuse("is not a regular file but a device, a pipe or a socket");
  }
  ~OpenInput() { ::close(number_); }
  OpenInput(const OpenInput&) = delete;
  OpenInput& operator=(const OpenInput&) = delete;

  int number() const { return number_; }
  std::uintmax_t size() const { return static_cast<std::uintmax_t>(status_.st_size); }

 private:
  int number_;
  struct stat status_ = {};
};

}  // namespace

void require_regular_file(const std::string& file, std::string_view wanted) {
  record_input_file(file);
  static_cast<void>(OpenInput(file, wanted));
}

std::string read_input_file(const std::string& file, std::string_view wanted, std::uintmax_t most) {
  record_input_file(file);
  const OpenInput descriptor(file, wanted);
  const auto check = [&](std::uintmax_t size) {
    if (size > most)
      throw InputError(fmt::format("{}: is longer than {} bytes; expected {} of at most so many",
                                   shortened(file), most, wanted));
  };
  check(descriptor.size());
  constexpr std::size_t kBlock = 1 << 16;
  std::string bytes;
  // One byte more than stated shows the end. Files of /proc state a size of 0.
  const std::size_t stated = static_cast<std::size_t>(descriptor.size());
  const std::size_t expected = stated == 0 ? kBlock : stated + 1;
  std::size_t used = 0;
  while (true) {
    bytes.resize(used < expected ? expected : used + kBlock);
    const ssize_t got = ::read(descriptor.number(), &bytes[used], bytes.size() - used);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0)
      throw InputError(fmt::format("{}: cannot be read: {}; expected {}", shortened(file),
                                   std::strerror(errno), wanted));
    used += static_cast<std::size_t>(got);
    check(used);
    if (got == 0) break;
  }
  bytes.resize(used);
  return bytes;
}

std::string first_bytes(const std::string& file, std::size_t count) {
  std::ifstream stream(file, std::ios::binary);
  std::string bytes(count, '\0');
  stream.read(bytes.data(), static_cast<std::streamsize>(count));
  bytes.resize(static_cast<std::size_t>(stream.gcount()));
  return bytes;
}

std::string read_own_file(const std::string& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

void require_plain_text(std::string_view bytes, const std::string& file, std::string_view wanted) {
  const auto refuse = [&](std::string_view what) {
    throw InputError(fmt::format("{}: {}; expected {}", shortened(file), what, wanted));
  };
  if (bytes.starts_with(kHdf5Signature.substr(0, 6)))
    refuse("is a results file (HDF5), which firn run --resume continues");
  if (bytes.starts_with("\xff\xfe") || bytes.starts_with("\xfe\xff"))
    refuse("is UTF-16 text, as spreadsheets save it; save it as UTF-8");
}

std::string shortened(std::string_view text) {
  constexpr std::size_t kMost = 300;
  if (text.size() <= kMost) return std::string(text);
  std::size_t end = kMost;
  while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xC0) == 0x80) --end;  // whole UTF-8
  return std::string(text.substr(0, end)) + "...";
}

std::string trimmed(std::string_view text, std::string_view blanks) {
  const std::size_t first = text.find_first_not_of(blanks);
  if (first == text.npos) return {};
  return std::string(text.substr(first, text.find_last_not_of(blanks) - first + 1));
}

}  // namespace firn
