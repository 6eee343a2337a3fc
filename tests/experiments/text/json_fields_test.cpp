#include "experiments/text/json_fields.h"

#include <gtest/gtest.h>

#include <cmath>

#include "firn/math.h"
#include "tests/support/error_of.h"

namespace firn {
namespace {

struct Part {
  double value = 0;
  std::optional<double> limit;
  template <class Fields>
  void fields(Fields& f) {
    f.required("value", value);
    f.added("limit", limit);
  }
};

struct Whole {
  std::string name;
  int count = 0;
  std::pair<double, double> range;
  std::optional<bool> known;
  std::vector<Part> parts;
  NamedValues<Part> named;
  template <class Fields>
  void fields(Fields& f) {
    f.required("name", name);
    f.added("count", count);
    f.required("range", range);
    f.optional("known", known);
    f.optional("parts", parts);
    f.optional("named", named);
  }
};

Whole read(const std::string& text) {
  return document_from_json<Whole>(nlohmann::ordered_json::parse(text), "x.json");
}

std::string written(Whole whole) { return JsonFieldWriter::json_of(whole).dump(); }

std::string refusal(const std::string& text) {
  return test::error_of([&] { read(text); });
}

TEST(JsonFields, AreReadAsTheyAreWritten) {
  for (
      const char* text :
      {R"({"name":"a","count":3,"range":[0.5,null]})",
       R"({"name":"","count":-1,"range":[1.0,2.0],"known":false,"parts":[{"value":1.5,"limit":2.0},{"value":null,"limit":null}],"named":{"z":{"value":0.1,"limit":null},"a":{"value":0.2,"limit":null}}})"})
    EXPECT_EQ(written(read(text)), text);
}

TEST(JsonFields, KeepTheirValuesWhereAFileLacksThem) {
  const Whole whole = read(R"({"name": "a", "range": [1, 2], "unknown": 7})");
  EXPECT_EQ(whole.count, 0);
  EXPECT_FALSE(whole.known.has_value());
  EXPECT_TRUE(whole.parts.empty());
}

TEST(JsonFields, AreRefusedWithTheirPlace) {
  const std::string rest = R"("name": "a", "range": [1, 2])";
  EXPECT_EQ(refusal("[]"), "x.json: document: is a list of 0; expected an object");
  EXPECT_EQ(refusal(R"({"name": "a"})"), "x.json: range: missing; expected this key");
  EXPECT_EQ(refusal(R"({"name": 1, "range": [1, 2]})"), "x.json: name: is 1; expected a text");
  EXPECT_EQ(refusal(R"({"name": "a", "range": [1]})"),
            "x.json: range: is a list of 1; expected a list of 2");
  EXPECT_EQ(refusal("{" + rest + R"(, "count": 1.5})"),
            "x.json: count: is 1.5; expected a whole number up to a billion");
  for (const char* count : {"1000000001", "-1000000001", "9223372036854775808",
                            "-9223372036854775808", "18446744073709551615"})
    EXPECT_EQ(
        refusal("{" + rest + ", \"count\": " + count + "}"),
        std::string("x.json: count: is ") + count + "; expected a whole number up to a billion");
  EXPECT_EQ(refusal("{" + rest + R"(, "parts": [{"value": 1}, {"value": 1e101}]})"),
            "x.json: parts.1.value: is 1e+101; expected a number up to 1e100");
  EXPECT_EQ(refusal("{" + rest + R"(, "named": {"b": {}}})"),
            "x.json: named.b.value: missing; expected this key");
  EXPECT_EQ(refusal("{" + rest + R"(, "known": null})"),
            "x.json: known: is null; expected true or false");
}

// ---- Strict reading, and structs that do not depend on JSON ----

enum class Surface { dry, wet };

struct TestSetup {
  std::string name;
  Surface surface = Surface::dry;
  int threads = 1;
  double largest = 0;
  bool has_note = false;
  std::string note;
  double weight = 0;
  std::map<std::string, double> loads;
  std::vector<std::string> tags;
};

nlohmann::ordered_json json_value(Surface& surface) {
  return surface == Surface::wet ? "wet" : "dry";
}

void read_json_value(const nlohmann::ordered_json& json, const JsonPlace& place, Surface& surface) {
  if (json != "wet" && json != "dry") place.refuse(json, "\"wet\" or \"dry\"");
  surface = json == "wet" ? Surface::wet : Surface::dry;
}

template <class Fields>
void fields(Fields& f, TestSetup& s) {
  f.required("name", s.name);
  f.required("surface", s.surface);
  f.required("threads", PositiveInt{s.threads, 8});
  f.required("has_note", s.has_note);
  f.required_if(s.has_note, "note", s.note);
  f.written_if(s.weight > 0, "weight", s.weight);
  f.optional("loads", s.loads);
  f.added("tags", s.tags);
}

TestSetup read_strictly(const std::string& text) {
  return document_from_json<TestSetup>(nlohmann::ordered_json::parse(text), "x.json",
                                       JsonReading::strict);
}

std::string strict_refusal(const std::string& text) {
  return test::error_if_any([&] { read_strictly(text); });
}

TEST(StrictJsonFields, AreReadAsTheyAreWritten) {
  for (
      const char* text :
      {R"({"name":"a","surface":"wet","threads":8,"has_note":false,"tags":[]})",
       R"({"name":"a","surface":"dry","threads":1,"has_note":true,"note":"n","weight":1e+200,"loads":{"b":0.5,"c":1.0},"tags":["t"]})"}) {
    TestSetup setup = read_strictly(text);
    EXPECT_EQ(JsonFieldWriter::json_of(setup).dump(), text);
  }
}

TEST(StrictJsonFields, RefuseUnknownKeysAndNull) {
  const std::string head = R"({"name": "a", "surface": "wet", "threads": 2)";
  const auto with = [&](const std::string& rest) { return strict_refusal(head + rest + "}"); };
  EXPECT_EQ(with(R"(, "has_note": false)"), "");
  EXPECT_EQ(with(R"(, "has_note": false, "note": 7, "weight": null, "tags": null)"), "");
  EXPECT_EQ(with(R"(, "has_note": true)"), "x.json: note: missing; expected this key");
  // Also where a required key is missing: the unknown one is the cause.
  EXPECT_EQ(with(R"(, "has_notes": false)"),
            "x.json: document: unknown key \"has_notes\"; did you mean \"has_note\"?");
  EXPECT_EQ(with(R"(, "has_note": null)"), "x.json: has_note: is null; expected true or false");
  EXPECT_EQ(with(R"(, "has_note": false, "loads": {"b": null})"),
            "x.json: loads.b: is null; expected a number");
  EXPECT_EQ(strict_refusal(R"({"name": "a", "surface": "icy"})"),
            "x.json: surface: is \"icy\"; expected \"wet\" or \"dry\"");
  for (const char* threads : {"0", "9", "1.5", "-1", "18446744073709551615", "\"2\""})
    EXPECT_EQ(
        strict_refusal(R"({"name": "a", "surface": "wet", "threads": )" + std::string(threads) +
                       "}"),
        std::string("x.json: threads: is ") + threads + "; expected a whole number from 1 to 8");
}

}  // namespace
}  // namespace firn
