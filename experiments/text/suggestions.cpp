#include "experiments/text/suggestions.h"

#include <fmt/format.h>

#include <algorithm>
#include <span>
#include <utility>

#include "experiments/text/units.h"

namespace firn {
namespace {

// Words of other programs and file formats, and the keys of Firn that mean the same.
constexpr std::pair<std::string_view, std::string_view> kSynonyms[] = {
    {"mesh", "file"},
    {"path", "file"},
    {"filename", "file"},
    {"stl", "file"},
    {"obj", "file"},
    {"units", "length_unit"},
    {"scale", "length_unit"},
    {"mu", "static_friction"},
    {"mu_s", "static_friction"},
    {"mu_d", "dynamic_friction"},
    {"mu_k", "dynamic_friction"},
    {"kinetic_friction", "dynamic_friction"},
    {"sliding_friction", "dynamic_friction"},
    {"rolling_friction", "rolling_resistance"},
    {"cor", "restitution"},
    {"e", "restitution"},
    {"elastic_modulus", "young_modulus"},
    {"modulus", "young_modulus"},
    {"youngs_modulus", "young_modulus"},
    {"nu", "poisson_ratio"},
    {"number", "count"},
    {"amount", "count"},
    {"particles", "count"},
    {"end_time", "duration"},
    {"simulation_time", "duration"},
    {"total_time", "duration"},
    {"time", "duration"},
    {"dt", "timestep"},
    {"output_interval", "frame_interval"},
    {"save_interval", "frame_interval"},
    {"write_interval", "frame_interval"},
    {"output_frequency", "frame_interval"},
    {"std", "standard_deviation"},
    {"sd", "standard_deviation"},
    {"sigma", "uncertainty"},
    {"error", "uncertainty"},
    {"column", "y"}};

// Whether a part between underscores is the same in both: "friction" and "static_friction".
bool share_a_part(std::string_view a, std::string_view b) {
  const auto parts = [](std::string_view text) {
    std::vector<std::string_view> all;
    for (std::size_t at = 0; at <= text.size();) {
      const std::size_t end = std::min(text.find('_', at), text.size());
      all.push_back(text.substr(at, end - at));
      at = end + 1;
    }
    return all;
  };
  const std::vector<std::string_view> of_a = parts(a);
  return std::ranges::any_of(parts(b), [&](std::string_view part) {
    return part.size() > 2 && std::ranges::find(of_a, part) != of_a.end();
  });
}

}  // namespace

int edit_distance(std::string_view a, std::string_view b) {
  constexpr int kStep = 2;
  const auto substitution = [](char x, char y) {
    if (x == y) return 0;
    const auto lower = [](char c) { return c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c; };
    return lower(x) == lower(y) ? kStep / 2 : kStep;
  };
  std::vector<int> row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) row[j] = kStep * static_cast<int>(j);
  for (const char letter : a) {
    int diagonal = row[0];
    row[0] += kStep;
    for (std::size_t j = 0; j < b.size(); ++j) {
      const int replaced = diagonal + substitution(letter, b[j]);
      diagonal = row[j + 1];
      row[j + 1] = std::min({replaced, row[j] + kStep, row[j + 1] + kStep});
    }
  }
  return row[b.size()];
}

std::optional<std::string_view> nearest(std::string_view word,
                                        const std::vector<std::string_view>& candidates) {
  constexpr std::size_t kLongest = 64;  // bytes; of longer words the beginning counts
  word = word.substr(0, kLongest);
  for (const auto& [other, key] : kSynonyms)
    if (word == other && std::ranges::find(candidates, key) != candidates.end()) return key;
  // In half steps: one edit of a word of two letters, two edits of one of three to eight.
  const int typo = word.size() < 3 ? 2 : std::max(4, 2 * static_cast<int>(word.size() / 3));
  std::optional<std::string_view> best;
  std::pair<int, int> least;  // rank and distance
  for (const std::string_view candidate : candidates) {
    const int distance = edit_distance(word, candidate);
    const bool shares = share_a_part(word, candidate);
    if (distance > typo && !shares) continue;
    // One edit is a typo. Beyond, a common part says more than a few more edits: "unit" means
    // "length_unit" and not "united".
    const std::pair order(distance <= 2 ? 0 : shares ? 1 : 2, distance);
    if (best && order >= least) continue;
    best = candidate;
    least = order;
  }
  return best;
}

std::string did_you_mean(std::string_view word) {
  return fmt::format("did you mean \"{}\"?", word);
}

std::string suggestion(std::string_view word, const std::vector<std::string_view>& candidates) {
  constexpr std::size_t kMost = 40;  // names in a message
  if (const auto likely = nearest(word, candidates)) return did_you_mean(*likely);
  const std::size_t shown = std::min(candidates.size(), kMost);
  return fmt::format("expected one of {}{}", comma_list(std::span(candidates).first(shown)),
                     shown < candidates.size() ? ", ..." : "");
}

}  // namespace firn
