// HDF5 files: the operations that results files need, without the header of the library.
//
// Every failure throws hdf5::Error with the innermost error message of the library. The library
// prints nothing. An object may be used from any thread, by one thread at a time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace firn::hdf5 {

using Id = std::int64_t;  // hid_t

struct Error : std::runtime_error {
  explicit Error(const std::string& what, int error = 0)
      : std::runtime_error(what), system_error_(error) {}
  // errno of the failed system call; 0: none.
  int system_error() const { return system_error_; }

 private:
  int system_error_;
};

// Owner of an HDF5 identifier. The next flush of a file throws an error of the destructor.
class Handle {
 public:
  Handle() = default;
  explicit Handle(Id id) : id_(id) {}
  Handle(Handle&& other) noexcept : id_(std::exchange(other.id_, -1)) {}
  Handle& operator=(Handle&& other) noexcept {
    std::swap(id_, other.id_);
    return *this;
  }
  ~Handle() { close(); }
  void close();
  Id id() const { return id_; }
  Id release() { return std::exchange(id_, -1); }

 private:
  Id id_ = -1;
};

using Shape = std::vector<std::size_t>;  // rows first; empty: a scalar

// Element types: double, int, std::uint64_t, std::byte.
template <class T>
Id native_type();

// Element types in the file. Numbers are little-endian; text has variable length.
enum class Type { real, integer, natural, byte, text, other };  // 64, 32, 64 (unsigned), 8 bits

// A group or a dataset of a file.
struct Object {
  std::string path;  // absolute
  bool is_group = false;
  // Of a dataset:
  Type type = Type::other;
  bool has_space = true;  // false: a null dataspace, which has neither shape nor values
  Shape shape;
};
// Which values of a dataset a file contains.
struct Stored {
  std::size_t rows = 0;  // leading rows in the file; all rows of a dataset without chunks
  bool in_chunks = false;
};
struct Attribute {
  Type type = Type::other;
  bool has_space = true;
  Shape shape;
};

// Translation between the current names and the names in a file of another version. An empty
// function changes nothing.
struct Names {
  // Path of a dataset or group: from the current name to the name in the file, and back.
  std::function<std::string(const std::string&path)> stored, current;
  // Name in the file of the attribute `name` of the object at `path`.
  std::function<std::string(const std::string& path, const std::string& name)> stored_attribute;
  // Current text for a text value of the dataset at `path`.
  std::function<std::string(const std::string& path, const std::string& text)> current_text;
};

// A dataset of doubles that grows by rows. Flushed data is never moved: rows of 4 KiB or more are
// one compressed chunk each, written once; smaller rows share uncompressed chunks that are filled
// in place. After a kill of the writer, all flushed rows are readable.
class Table {
 public:
  Table(Handle dataset, std::size_t rows, std::size_t row_size);
  std::size_t rows() const { return rows_; }
  std::size_t row_size() const { return row_size_; }
  void append(std::span<const double> values);  // whole rows
  void truncate(std::size_t rows);

 private:
  Handle dataset_;
  std::size_t rows_ = 0, row_size_ = 1;
};

class File {
 public:
  enum class Access { read, write };
  // Creates a file; an existing one is replaced.
  static File create(const std::string& path);
  static File open(const std::string& path, Access access);

  // After the call, all functions take and return current names. `names.stored` requires
  // `names.current`. Lists omit an object whose name in the file is the current name of another
  // one.
  void use_names(Names names) {
    names_ = std::move(names);
    open_rows_.clear();
  }

  void flush();  // also throws errors of handles that were closed before
  void close();  // throws errors that the destructor must ignore

  bool contains(const std::string& path) const;
  void remove(const std::string& path);       // a dataset, or a group with its contents
  std::vector<std::string> datasets() const;  // absolute paths, in alphabetical order
  // All groups except the root and all datasets, sorted by path. Throws Error for objects that Firn
  // does not write and that can lead out of the file or into endless recursion: links that are not
  // hard, two links to one object, named types, group depth above 32, more than 100 000 objects.
  std::vector<Object> objects() const;
  // Throws Error unless the values of a dataset are inside the file with the size that its shape
  // requires: no external or virtual storage, no filters except shuffle and deflate, chunks of
  // whole rows that do not overlap. Reads no values.
  Stored check_storage(const std::string& path) const;
  Shape shape(const std::string& path) const;

  // Whole datasets, row-major.
  template <class T>
  std::vector<T> read(const std::string& path) const;
  std::vector<std::string> read_strings(const std::string& path) const;
  // Rows [first, first + count) of a dataset of doubles. Throws Error if a chunk does not contain
  // exactly its rows or was never written.
  std::vector<double> read_rows(const std::string& path, std::size_t first,
                                std::size_t count) const;
  // Creates the dataset and its groups, or overwrites one of the same shape in place.
  template <class T>
  void write(const std::string& path, const Shape& shape, std::span<const T> values);
  void write_strings(const std::string& path, const std::vector<std::string>& values);

  // Replaces the bytes of a dataset, which grows to the largest size so far.
  void write_bytes(const std::string& path, std::span<const std::byte> bytes);

  Table create_table(const std::string& path, const Shape& row, const std::string& unit);
  Table open_table(const std::string& path);

  // Attributes of the object at `path` ("/" for the file).
  bool has_attribute(const std::string& path, const std::string& name) const;
  Attribute attribute(const std::string& path, const std::string& name) const;
  void set_attribute(const std::string& path, const std::string& name, const std::string& value);
  void set_attribute(const std::string& path, const std::string& name, double value);
  void set_attribute(const std::string& path, const std::string& name, std::uint64_t value);
  void set_attribute(const std::string& path, const std::string& name,
                     const std::vector<double>& values);
  std::string text_attribute(const std::string& path, const std::string& name) const;
  std::vector<double> number_attribute(const std::string& path, const std::string& name) const;
  std::uint64_t integer_attribute(const std::string& path, const std::string& name) const;

 private:
  // A dataset of doubles that is open for reading by rows.
  struct OpenRows;
  explicit File(Handle file, Access access) : file_(std::move(file)), access_(access) {}
  // The dataset, which a file without write access keeps open: opening costs more than reading a
  // row.
  std::shared_ptr<const OpenRows> open_rows(const std::string& path) const;
  std::string stored(const std::string& path) const;
  std::string stored(const std::string& path, const std::string& attribute) const;
  bool is_in_use(const std::string& stored_path, std::string& path) const;
  Handle file_;
  Access access_;
  Names names_;
  mutable std::map<std::string, std::shared_ptr<const OpenRows>> open_rows_;  // by their paths
};

}  // namespace firn::hdf5
