#include "experiments/system/output_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <filesystem>
#include <optional>
#include <system_error>
#include <utility>

#include "experiments/system/interruption.h"

namespace firn {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kCannotWrite = ": cannot write: ";

std::string folder_of(const std::string& file) {
  const std::string folder = fs::path(file).parent_path().string();
  return folder.empty() ? "." : folder;
}

// Where a chain of links ends, so that a rename replaces the file and not the link.
std::string behind_links(const std::string& file) {
  std::error_code error;
  if (!fs::is_symlink(fs::symlink_status(file, error))) return file;
  const fs::path end = fs::weakly_canonical(file, error);
  return error ? file : end.string();
}

}  // namespace

WriteError::WriteError(const std::string& file, int number)
    : RunError(fmt::format("{}{}{}", file, kCannotWrite, errno_text(number))), error(number) {}

WriteError::WriteError(const std::string& file, const std::string& reason)
    : RunError(fmt::format("{}{}{}", file, kCannotWrite, reason)) {}

WriteError::WriteError(const WriteError& e, const std::string& safe)
    : RunError(fmt::format("{}; {}", e.what(), safe)), error(e.error) {}

std::optional<WriteError> write_error_in(std::string_view line) {
  constexpr std::string_view program = "firn: ";
  const std::size_t at = line.find(kCannotWrite);
  if (!line.starts_with(program) || at == line.npos || at < program.size()) return std::nullopt;
  const std::string_view reason = line.substr(at + kCannotWrite.size());
  return WriteError(std::string(line.substr(program.size(), at - program.size())),
                    std::string(reason.substr(0, reason.find("; "))));
}

std::string errno_text(int error) { return std::generic_category().message(error); }

std::string remedy(int error) {
  switch (error) {
    case ENOSPC:
    case EDQUOT:
      return "free space and ";
    case EFBIG:
      return "raise the limit on the size of files and ";
    case EROFS:
      return "make the disk writable and ";
    case EIO:
      return "check the disk and ";
    default:
      return "";
  }
}

OutputPathError::OutputPathError(const std::string& file, int number)
    : InputError(fmt::format("{}: cannot be written: {}; expected a place that can be written",
                             file, errno_text(number))),
      error(number) {}

bool is_path_error(int error) {
  for (const int name : {ENOENT, ENOTDIR, EISDIR, EACCES, EPERM, ENAMETOOLONG, ELOOP, EINVAL,
                         ETXTBSY, ENXIO, ENODEV, EEXIST})
    if (error == name) return true;
  return false;
}

void refuse_output(const std::string& file, int error) {
  if (is_path_error(error)) throw OutputPathError(file, error);
  throw WriteError(file, error);
}

void make_output_folder(const std::string& folder) {
  if (folder.empty()) return;
  std::error_code error;
  fs::create_directories(folder, error);
  if (!error) return;
  if (!is_path_error(error.value())) throw WriteError(folder, error.value());
  throw InputError(fmt::format("{}: cannot be made: {}; expected a place that can be written",
                               folder, error.message()));
}

void make_own_folder(const std::string& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw WriteError(folder, error.value());
}

void remove_if_there(const std::string& file) {
  if (::unlink(file.c_str()) != 0 && errno != ENOENT) throw WriteError(file, errno);
}

Descriptor::Descriptor(Descriptor&& other) noexcept : number_(std::exchange(other.number_, -1)) {}

Descriptor& Descriptor::operator=(Descriptor&& other) noexcept {
  std::swap(number_, other.number_);
  return *this;
}

Descriptor::~Descriptor() { close(); }

int Descriptor::close() {
  const int number = std::exchange(number_, -1);
  // Linux releases the descriptor also when a signal interrupts close().
  return number < 0 || ::close(number) == 0 || errno == EINTR ? 0 : errno;
}

void write_all(int descriptor, const char* data, std::size_t size, const std::string& file) {
  while (size > 0) {
    const ssize_t written = ::write(descriptor, data, size);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) throw WriteError(file, written < 0 ? errno : ENOSPC);
    data += written;
    size -= static_cast<std::size_t>(written);
  }
}

void sync_file(int descriptor, const std::string& file) {
  while (::fsync(descriptor) != 0) {
    if (errno == EINTR) continue;
    if (errno == EINVAL || errno == ENOTSUP) return;  // a pipe, a terminal
    throw WriteError(file, errno);
  }
}

void sync_path(const std::string& file) {
  const Descriptor descriptor(::open(file.c_str(), O_RDONLY | O_CLOEXEC));
  if (descriptor.number() < 0) throw WriteError(file, errno);
  sync_file(descriptor.number(), file);
  sync_folder_of(file);
}

