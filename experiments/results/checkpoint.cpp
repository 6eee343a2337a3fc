#include "experiments/results/checkpoint.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cstring>
#include <string_view>

#include "firn/word_hash.h"

namespace firn {
namespace {

constexpr std::string_view kStates = "/states/";
constexpr std::array kSlots = {"/checkpoint/slot_0", "/checkpoint/slot_1"};

// Precedes the payload. The hash covers all bytes behind it. It detects any mixture of an old and a
// new checkpoint.
struct Header {
  char magic[8] = {'F', 'I', 'R', 'N', 'C', 'K', 'P', '1'};
  std::uint64_t hash = 0;
  std::uint64_t sequence = 0;
  std::uint64_t size = 0;  // bytes of the payload
};

std::uint64_t hash_of(const Header& header, std::span<const std::byte> payload) {
  const std::uint64_t start = hash_word(hash_word(kWordHashStart, header.sequence), header.size);
  return hash_words(start, payload.data(), payload.size());
}

std::optional<Checkpoint> read_slot(const hdf5::File& file, const std::string& slot) {
  if (!file.contains(slot)) return std::nullopt;
  const std::vector<std::byte> bytes = file.read<std::byte>(slot);
  Header header;
  if (bytes.size() < sizeof(header) || std::memcmp(bytes.data(), header.magic, 8) != 0) return {};
  std::memcpy(&header, bytes.data(), sizeof(header));
  if (header.size > bytes.size() - sizeof(header)) return {};
  const auto payload = std::span(bytes).subspan(sizeof(header), header.size);
  if (hash_of(header, payload) != header.hash) return {};
  return Checkpoint{header.sequence, {payload.begin(), payload.end()}};
}

std::vector<std::byte> sealed(const Checkpoint& checkpoint) {
  Header header;
  header.sequence = checkpoint.sequence;
  header.size = checkpoint.payload.size();
  header.hash = hash_of(header, checkpoint.payload);
  std::vector<std::byte> bytes(sizeof(header) + checkpoint.payload.size());
  std::memcpy(bytes.data(), &header, sizeof(header));
  std::copy(checkpoint.payload.begin(), checkpoint.payload.end(), bytes.begin() + sizeof(header));
  return bytes;
}

// Of a path that is the state_path() of one.
std::optional<std::uint64_t> step_of(std::string_view path) {
  if (!path.starts_with(kStates)) return std::nullopt;
  const std::string_view digits = path.substr(kStates.size());
  std::uint64_t step = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), step);
  if (error != std::errc() || end != digits.data() + digits.size()) return std::nullopt;
  return step;
}

std::string state_path(std::uint64_t step) { return fmt::format("{}{:012}", kStates, step); }

}  // namespace

void write_checkpoint(hdf5::File& file, const Checkpoint& checkpoint) {
  const std::vector<std::byte> bytes = sealed(checkpoint);
  file.flush();
  file.write_bytes(kSlots[checkpoint.sequence % kSlots.size()], bytes);
  file.flush();
}

void write_state(hdf5::File& file, std::uint64_t step, const std::vector<std::byte>& payload) {
  file.write_bytes(state_path(step), sealed({step, payload}));
}

std::vector<std::uint64_t> saved_states(const hdf5::File& file) {
  std::vector<std::uint64_t> steps;
  for (const std::string& path : file.datasets())
    if (const auto step = step_of(path)) steps.push_back(*step);
  std::sort(steps.begin(), steps.end());
  return steps;
}

std::optional<std::vector<std::byte>> read_state(const hdf5::File& file, std::uint64_t step) {
  std::optional<Checkpoint> found = read_slot(file, state_path(step));
  if (!found || found->sequence != step) return std::nullopt;
  return std::move(found->payload);
}

void remove_checkpoints(hdf5::File& file) {
  if (file.contains("/checkpoint")) file.remove("/checkpoint");
}

std::vector<Checkpoint> read_checkpoints(const hdf5::File& file) {
  std::vector<Checkpoint> whole;
  for (const char* slot : kSlots) {
    try {
      if (std::optional<Checkpoint> found = read_slot(file, slot))
        whole.push_back(std::move(*found));
    } catch (const hdf5::Error&) {
      // A slot whose dataset cannot be read is no checkpoint; the other one may be.
    }
  }
  std::sort(whole.begin(), whole.end(),
            [](const Checkpoint& a, const Checkpoint& b) { return a.sequence > b.sequence; });
  return whole;
}

}  // namespace firn
