// Checkpoints in a results file: two slots, used alternately, each with a checksum.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include "experiments/storage/hdf5_file.h"
#include "firn/math.h"

namespace firn {

struct Checkpoint {
  std::uint64_t sequence = 0;  // 1, 2, ... in a file
  std::vector<std::byte> payload;
};

// Overwrites the slot of the older checkpoint. Flushes the file before and after, so that the other
// slot is complete after a kill at any time, and no checkpoint is later than the flushed frames.
void write_checkpoint(hdf5::File& file, const Checkpoint& checkpoint);

void remove_checkpoints(hdf5::File& file);

// The complete checkpoints of a file, newest first.
std::vector<Checkpoint> read_checkpoints(const hdf5::File& file);

// States saved at intervals of a run (output.state_interval), identified by their step, for
// replays. The format is that of checkpoints. Incomplete states count as missing.
void write_state(hdf5::File& file, std::uint64_t step, const std::vector<std::byte>& payload);
std::vector<std::uint64_t> saved_states(const hdf5::File& file);  // steps, ascending
std::optional<std::vector<std::byte>> read_state(const hdf5::File& file, std::uint64_t step);

// Writes trivially copyable values, vectors of them and text to the payload.
class ByteWriter {
 public:
  template <class T>
  void put(const T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    const auto* p = reinterpret_cast<const std::byte*>(&value);
    bytes_.insert(bytes_.end(), p, p + sizeof(T));
  }
  template <class T>
  void put(const std::vector<T>& values) {
    put<std::uint64_t>(values.size());
    for (const T& value : values) put(value);
  }
  void put(const std::string& text) { put(std::vector<char>(text.begin(), text.end())); }
  std::vector<std::byte> take() { return std::move(bytes_); }

 private:
  std::vector<std::byte> bytes_;
};

// Reads what ByteWriter wrote. Throws RunError when the bytes end too early.
class ByteReader {
 public:
  explicit ByteReader(std::span<const std::byte> bytes) : rest_(bytes) {}
  template <class T>
  void get(T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    if (rest_.size() < sizeof(T)) throw RunError("the checkpoint ends too early");
    std::copy_n(rest_.data(), sizeof(T), reinterpret_cast<std::byte*>(&value));
    rest_ = rest_.subspan(sizeof(T));
  }
  template <class T>
  void get(std::vector<T>& values) {
    std::uint64_t size = 0;
    get(size);
    if (size > rest_.size()) throw RunError("the checkpoint ends too early");
    values.resize(size);
    for (T& value : values) get(value);
  }
  void get(std::string& text) {
    std::vector<char> characters;
    get(characters);
    text.assign(characters.begin(), characters.end());
  }

 private:
  std::span<const std::byte> rest_;
};

}  // namespace firn
