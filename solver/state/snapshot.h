// State to bytes and back.
#pragma once

#include <cstddef>
#include <vector>

#include "solver/state/state.h"

namespace firn {

std::vector<std::byte> pack(const Model& model, const State& state);
// Throws RunError when the bytes are not of this version, or of another model.
void unpack(const std::vector<std::byte>& bytes, const Model& model, State& state);

// Hashes of the same bytes, group by group, and of all groups together.
std::vector<GroupHash> hash_groups(const State& state);
std::uint64_t combined(const std::vector<GroupHash>& groups);

}  // namespace firn
