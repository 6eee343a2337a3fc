// Documents with one value replaced by another of the wrong type, length or size.
#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <nlohmann/json.hpp>
#include <random>
#include <string>
#include <vector>

#include "firn/math.h"

namespace firn::test {

using Json = nlohmann::ordered_json;

inline const std::vector<Json>& wrong_values() {
  static const std::vector<Json> all = {
      Json::array(),
      Json::object(),
      nullptr,
      true,
      "text",
      "",
      -1,
      0,
      1e308,
      -1e308,
      1e-308,
      18446744073709551615u,
      Json::array({nullptr}),
      Json::array({1, 2, 3}),
      Json::array({1e308, -1e308}),
      Json::array({"a", "b"}),
      Json::array({Json::array(), Json::array()}),
      Json::object({{"name", Json::array()}}),
      Json::parse(std::string(50, '[') + std::string(50, ']')),
  };
  return all;
}

inline void collect(const Json& j, const Json::json_pointer& here,
                    std::vector<Json::json_pointer>& all) {
  all.push_back(here);
  if (j.is_object())
    for (const auto& [key, value] : j.items()) collect(value, here / key, all);
  if (j.is_array())
    for (std::size_t i = 0; i < j.size(); ++i) collect(j[i], here / i, all);
}

// Calls `read` with each document, or with `most` of them by chance. It returns or throws
// InputError of one line.
inline void damage(const Json& whole, int most,
                   const std::function<void(const std::string&)>& read) {
  std::vector<Json::json_pointer> places;
  collect(whole, Json::json_pointer(), places);
  std::vector<std::pair<std::size_t, std::size_t>> members;
  for (std::size_t p = 0; p < places.size(); ++p)
    for (std::size_t v = 0; v <= wrong_values().size(); ++v) members.emplace_back(p, v);
  std::mt19937_64 random(7);
  std::ranges::shuffle(members, random);
  if (most > 0) members.resize(std::min(members.size(), static_cast<std::size_t>(most)));
  for (const auto& [p, v] : members) {
    Json damaged = whole;
    const bool removed = v == wrong_values().size();
    if (removed && places[p].empty()) continue;
    if (!removed) {
      damaged[places[p]] = wrong_values()[v];
    } else {
      Json& parent = damaged[places[p].parent_pointer()];
      if (parent.is_array())
        parent.erase(std::stoul(places[p].back()));
      else
        parent.erase(places[p].back());
    }
    SCOPED_TRACE(places[p].to_string() + (removed ? " removed" : " = " + wrong_values()[v].dump()));
    try {
      read(damaged.dump());
    } catch (const InputError& error) {
      const std::string said = error.what();
      EXPECT_EQ(said.find('\n'), said.npos) << said;
      EXPECT_NE(said.find("expected"), said.npos) << said;
    } catch (const std::exception& error) {
      ADD_FAILURE() << "not a refusal of input: " << error.what();
    }
  }
}

}  // namespace firn::test
