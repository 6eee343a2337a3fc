// Hash of bytes, word by word: FNV-1a (Fowler, Noll and Vo) over words of eight bytes in place of
// bytes. State hashes and checkpoints use it.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>

namespace firn {

inline constexpr std::uint64_t kWordHashStart = 0xcbf29ce484222325;

// The shift lets high bits of a word reach the low ones of the hash.
constexpr std::uint64_t hash_word(std::uint64_t hash, std::uint64_t word) {
  hash = (hash ^ word) * 0x100000001b3;
  return hash ^ (hash >> 29);
}

// The last word is padded with zeros, so that callers who need to distinguish sizes hash the size,
// too.
inline std::uint64_t hash_words(std::uint64_t hash, const void* bytes, std::size_t size) {
  const auto* from = static_cast<const std::byte*>(bytes);
  for (std::size_t i = 0; i < size; i += sizeof(std::uint64_t)) {
    std::uint64_t word = 0;
    std::memcpy(&word, from + i, std::min(sizeof(word), size - i));
    hash = hash_word(hash, word);
  }
  return hash;
}

}  // namespace firn
