#include "experiments/case_reader/material_values.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <memory>
#include <set>

#include "experiments/material_records/material_database.h"

namespace firn {
namespace {

constexpr const char* tables_name = "material_records";
constexpr const char* laws_name = "interactions";
constexpr std::string_view law_prefix = "interactions.";

class Application {
 public:
  Application(TomlDocument& document, const MaterialRequest& request)
      : document_(document), request_(request) {
    if (const toml::table* t = document.root()["materials"].as_table())
      for (const auto& [name, value] : *t) materials_.emplace_back(name.str());
    if (const toml::table* t = document.root()[laws_name].as_table())
      for (const auto& [name, value] : *t) laws_.insert(std::string(law_prefix).append(name.str()));
  }

  std::vector<AppliedMaterial> carry_out() {
    for (const std::string& text : request_.records)
      requested(text, [&] {
        const MaterialChoice choice = parse_material_choice(text);
        applied_.push_back(apply(choice, find(choice), true));
        choices_.push_back(choice);
      });
    const std::size_t named = applied_.size();
    for (const TomlTable& table : TomlTable::root(document_).tables(tables_name)) read(table);
    for (std::size_t i = 0; i < named; ++i)
      requested(request_.records[i], [&] { leave_out_parts_of_laws(applied_[i]); });
    // Noted behind those of the file, so that they read the same.
    for (std::size_t i = 0; i < named; ++i) append(applied_[i], choices_[i]);
    std::rotate(applied_.begin(), applied_.begin() + static_cast<std::ptrdiff_t>(named),
                applied_.end());
    return std::move(applied_);
  }

 private:
  // Carries out use(), which takes a requested record.
  template <class Use>
  static void requested(const std::string& record, const Use& use) {
    try {
      use();
    } catch (const InputError& error) {
      throw MaterialRequestError(record, error.what());
    }
  }

  struct Setter {
    std::string record;
    bool over_file;
  };

  StoredRecord find(const MaterialChoice& choice) {
    if (!database_)
      database_ = std::make_unique<MaterialDatabase>(material_database_file(request_.database));
    return database_->find(choice.name, choice.version);
  }

  // The key as the document spells it (the materials of a pair may stand in either order); empty
  // when the case does not have the materials.
  std::string place_of(const std::string& path) const {
    const MaterialKey key = parse_material_key(path);
    for (const std::string& m : key.materials)
      if (std::ranges::find(materials_, m) == materials_.end()) return {};
    if (key.materials.size() < 2) return path;
    const std::string turned =
        fmt::format("{}.{}-{}", key.table, key.materials[1], key.materials[0]);
    return document_.has(turned) ? turned + "." + key.key : path;
  }

  AppliedMaterial apply(const MaterialChoice& choice, const StoredRecord& stored, bool over_file) {
    const MaterialRecord& record = stored.record;
    AppliedMaterial a{record.reference(), choice.selection(), stored.sha256, {}, {}, {}, {}};
    if (record.kind == RecordKind::calibrated) a.contact_model = record.provenance.contact_model;
    const std::vector<double> values = chosen_values(record, choice);
    for (std::size_t i = 0; i < record.parameters.size(); ++i) {
      const MaterialParameter& p = record.parameters[i];
      std::vector<std::string> places;
      for (const std::string& key : p.keys) {
        const std::string place = place_of(current_case_path(key));
        (place.empty() ? a.unmatched_keys : places).push_back(place.empty() ? key : place);
      }
      if (places.empty()) continue;
      if (std::ranges::any_of(places,
                              [&](const std::string& k) { return stands(k, over_file, a); })) {
        a.overridden_keys.insert(a.overridden_keys.end(), places.begin(), places.end());
        continue;
      }
      for (const std::string& place : places) {
        document_.set(place, toml_value(values[i], p.unit), "material " + a.record);
        set_by_.insert_or_assign(place, Setter{a.record, over_file});
        a.applied_keys.push_back(place);
      }
    }
    if (a.applied_keys.empty() && a.overridden_keys.empty()) fail_without_value(a);
    return a;
  }

  [[noreturn]] void fail_without_value(const AppliedMaterial& a) const {
    throw InputError(fmt::format(
        "material {}: holds no value for a case whose materials are {}; expected a record about "
        "them",
        a.record, materials_.empty() ? "none" : comma_list(materials_)));
  }

  // The law of contact that a key belongs to, "interactions.a-b"; empty for a key of a material.
  static std::string law_of(const std::string& path) {
    parse_material_key(path);
    const std::string table = path.substr(0, path.rfind('.'));
    return table.starts_with(law_prefix) ? table : "";
  }

  // Whether case and requested records together say less of a pair than a law of contact takes, and
  // the case itself says nothing of it.
  bool is_part_of_a_law(const std::string& law) const {
    const bool of_the_case =
        laws_.contains(law) || std::ranges::any_of(set_by_, [&](const auto& s) {
          return !s.second.over_file && law_of(s.first) == law;
        });
    return !of_the_case &&
           !(document_.has(law + ".static_friction") && document_.has(law + ".restitution"));
  }

