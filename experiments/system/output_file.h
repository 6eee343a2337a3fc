// Atomic writing of output files, and write errors.
#pragma once

#include <memory>
#include <optional>
#include <ostream>
#include <string>
#include <string_view>

#include "firn/math.h"

namespace firn {

// A write that the operating system refused, e.g. on a full disk; not a failure of the simulation.
// Message: `FILE: cannot write: REASON`, with the text of errno as REASON.
struct WriteError : RunError {
  // `error`: errno.
  WriteError(const std::string& file, int error);
  WriteError(const std::string& file, const std::string& reason);
  // The same error with `; SAFE` added to the message: which results are saved.
  WriteError(const WriteError& e, const std::string& safe);
  int error = 0;  // errno; 0: unknown
};

// The WriteError whose message a firn process printed as this line, without the part on saved
// results. Nothing for any other line.
std::optional<WriteError> write_error_in(std::string_view line);

// Text of an errno: "No space left on device".
std::string errno_text(int error);

// What the user must do before the same command can resume after a write error with this errno:
// "free space and ". Empty for errors without a general remedy.
std::string remedy(int error);

// The path of an output cannot be used: `FILE: cannot be written: REASON; expected ...`.
struct OutputPathError : InputError {
  OutputPathError(const std::string& file, int error);
  int error;  // errno
};

// True if the path is the cause of this errno (missing folder, no permission, ...), not the state
// of the device.
bool is_path_error(int error);

// Throws the error for a failure to open `file` for writing: OutputPathError if is_path_error(),
// else WriteError (device full, read-only, defective, ...).
[[noreturn]] void refuse_output(const std::string& file, int error);

// Creates a folder for outputs if it is missing. Throws InputError `FOLDER: cannot be made: REASON;
// expected ...`, or WriteError, as refuse_output().
void make_output_folder(const std::string& folder);

// The same for a folder below one in which this program has written before: each failure is a
// WriteError.
void make_own_folder(const std::string& folder);

// Throws WriteError unless the file is removed or does not exist.
void remove_if_there(const std::string& file);

// Owner of a file descriptor; the destructor closes it.
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

// Writes all bytes. Throws WriteError that names `file`.
void write_all(int descriptor, const char* data, std::size_t size, const std::string& file);
// Returns after the device has stored the bytes of the file (fsync). No effect on pipes and
// terminals.
void sync_file(int descriptor, const std::string& file);
// The same for the file of this name, and for its directory entry.
void sync_path(const std::string& file);
// Returns after the device has stored the directory entries of the folder of `file`, e.g. after a
// rename.
void sync_folder_of(const std::string& file);

// A stream to a temporary file in the folder of FILE. commit() renames it to FILE after the device
// has stored its bytes. After any failure, FILE is the earlier file or the complete new one.
// Without commit() the temporary file is removed. A device or a pipe (/dev/stdout) is written
// directly.
class OutputFile : public std::ostream {
 public:
  enum class When {
    at_commit,
    unsynced,  // at_commit without fsync, for files that are cheap to recreate
    at_once    // FILE grows as it is written
  };
  // Throws as refuse_output(). `temporary`: name of the temporary file; empty: a unique name.
  explicit OutputFile(const std::string& file, When when = When::at_commit,
                      const std::string& temporary = "");
  ~OutputFile() override;
  // Writes throw WriteError. commit() throws as refuse_output().
  void commit();

 private:
  class Buffer;
  std::unique_ptr<Buffer> buffer_;
};

// Writes a file with this text. Throws as OutputFile.
void write_file(const std::string& file, std::string_view text,
                OutputFile::When when = OutputFile::When::at_commit);
// The same in a folder in which this program has written before: each failure is a WriteError.
void write_own_file(const std::string& file, std::string_view text,
                    OutputFile::When when = OutputFile::When::at_commit);

}  // namespace firn
