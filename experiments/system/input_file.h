// Opens files of users: regular files only, with a check of the size before reading.
#pragma once

#include <compare>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>

namespace firn {

// State of a file at one time. Equal stamps: the file has not been replaced or written in between.
struct FileStamp {
  bool exists = false;
  std::uint64_t device = 0, inode = 0, size = 0;
  std::int64_t changed = 0;  // ns, time of the last change of the content

  auto operator<=>(const FileStamp&) const = default;
};
FileStamp stamp_of(const std::string& file);

// Collects the names and stamps of all files that this thread opens, or fails to open, by the
// functions below while the object exists. One object per thread at a time.
class InputFileRecord {
 public:
  InputFileRecord();
  ~InputFileRecord();
  InputFileRecord(const InputFileRecord&) = delete;
  InputFileRecord& operator=(const InputFileRecord&) = delete;

  // Name -> stamp when the file was opened.
  const std::map<std::string, FileStamp>& files() const { return files_; }

 private:
  friend void record_input_file(const std::string&);
  std::map<std::string, FileStamp> files_;
};

// New place of a shipped file that earlier versions had below experiments/; empty for other files.
std::string moved_file(const std::string& file);

// Throws InputError `FILE: what is wrong; expected WANTED` unless the file can be read and is a
// regular one: no folder, device, pipe or socket. Does not block.
void require_regular_file(const std::string& file, std::string_view wanted);

// All bytes of a regular file of at most `most` bytes. Throws InputError as above, before it reads
// a file that is longer.
std::string read_input_file(const std::string& file, std::string_view wanted, std::uintmax_t most);

// The first bytes of a file: at most `count`, fewer of a shorter one, none of one that cannot be
// read.
std::string first_bytes(const std::string& file, std::size_t count);
// All bytes of a small file that this program or a process of it wrote; none when it cannot be
// read.
std::string read_own_file(const std::string& file);

// The first bytes of an HDF5 file.
inline constexpr std::string_view kHdf5Signature = "\x89HDF\r\n\x1a\n";

// Throws InputError as above for a results file of a run and for UTF-16, which spreadsheets write
// as "Unicode text". The messages of text parsers would not help in these cases.
void require_plain_text(std::string_view bytes, const std::string& file, std::string_view wanted);

// The first characters of a text, for messages.
std::string shortened(std::string_view text);

}  // namespace firn