  // A requested record may hold some values for two materials that never meet in this case, which
  // has no contact law for them. They are removed again and reported.
  void leave_out_parts_of_laws(AppliedMaterial& a) {
    const auto stays = [&](const std::string& key) {
      const std::string law = law_of(key);
      return law.empty() || !is_part_of_a_law(law);
    };
    const auto left_out =
        std::stable_partition(a.applied_keys.begin(), a.applied_keys.end(), stays);
    for (auto key = left_out; key != a.applied_keys.end(); ++key) {
      document_.root()[laws_name].as_table()->erase(law_of(*key).substr(law_prefix.size()));
      a.unmatched_keys.push_back(*key);
    }
    a.applied_keys.erase(left_out, a.applied_keys.end());
    if (a.applied_keys.empty() && a.overridden_keys.empty()) fail_without_value(a);
  }

  // Whether something stronger has set the key.
  bool stands(const std::string& key, bool over_file, const AppliedMaterial& a) const {
    if (const auto it = set_by_.find(key); it != set_by_.end()) {
      if (over_file == it->second.over_file)
        throw InputError(fmt::format("material {}: sets {}, as {} does; expected one record a key",
                                     a.record, key, it->second.record));
      return true;
    }
    return over_file ? document_.overridden(key) : document_.has(key);
  }

  void read(const TomlTable& t) {
    t.allow({"record", "sample", "reference_set", "sha256", "applied_keys"});
    const std::string record = t.string("record");
    const std::string hash = t.string("sha256", "");
    const MaterialChoice choice = t.at("record", [&] {
      MaterialChoice c = parse_material_choice(record);
      if ((t.has("sample") || t.has("reference_set")) && !c.selection().empty())
        throw InputError(
            "chooses already; expected no \"sample\" or \"reference_set\" in addition");
      return c;
    });
    MaterialChoice chosen = choice;
    if (t.has("sample")) chosen.sample = static_cast<std::uint64_t>(t.integer64("sample", 1));
    if (t.has("reference_set")) chosen.reference_set = t.string("reference_set");
    if (chosen.sample && !chosen.reference_set.empty())
      t.fail("reference_set", "is given together with a sample; expected one of them");
    if (t.has("applied_keys")) {
      applied_.push_back(applied_before(t, chosen));
      note(t, applied_.back(), chosen);
      return;
    }
    const AppliedMaterial a = t.at("record", [&] {
      const StoredRecord stored = find(chosen);
      if (!hash.empty() && hash != stored.sha256)
        throw InputError(
            fmt::format("\"{}\" has the hash {} here; expected the hash of that record",
                        stored.record.reference(), stored.sha256));
      return apply(chosen, stored, false);
    });
    applied_.push_back(a);
    note(t, a, chosen);
  }

  // A resolved case: its values stand in it.
  AppliedMaterial applied_before(const TomlTable& t, const MaterialChoice& choice) const {
    if (choice.version == 0)
      t.fail("record", "has no version; expected NAME@VERSION where it says what it set");
    AppliedMaterial a{fmt::format("{}@{}", choice.name, choice.version),
                      choice.selection(),
                      t.string("sha256"),
                      {},
                      {},
                      {},
                      {}};
    for (const std::string& text : t.strings("applied_keys")) {
      const std::string key = current_case_path(text);
      t.at("applied_keys", [&] { parse_material_key(key); });
      if (!document_.has(key))
        t.fail("applied_keys",
               fmt::format("names {}, which the case does not give; expected it, or no "
                           "\"applied_keys\" to have the record asked",
                           key));
      if (!document_.overridden(key)) a.applied_keys.push_back(key);
    }
    return a;
  }

  static void note(const TomlTable& t, const AppliedMaterial& a, const MaterialChoice& choice) {
    t.set("record", a.record);
    if (choice.sample) t.set("sample", static_cast<std::int64_t>(*choice.sample));
    if (!choice.reference_set.empty()) t.set("reference_set", choice.reference_set);
    t.set("sha256", a.sha256);
    toml::array sets;
    for (const std::string& key : a.applied_keys) sets.push_back(key);
    t.set("applied_keys", std::move(sets));
  }

  void append(const AppliedMaterial& a, const MaterialChoice& choice) {
    toml::table& root = document_.root();
    if (!root.contains(tables_name)) root.insert(tables_name, toml::array());
    toml::array& all = *root.get(tables_name)->as_array();
    all.push_back(toml::table());
    note(TomlTable(document_, *all.back().as_table(), tables_name, 0), a, choice);
  }

  TomlDocument& document_;
  const MaterialRequest& request_;
  std::vector<std::string> materials_;  // of the case
  std::set<std::string> laws_;          // "interactions.a-b" that the case has, as it spells them
  std::unique_ptr<MaterialDatabase> database_;
  std::vector<AppliedMaterial> applied_;
  std::vector<MaterialChoice> choices_;   // of the request
  std::map<std::string, Setter> set_by_;  // by key
};

}  // namespace

std::vector<AppliedMaterial> apply_materials(TomlDocument& document,
                                             const MaterialRequest& request) {
  if (request.records.empty() && !document.root().contains(tables_name)) return {};
  return Application(document, request).carry_out();
}

}  // namespace firn
