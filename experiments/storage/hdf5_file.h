// Owner of HDF5 handles: the few operations on a file that results need, without the library's
// header.
//
// Every failure is an hdf5::Error with the library's innermost reason; the library itself prints
// nothing. Objects may be used from any thread, one thread at a time each.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
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
  // errno of the system call that failed; 0: none did.
  int system_error() const { return system_error_; }

 private:
  int system_error_;
};

// Any HDF5 identifier; gives it back on destruction. What fails then is thrown by the next flush of
// a file.
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

// What elements are in the file. Numbers are little-endian; text has any length.
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
// What a file has of the values of a dataset.
struct Stored {
  std::size_t rows = 0;  // leading rows that are there; all of a dataset without chunks
  bool in_chunks = false;
};
struct Attribute {
  Type type = Type::other;
  bool has_space = true;
  Shape shape;
};

// Names of a file that differ from those that its users give, because another version wrote it. An
// empty function changes nothing.
struct Names {
  // Path of a dataset or a group: from its name in use to the one in the file, and back.
  std::function<std::string(const std::string&path)> stored, current;
  // Name in the file of an attribute of the object at `path`.
  std::function<std::string(const std::string& path, const std::string& name)> stored_attribute;
  // The current word for a text of the dataset at `path`.
  std::function<std::string(const std::string& path, const std::string& text)> current_text;
};

// A dataset of doubles that grows by rows. What is flushed never moves: rows of 4 KiB or more are
// one compressed chunk each, written once; smaller ones share plain chunks that are filled in
// place. So a writer that is killed leaves every flushed row readable.
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
  // A new file; an existing one is replaced.
  static File create(const std::string& path);
  static File open(const std::string& path, Access access);

  // From now on, all functions take and return names in use. `names.stored` must be given with
  // `names.current`. An object that has a name in use, but is not what that name stands for, is
  // left out of lists.
  void use_names(Names names) { names_ = std::move(names); }

  void flush();  // throws, too, when a handle that was closed before could not write its data
  void close();  // reports what the destructor would have to swallow

  bool contains(const std::string& path) const;
  void remove(const std::string& path);       // a dataset, or a group with all in it
  std::vector<std::string> datasets() const;  // every one, absolute, in alphabetical order
  // Every group but the root and every dataset, by path. Throws Error for what no writer of Firn
  // makes and what could lead out of the file or through it without end: links that are not hard,
  // two links to one object, named types, groups in groups beyond a depth of 32, more than 100 000
  // objects.
  std::vector<Object> objects() const;
  // Throws Error unless the values of a dataset are inside the file and take the space that its
  // shape needs: no external or virtual storage, no filters but shuffle and deflate, chunks of
  // whole rows that do not overlap. Reads no values.
  Stored check_storage(const std::string& path) const;
  Shape shape(const std::string& path) const;

  // Whole datasets, row-major.
  template <class T>
  std::vector<T> read(const std::string& path) const;
  std::vector<std::string> read_strings(const std::string& path) const;
  // Rows [first, first + count) of a dataset of doubles. Throws Error where a chunk does not hold
  // exactly its rows, or was never written.
  std::vector<double> read_rows(const std::string& path, std::size_t first,
                                std::size_t count) const;
  // Creates the dataset and its groups, or overwrites one of the same shape in place.
  template <class T>
  void write(const std::string& path, const Shape& shape, std::span<const T> values);
  void write_strings(const std::string& path, const std::vector<std::string>& values);

  // Bytes that are replaced now and then; the dataset grows to the longest.
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
  explicit File(Handle file) : file_(std::move(file)) {}
  std::string stored(const std::string& path) const;
  std::string stored(const std::string& path, const std::string& attribute) const;
  bool is_in_use(const std::string& stored_path, std::string& path) const;
  Handle file_;
  Names names_;
};

}  // namespace firn::hdf5
