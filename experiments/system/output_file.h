// Files that are written whole or not at all, and the errors of writing them.
#pragma once

#include <memory>
#include <optional>
#include <ostream>
#include <string>
#include <string_view>

#include "firn/math.h"

namespace firn {

// A write that the operating system refused, e.g. on a full disk. It is no failure of the
// simulation. `FILE: cannot write: REASON`, where REASON is the system's text.
struct WriteError : RunError {
  // `error`: errno.
  WriteError(const std::string& file, int error);
  WriteError(const std::string& file, const std::string& reason);
  // The same error with what is safe: `; TEXT` is added.
  WriteError(const WriteError& e, const std::string& safe);
  int error = 0;  // errno; 0: not known
};

// The WriteError that a process of firn printed as this line, without what is safe; nothing when
// the line is another one.
std::optional<WriteError> write_error_in(std::string_view line);

// "No space left on device"
std::string system_text(int error);

// Remedy for a write error before the same command can resume: "free space and ".
// Empty when nothing general can be said.
std::string remedy(int error);

// The name of an output was a wrong one: `FILE: cannot be written: REASON; expected ...`.
struct OutputRefused : InputError {
  OutputRefused(const std::string& file, int error);
  int error;  // errno
};

// Whether errno says that a name leads to no place for this user. All else is a matter of the
// machine.
bool is_wrong_name(int error);

// Throws what a failure to open FILE for writing is: OutputRefused when the name leads to no place
// for this user, a WriteError for a device that is full, read-only, broken, ...
[[noreturn]] void refuse_output(const std::string& file, int error);

// Makes a folder for outputs where it is missing. Throws InputError `FOLDER: cannot be made:
// REASON; expected ...`, or WriteError, as refuse_output().
void make_output_folder(const std::string& folder);

// A file descriptor; closes it on destruction.
class Descriptor {
 public:
  explicit Descriptor(int number = -1) : number_(number) {}
  Descriptor(Descriptor&& other) noexcept;
  Descriptor& operator=(Descriptor&& other) noexcept;
  ~Descriptor();
  int number() const { return number_; }
  int close();  // 0, or errno
 private:
  int number_;
};

// All bytes, or a WriteError that names `file`.
void write_all(int descriptor, const char* data, std::size_t size, const std::string& file);
// Returns when the device has the bytes of the file. Pipes and terminals have nothing to wait for.
void sync_file(int descriptor, const std::string& file);
// The same for the file of this name, and the name.
void sync_path(const std::string& file);
// Returns when the device has the names in the folder of `file`, e.g. after a rename.
void sync_folder_of(const std::string& file);

// A stream into a temporary file in the folder of FILE. commit() gives it the name FILE, after the
// device has its bytes: after any failure, FILE is the earlier one or the new one. Without commit()
// nothing remains. A device or a pipe (/dev/stdout) is written directly.
class OutputFile : public std::ostream {
 public:
  enum class When {
    at_commit,
    unsynced,  // at_commit, without waiting for the device: files that are quickly made again
    at_once    // FILE grows as it is written
  };
  // Throws as refuse_output(). `temporary`: name of the temporary file; empty: one that no other
  // process uses.
  explicit OutputFile(const std::string& file, When when = When::at_commit,
                      const std::string& temporary = "");
  ~OutputFile() override;
  // Every write throws WriteError, and commit() as refuse_output().
  void commit();

 private:
  class Buffer;
  std::unique_ptr<Buffer> buffer_;
};

// A whole file of this text. Throws as OutputFile.
void write_file(const std::string& file, std::string_view text,
                OutputFile::When when = OutputFile::When::at_commit);
// The same in a folder where this program could write before: every failure is a WriteError.
void write_own_file(const std::string& file, std::string_view text,
                    OutputFile::When when = OutputFile::When::at_commit);

}  // namespace firn
