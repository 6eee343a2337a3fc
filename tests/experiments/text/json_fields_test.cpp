#include "experiments/text/json_fields.h"

#include <gtest/gtest.h>

#include <cmath>

#include "firn/math.h"

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
  try {
    read(text);
  } catch (const InputError& e) {
    return e.what();
  }
  return "none";
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

}  // namespace
}  // namespace firn