void sync_folder_of(const std::string& file) {
  const std::string folder = folder_of(file);
  Descriptor descriptor(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (descriptor.number() < 0) {
    if (errno == EACCES) return;  // names can be made in it, but it cannot be read
    throw WriteError(file, errno);
  }
  sync_file(descriptor.number(), file);
}

class OutputFile::Buffer : public std::streambuf {
 public:
  Buffer(const std::string& file, When when, const std::string& temporary)
      : file_(file), target_(behind_links(file)), synced_(when != When::unsynced) {
    struct stat known = {};
    const bool exists = ::stat(target_.c_str(), &known) == 0;
    if (when == When::at_once || (exists && !S_ISREG(known.st_mode))) {
      open(target_, O_TRUNC);
    } else {
      // A file that may not be written is not replaced either.
      if (exists && ::access(target_.c_str(), W_OK) != 0) refuse_output(file_, errno);
      if (!temporary.empty()) {
        temporary_ = temporary;
        open(temporary_, O_TRUNC);
      } else {
        open_unused();
      }
      if (exists) ::fchmod(descriptor_.number(), known.st_mode & 07777);
    }
    setp(bytes_.data(), bytes_.data() + bytes_.size());
  }

  ~Buffer() override {
    if (!temporary_.empty()) ::unlink(temporary_.c_str());
  }

  void commit() {
    sync();
    if (synced_) sync_file(descriptor_.number(), file_);
    if (const int error = descriptor_.close()) throw WriteError(file_, error);
    if (temporary_.empty()) return;
    if (::rename(temporary_.c_str(), target_.c_str()) != 0) refuse_output(file_, errno);
    temporary_.clear();
    abandoned_.reset();
    if (synced_) sync_folder_of(target_);
  }

 protected:
  int_type overflow(int_type c) override {
    sync();
    if (traits_type::eq_int_type(c, traits_type::eof())) return traits_type::not_eof(c);
    *pptr() = traits_type::to_char_type(c);
    pbump(1);
    return c;
  }

  std::streamsize xsputn(const char* data, std::streamsize size) override {
    if (size < epptr() - pptr()) return std::streambuf::xsputn(data, size);
    sync();
    write_all(descriptor_.number(), data, static_cast<std::size_t>(size), file_);
    return size;
  }

  int sync() override {
    const auto size = static_cast<std::size_t>(pptr() - pbase());
    setp(bytes_.data(), bytes_.data() + bytes_.size());
    write_all(descriptor_.number(), bytes_.data(), size, file_);
    return 0;
  }

 private:
  void open(const std::string& name, int flags) {
    descriptor_ = Descriptor(::open(name.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC | flags, 0666));
    if (descriptor_.number() < 0) refuse_output(file_, errno);
  }

  // A short name, as that of the file may be as long as names can be.
  void open_unused() {
    static std::atomic<unsigned> count = 0;
    while (descriptor_.number() < 0) {
      const interruption::Uninterrupted created;
      temporary_ = fmt::format("{}/.firn-{}-{}.writing", folder_of(target_), getpid(), count++);
      descriptor_ =
          Descriptor(::open(temporary_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666));
      if (descriptor_.number() >= 0) abandoned_.emplace(temporary_);
      if (descriptor_.number() >= 0 || errno == EEXIST) continue;
      temporary_.clear();
      refuse_output(file_, errno);
    }
  }

  std::string file_, target_;
  bool synced_;
  std::string temporary_;  // empty: written directly
  std::optional<interruption::Temporary> abandoned_;
  Descriptor descriptor_;
  std::array<char, 1 << 16> bytes_;
};

OutputFile::OutputFile(const std::string& file, When when, const std::string& temporary)
    : std::ostream(nullptr), buffer_(std::make_unique<Buffer>(file, when, temporary)) {
  rdbuf(buffer_.get());
  exceptions(std::ios::badbit);  // the buffer's WriteError reaches the caller
}

OutputFile::~OutputFile() = default;

void OutputFile::commit() { buffer_->commit(); }

void write_file(const std::string& file, std::string_view text, OutputFile::When when) {
  OutputFile out(file, when);
  out.write(text.data(), static_cast<std::streamsize>(text.size()));
  out.commit();
}

void write_own_file(const std::string& file, std::string_view text, OutputFile::When when) {
  try {
    write_file(file, text, when);
  } catch (const OutputPathError& e) {
    throw WriteError(file, e.error);
  }
}

}  // namespace firn
