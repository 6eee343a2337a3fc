// A case: the description of one experiment in a TOML file. docs/case-files.md lists its keys.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "firn/model.h"

namespace firn::experiments {

// Key path and TOML value: {"interactions.ice-ice.static_friction", "0.2"}. A string value has its
// quotes: {"case.name", "\"trial\""}.
using Override = std::pair<std::string, std::string>;

// A checked case in SI units. Constant: with() makes another one. Copies share their data.
// All members that read throw InputError with one line `FILE:LINE: KEY: what is wrong; what is
// expected`.
class Case {
 public:
  // `material_records`: "NAME[@VERSION][#SAMPLE]", as `firn run --material` takes them.
  static Case load(const std::string& file, const std::vector<Override>& overrides = {},
                   const std::vector<std::string>& material_records = {});
  // From TOML text. `directory`: where relative names of mesh files and includes start.
  static Case parse(const std::string& text, const std::string& directory = ".",
                    const std::vector<Override>& overrides = {});

  // The same file with more overrides; of two for one key the later one counts.
  Case with(const std::vector<Override>& overrides) const;

  std::string name() const;
  double duration() const;  // s, latest end
  std::uint64_t seed() const;
  double timestep() const;        // s
  double frame_interval() const;  // s; 0: only the first and the last state are recorded
  // Materials, shapes, boundaries and particles, ids in order.
  const Model& model() const;
  // Complete TOML text with all defaults: equal for equal cases.
  std::string text() const;

  struct Impl;
  const Impl& impl() const { return *impl_; }  // for the library's own sources

 private:
  explicit Case(std::shared_ptr<const Impl> impl) : impl_(std::move(impl)) {}
  std::shared_ptr<const Impl> impl_;
};

}  // namespace firn::experiments
