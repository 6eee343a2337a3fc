// Material records as JSON: files, canonical text, schema.
#include "experiments/material_records/material_json.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <functional>
#include <random>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "experiments/material_records/material_database.h"
#include "experiments/material_records/material_record.h"
#include "tests/support/error_of.h"
#include "tests/support/read_text.h"
#include "tests/support/sample_records.h"
#include "tests/support/scratch_folder.h"

namespace firn {
namespace {

using test::calibrated_record;
using test::published_record;
using testing::HasSubstr;
using testing::StartsWith;
using Json = nlohmann::json;

TEST(MaterialJson, RoundTripIsExact) {
  std::mt19937_64 random(7);
  for (int i = 0; i < 200; ++i) {
    MaterialRecord r = calibrated_record();
    // Any finite bits will do where the record does not limit them.
    double wild = 0;
    do {
      const std::uint64_t bits = random();
      std::memcpy(&wild, &bits, sizeof wild);
    } while (!std::isfinite(wild));
    wild = std::abs(wild);  // a friction
    r.parameters[0].value = wild;
    r.ensemble->reference_sets[0].runs[0].responses[0].value = -wild;
    r.ensemble->reference_sets[0].runs[0].seed = random();
    r.note = "\"quotes\", \\, \xc3\xa4\xc3\xb6, \u00b5 and\ttabs";
    const std::string text = export_text({r});
    const ReadRecord back = read_records_text(text, "export.json").at(0);
    EXPECT_EQ(std::memcmp(&back.record.parameters[0].value, &wild, sizeof wild), 0);
    EXPECT_EQ(back.record.ensemble->reference_sets[0].runs[0].seed,
              r.ensemble->reference_sets[0].runs[0].seed);
    EXPECT_EQ(canonical_text(back.record), canonical_text(r));
    EXPECT_EQ(export_text({back.record}), text);
    EXPECT_EQ(back.sha256, record_hash(r));
    EXPECT_EQ(canonical_text(read_canonical(canonical_text(r), "here")), canonical_text(r));
  }
}

std::string reading(const std::string& text) {
  return test::error_of([&] { read_records_text(text, "r.json"); });
}

// Format 1 has the first names; records keep the hash that they had there.
TEST(MaterialJson, ReadsFormatOne) {
  for (MaterialRecord r : {published_record(), calibrated_record()}) {
    r.note = "a note";
    if (r.ensemble) r.ensemble->samples = {{{0.1, 0.3}, 0.25}, {{0.11, 0.28}, 0.75}};
    const Json first = Json::parse(canonical_text(r));
    EXPECT_EQ(first.value("remark", ""), "a note");
    EXPECT_EQ(first["parameters"][1].value("remark", ""), "dry");
    EXPECT_EQ(first["kind"], r.ensemble ? "calibrated" : "printed");
    EXPECT_EQ(first.contains("family"), r.ensemble.has_value());
    if (r.ensemble) {
      EXPECT_EQ(first["family"]["anchors"].size(), 1u);
      EXPECT_EQ(first["family"]["points"].size(), 2u);
      EXPECT_EQ(first["family"]["combinations"][0]["identified"], true);
    }
    Json document = {{"format", "firn material records"}, {"format_version", 1}};
    document["records"] = Json::array({first});
    const ReadRecord back = read_records_text(document.dump(), "old.json").at(0);
    EXPECT_EQ(export_text({back.record}), export_text({r}));
    EXPECT_EQ(record_hash(back.record), record_hash(r));
    document["format_version"] = 2;
    EXPECT_THAT(reading(document.dump()), HasSubstr("unknown key"));
  }
}

// The hash can be recomputed with Python, as docs/materials.md says.
TEST(MaterialJson, PythonSpellsTheCanonicalTextTheSameWay) {
  const test::ScratchFolder folder("python");
  MaterialRecord r = calibrated_record();
  std::vector<MaterialRecord> all;
  for (const double value : {1e-5, 1e-4, 1e15, 1e16, 123456789012345680.0, 5e-324, -0.0, 2.0, 0.1,
                             1.7976931348623157e308, 9007199254740993.0}) {
    r.parameters[0].value = value;
    r.note = "\xc3\xa4 \"x\" \\ \n\t /";
    all.push_back(r);
  }
  std::ofstream(folder / "r.json") << export_text(all);
  const std::string command =
      "python3 -c \"import json, hashlib\n"
      "first = {'posterior_ensemble': 'family', 'reference_sets': 'anchors', 'samples': 'points',\n"
      "  'identifiable': 'identified', 'note': 'remark'}\n"
      "def named(x):\n"
      " if isinstance(x, dict): return {first.get(k, k): named(v) for k, v in x.items()}\n"
      " return [named(v) for v in x] if isinstance(x, list) else x\n"
      "for r in json.load(open('" +
      (folder / "r.json") +
      "'))['records']:\n"
      " given = r.pop('sha256')\n"
      " r['kind'] = r['kind'].replace('published', 'printed')\n"
      " text = json.dumps(named(r), sort_keys=True, separators=(',', ':'), ensure_ascii=False)\n"
      " assert hashlib.sha256(text.encode()).hexdigest() == given, text\n"
      "\"";
  if (std::system("python3 -c pass") != 0) GTEST_SKIP() << "there is no Python here";
  EXPECT_EQ(std::system(command.c_str()), 0);
}

// One change to an accepted document.
std::string reading_with(const std::string& pointer, const Json& value) {
  Json document = Json::parse(export_text({calibrated_record()}));
  document[Json::json_pointer(pointer)] = value;
  return reading(document.dump());
}

// The line is that of the mistake, wherever it is.
TEST(MaterialJson, LinesAreThoseOfMistakes) {
  std::mt19937 random(4);
  for (int member = 0; member < 100; ++member) {
    const std::size_t above = random() % 20, below = random() % 3;
    const std::string start = "{" + std::string(above, '\n'), end = std::string(below, '\n') + "}";
    const std::string place = fmt::format("r.json:{}: ", above + 1);
    for (const char* wrong : {"\"a\": 1, \"a\": 2", "\"a\": 1e999", "\"a\": 1e999,", "\"a\": nul",
                              "\"a\": \"\\u0007\"", "\"a\\u0007\": 1"})
      EXPECT_THAT(reading(start + wrong + end), StartsWith(place)) << wrong;
  }
}

TEST(MaterialJson, MistakesAreReportedWithTheirPlace) {
  EXPECT_THAT(reading("{\n\n\"a\": }"), HasSubstr("r.json:3: JSON:"));
  EXPECT_THAT(reading("{\"a\": 1, \"a\": 2}"), HasSubstr("\"a\" stands twice"));
  EXPECT_THAT(reading("{\"a\": 1e999}"), HasSubstr("exceeds the range of a double"));
  EXPECT_THAT(reading("\xff"), HasSubstr("UTF-8"));
  EXPECT_THAT(reading("[]"), HasSubstr("r.json:1: document: is a list of 0; expected an object"));
  EXPECT_THAT(reading("{}"), HasSubstr("r.json:1: format: missing"));
  EXPECT_THAT(reading_with("/format_version", 3), HasSubstr("of a newer Firn"));
  EXPECT_THAT(reading_with("/records/0/color", 1),
              HasSubstr("records.0: unknown key \"color\"; expected one of name, version"));
  EXPECT_THAT(reading_with("/records/0/parameters/1/value", "0.1"),
              HasSubstr("r.json:1: records.0.parameters.1.value: is \"0.1\"; expected a number"));
  EXPECT_THAT(
      reading_with("/records/0/parameters/0/interval_95", Json::array({1})),
      HasSubstr("records.0.parameters.0.interval_95: is a list of 1; expected a list of 2"));
  EXPECT_THAT(reading_with("/records/0/version", 0),
              HasSubstr("records.0.version: is 0; expected a whole number from 1 to"));
  EXPECT_THAT(reading_with("/records/0/version", 1.5), HasSubstr("expected a whole number"));
  EXPECT_THAT(reading_with("/records/0/kind", "guessed"),
              HasSubstr("expected one of published, measured, calibrated, assumed"));
  EXPECT_THAT(reading_with("/records/0/posterior_ensemble/axes/0/scale", "cubic"),
              HasSubstr("records.0.posterior_ensemble.axes.0.scale"));
  EXPECT_THAT(reading_with("/records/0/provenance/seeds/0", -1),
              HasSubstr("records.0.provenance.seeds.0: is -1"));
  EXPECT_THAT(reading_with("/records/0/provenance", Json()),
              HasSubstr("records.0.provenance: is null; expected an object"));
}

// A record whose values contradict each other.
TEST(MaterialJson, AWrongFieldIsReportedAtItsLine) {
  const std::string text = export_text({calibrated_record()});
  const auto expect = [&](const std::string& pointer, const Json& value, const std::string& says) {
    Json document = Json::parse(text);
    document[Json::json_pointer("/records/0" + pointer)] = value;
    const std::string wrong = pretty_json(document);
    const std::string error = reading(wrong);
    EXPECT_THAT(error, HasSubstr(says));
    std::istringstream in(wrong);
    std::string line;
    for (long n = std::strtol(error.c_str() + std::strlen("r.json:"), nullptr, 10); n > 0; --n)
      std::getline(in, line);
    EXPECT_THAT(line, HasSubstr(value.dump())) << error;
  };
  expect("/parameters/0/unit", "kgg", "records.0.parameters.0.unit: unknown unit \"kgg\"");
  expect("/parameters/1/uncertainty", -0.25, "records.0.parameters.1.uncertainty: is -0.25");
  expect("/parameters/0/keys/0", "materials.ice.densty", "records.0.parameters.0.keys.0: ");
  expect("/name", "a b", "records.0.name: is \"a b\"");
  expect("/provenance/date", "today", "records.0.provenance.date: ");
}

// ---- The schema that ships ----

// The part of JSON Schema that the file uses. The first thing that is wrong; empty: nothing.
std::string violation(const Json& schema, const Json& root, const Json& value,
                      const std::string& path) {
  if (schema.contains("$ref")) {
    const std::string ref = schema["$ref"];
    return violation(root.at(Json::json_pointer(ref.substr(1))), root, value, path);
  }
  if (schema.contains("const") && value != schema["const"]) return path + " is not the constant";
  if (schema.contains("enum") &&
      std::find(schema["enum"].begin(), schema["enum"].end(), value) == schema["enum"].end())
    return path + " is none of the words";
  if (schema.contains("type")) {
    const std::string type = schema["type"];
    const bool fits =
        (type == "object" && value.is_object()) || (type == "array" && value.is_array()) ||
        (type == "string" && value.is_string()) || (type == "number" && value.is_number()) ||
        (type == "integer" && value.is_number_integer()) ||
        (type == "boolean" && value.is_boolean());
    if (!fits) return path + " is no " + type;
  }
  if (schema.contains("pattern") &&
      !std::regex_search(value.get<std::string>(),
                         std::regex(schema["pattern"].get<std::string>())))
    return path + " does not match";
  if (schema.contains("minimum") && value < schema["minimum"]) return path + " is too small";
  if (schema.contains("exclusiveMinimum") && value <= schema["exclusiveMinimum"])
    return path + " is too small";
  if (schema.contains("minItems") && value.size() < schema["minItems"])
    return path + " is too short";
  if (schema.contains("maxItems") && value.size() > schema["maxItems"])
    return path + " is too long";
  if (value.is_array() && schema.contains("items"))
    for (std::size_t i = 0; i < value.size(); ++i)
      if (const auto v = violation(schema["items"], root, value[i], path + "." + std::to_string(i));
          !v.empty())
        return v;
  if (!value.is_object()) return "";
  for (const Json& key : schema.value("required", Json::array()))
    if (!value.contains(key)) return path + " lacks " + key.get<std::string>();
  for (const auto& [key, item] : value.items()) {
    if (!schema["properties"].contains(key)) return path + " has an unknown " + key;
    if (const auto v = violation(schema["properties"][key], root, item, path + "." + key);
        !v.empty())
      return v;
  }
  return "";
}

Json schema() {
  return Json::parse(test::read_text(FIRN_SOURCE_DIR "/data/materials/record.schema.json"));
}

TEST(MaterialSchema, DescribesWhatIsWritten) {
  const Json s = schema();
  std::vector<MaterialRecord> all = {published_record(), calibrated_record()};
  all[1].ensemble->samples = {{{0.1, 0.3}, 0.25}, {{0.11, 0.28}, 0.75}};
  all[1].version = 2;
  all[1].supersedes = std::string(64, 'b');
  all[1].note = "a note";
  for (const StoredRecord& shipped : shipped_materials()) all.push_back(shipped.record);
  EXPECT_EQ(violation(s, s, Json::parse(export_text(all)), "document"), "");
}

// What is structure is refused by both; what needs physics, by the reader alone.
TEST(MaterialSchema, AgreesWithTheReader) {
  const Json s = schema();
  const Json good = Json::parse(export_text({calibrated_record()}));
  const auto both_refuse = [&](const std::string& pointer, const Json& value) {
    Json document = good;
    document[Json::json_pointer(pointer)] = value;
    EXPECT_NE(violation(s, s, document, "document"), "") << pointer;
    EXPECT_NE(reading(document.dump()), "") << pointer;
  };
  // Every field of every object, as a truth value that none but one of them is.
  const std::function<void(const Json&, const std::string&)> walk =
      [&](const Json& value, const std::string& pointer) {
        if (value.is_object())
          for (const auto& [key, item] : value.items()) walk(item, pointer + "/" + key);
        if (value.is_array())
          for (std::size_t i = 0; i < value.size(); ++i)
            walk(value[i], pointer + "/" + std::to_string(i));
        if (value.is_object()) both_refuse(pointer + "/unknown_key", 1);
        if (!pointer.empty() && !value.is_boolean()) both_refuse(pointer, true);
      };
  walk(good, "");
  // Every key that is required.
  for (const char* key : {"name", "title", "materials", "kind", "scope", "provenance"}) {
    Json document = good;
    document["records"][0].erase(key);
    EXPECT_NE(violation(s, s, document, "document"), "") << key;
    EXPECT_NE(reading(document.dump()), "") << key;
  }
}

}  // namespace
}  // namespace firn
