// Reads input files of the user: regular files only, whose size is checked before reading.
#pragma once

#include <compare>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>

namespace firn {

// State of a file at one time. With equal stamps, the file was not replaced or written in between.
struct FileStamp {
  bool exists = false;
  std::uint64_t device = 0, inode = 0, size = 0;
  std::int64_t changed = 0;  // ns, time of the last modification

  auto operator<=>(const FileStamp&) const = default;
};
FileStamp stamp_of(const std::string& file);

// Records the names and stamps of all files that this thread opens, or fails to open, by the
// functions below while the object exists. At most one object per thread at a time.
class InputFileRecord {
 public:
  InputFileRecord();
  ~InputFileRecord();
  InputFileRecord(const InputFileRecord&) = delete;
  InputFileRecord& operator=(const InputFileRecord&) = delete;

  // Name -> stamp at the time of opening.
  const std::map<std::string, FileStamp>& files() const { return files_; }

 private:
  friend void record_input_file(const std::string&);
  std::map<std::string, FileStamp> files_;
};

// Current path of a shipped file that earlier versions had below experiments/. Empty for other
// files.
std::string moved_file(const std::string& file);

// Throws InputError `FILE: FAULT; expected WANTED` unless the file can be read and is a regular
// file, not a folder, device, pipe or socket. Does not block.
void require_regular_file(const std::string& file, std::string_view wanted);

// All bytes of a regular file. Throws InputError as above, also for a file of more than `most`
// bytes, before reading it.
std::string read_input_file(const std::string& file, std::string_view wanted, std::uintmax_t most);

// The first `count` bytes of a file; all bytes of a shorter file. Empty if the file cannot be read.
std::string first_bytes(const std::string& file, std::size_t count);
// All bytes of a small file that this program or one of its processes wrote. Empty if it cannot be
// read.
std::string read_own_file(const std::string& file);

// The first bytes of an HDF5 file.
inline constexpr std::string_view kHdf5Signature = "\x89HDF\r\n\x1a\n";

// Throws InputError as above for the bytes of a results file and of UTF-16 text, which spreadsheets
// export as "Unicode text". Text parsers have no clear message for these.
void require_plain_text(std::string_view bytes, const std::string& file, std::string_view wanted);

// The first characters of a text, for messages.
std::string shortened(std::string_view text);

// The text without spaces and tabs at either end.
std::string trimmed(std::string_view text, std::string_view blanks = " \t");

}  // namespace firn
