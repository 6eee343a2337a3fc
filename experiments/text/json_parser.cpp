#include "experiments/text/json_parser.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <set>
#include <vector>

#include "experiments/system/input_file.h"
#include "experiments/system/input_limits.h"
#include "experiments/system/text_encoding.h"
#include "experiments/text/json_aliases.h"
#include "firn/math.h"

namespace firn {
namespace {

using Json = nlohmann::ordered_json;

std::size_t line_at(std::string_view text, std::size_t byte) {
  const auto end = text.begin() + static_cast<std::ptrdiff_t>(std::min(byte, text.size()));
  return 1 + static_cast<std::size_t>(std::count(text.begin(), end, '\n'));
}

// Stops the parser.
struct Refused {
  std::string what;
};

// A position in the text that records how far the parser has read.
class ReadPosition {
 public:
  using iterator_category = std::forward_iterator_tag;
  using value_type = char;
  using difference_type = std::ptrdiff_t;
  using pointer = const char*;
  using reference = const char&;

  ReadPosition() = default;
  ReadPosition(const char* at, const char** read) : at_(at), read_(read) {}
  reference operator*() const { return *at_; }
  ReadPosition& operator++() {
    *read_ = at_++;
    return *this;
  }
  ReadPosition operator++(int) {
    const ReadPosition before = *this;
    ++*this;
    return before;
  }
  friend bool operator==(const ReadPosition& a, const ReadPosition& b) { return a.at_ == b.at_; }

 private:
  const char* at_ = nullptr;
  const char** read_ = nullptr;  // the last character that was read
};

bool is_old_name(const std::string& key, const std::string& current) {
  return std::ranges::any_of(renamed_json_keys(), [&](const JsonAlias& alias) {
    return alias.old_name == key && alias.name == current;
  });
}

struct ValueLine {
  std::size_t line = 1;  // where the value begins, or the innermost value around it
  bool found = false;
};

// The line of the value at `path`. `old_names`: keys may have earlier names as well.
ValueLine line_of_value(std::string_view text, const std::vector<std::string>& path,
                        bool old_names) {
  using Event = Json::parse_event_t;
  struct Container {
    bool is_list, on_path;
    std::size_t items = 0;
    std::string key = {};  // read last
  };
  struct Found {};  // stops the parser
  std::vector<Container> open;
  ValueLine innermost;
  const char* read = text.data();
  // Called where a value begins. Returns whether it is on the path.
  const auto begin_value = [&] {
    if (!open.empty()) {
      Container& in = open.back();
      if (!in.on_path) return false;
      const std::string name = in.is_list ? std::to_string(in.items++) : in.key;
      const std::string& wanted = path[open.size() - 1];
      if (name != wanted && !(old_names && is_old_name(name, wanted))) return false;
    }
    innermost.line = line_at(text, static_cast<std::size_t>(read - text.data()));
    if (open.size() == path.size()) throw Found{};
    return true;
  };
  const auto watch = [&](int, Event event, Json& parsed) {
    if (event == Event::key) open.back().key = parsed.get<std::string>();
    if (event == Event::value) begin_value();
    if (event == Event::object_start || event == Event::array_start) {
      const bool on_path = begin_value();
      open.push_back({event == Event::array_start, on_path});
    }
    if (event == Event::object_end || event == Event::array_end) open.pop_back();
    return true;
  };
  try {
    [[maybe_unused]] const Json whole = Json::parse(
        ReadPosition(text.data(), &read), ReadPosition(text.data() + text.size(), &read), watch);
  } catch (const Found&) {
    innermost.found = true;
  }
  return innermost;
}

}  // namespace

Json parse_json(std::string_view text, const std::string& source) {
  using Event = Json::parse_event_t;
  std::vector<std::set<std::string>> keys;  // of the objects that are open
  std::string key;                          // read last
  const char* read = text.data();
  const auto line = [&] { return line_at(text, static_cast<std::size_t>(read - text.data())); };
  const auto check_text = [&](const std::string& value, bool one_line) {
    const std::string found =
        one_line ? encode::first_unprintable(value) : encode::first_control(value);
    if (!found.empty())
      throw InputError(fmt::format("{}:{}: {}: has the character {}; expected printable text",
                                   source, line(), encode::terminal(key), found));
  };
  const auto watch = [&](int depth, Event event, Json& parsed) {
    if (depth > input_limits::json_depth)
      throw Refused{fmt::format("arrays and objects are nested more than {} deep; expected fewer",
                                input_limits::json_depth)};
    if (event == Event::key) {
      key = parsed.get<std::string>();
      check_text(key, true);
    }
    if (event == Event::value && parsed.is_string())
      check_text(parsed.get_ref<const std::string&>(), key == "name" || key == "title");
    if (event == Event::object_start) keys.emplace_back();
    if (event == Event::object_end) keys.pop_back();
    if (event == Event::key && !keys.back().insert(key).second)
      throw Refused{
          fmt::format("the key \"{}\" stands twice in one object; expected it once", key)};
    if (event == Event::key && keys.back().size() > input_limits::json_keys)
      throw Refused{
          fmt::format("an object has more than {} keys; expected fewer", input_limits::json_keys)};
    return true;
  };
  try {
    return Json::parse(ReadPosition(text.data(), &read),
                       ReadPosition(text.data() + text.size(), &read), watch);
  } catch (const Json::parse_error&) {
    throw InputError(fmt::format("{}:{}: JSON: no JSON from here on; expected valid JSON in UTF-8",
                                 source, line()));
  } catch (const Json::exception&) {  // a number beyond all doubles
    throw InputError(
        fmt::format("{}:{}: JSON: a number exceeds the range of a double; expected finite numbers",
                    source, line()));
  } catch (const Refused& refused) {
    throw InputError(fmt::format("{}:{}: JSON: {}", source, line(), refused.what));
  }
}

JsonFile read_json_file(const std::string& file, const std::string& expected) {
  JsonFile read{file, read_input_file(file, expected, input_limits::json_bytes), {}};
  read.document = parse_json(read.text, file);
  return read;
}

std::string json_place(const std::string& source, std::string_view text,
                       const std::vector<std::string>& path) {
  if (text.empty()) return source;
  ValueLine value = line_of_value(text, path, false);
  if (!value.found) value = line_of_value(text, path, true);
  return fmt::format("{}:{}", source, value.line);
}

}  // namespace firn
