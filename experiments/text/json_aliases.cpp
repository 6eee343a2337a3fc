#include "experiments/text/json_aliases.h"

#include <algorithm>
#include <string>
#include <utility>

namespace firn {
namespace {

using OrderedJson = nlohmann::ordered_json;

constexpr std::string_view kValidation = "validation", kStudyResults = "study",
                           kMaterialRecord = "material record";

constexpr RenamedJsonKey kRenamedJsonKeys[] = {
    {kValidation, "comparisons[]", "would_decide", "recommended_action"},
    {kValidation, "comparisons[]", "claims", "criteria"},
    {kValidation, "comparisons[]", "damage", "breakage"},
    {kValidation, "comparisons[]", "softening", "stiffness_scaling"},
    {kValidation, "comparisons[]", "choices", "numerical_variants"},
    {kValidation, "comparisons[].value", "difference", "comparison_error"},
    {kValidation, "comparisons[].value", "standard_uncertainty", "validation_uncertainty"},
    {kValidation, "comparisons[].value", "parts", "components"},
    {kValidation, "comparisons[].value.components[]", "how", "evaluation_method"},
    {kValidation, "comparisons[].criteria[]", "larger", "lhs"},
    {kValidation, "comparisons[].criteria[]", "than", "rhs"},
    {kValidation, "comparisons[].criteria[]", "because", "rationale"},
    {kValidation, "comparisons[].criteria[]", "once_in", "observed_once_in"},
    {kValidation, "comparisons[].curve", "difference", "comparison_error"},
    {kValidation, "comparisons[].curve", "uncertainty", "validation_uncertainty"},
    {kValidation, "comparisons[].breakage[]", "without_assumption", "distribution_free"},
    {kValidation, "comparisons[].stiffness_scaling[]", "times_beyond", "extrapolation_factor"},
    {kValidation, "comparisons[].stiffness_scaling[]", "word", "interpretation"},
    {kValidation, "comparisons[].numerical_variants[]", "choice", "variant"},

    {kStudyResults, "", "valley", "ridge"},
    {kStudyResults, "", "answer", "estimate"},
    {kStudyResults, "estimate", "posterior_denser_than_here", "hpd_level"},
    {kStudyResults, "ridge[]", "posterior_denser_than_here", "hpd_level"},
    {kStudyResults, "compare[]", "posterior_denser_than_here", "hpd_level"},
    {kStudyResults, "targets[]", "uncertainty_at_answer", "uncertainty_at_estimate"},
    {kStudyResults, "targets[]", "other_surrogate_at_answer", "other_surrogate_at_estimate"},
    {kStudyResults, "combinations[]", "identified", "identifiable"},
    {kStudyResults, "combinations[]", "uncertainty_near_the_answer", "uncertainty_near_estimate"},
    {kStudyResults, "goodness_of_fit", "standardised_residuals", "standardized_residuals"},
    {kStudyResults, "goodness_of_fit_without_priors", "standardised_residuals",
     "standardized_residuals"},
    {kStudyResults, "models[]", "departure_sd", "discrepancy_sd"},
    {kStudyResults, "models[]", "explains_its_runs", "passes_cross_validation"},
    {kStudyResults, "direct_search", "claimed_distance", "best_observed_distance"},
    {kStudyResults, "direct_search", "fresh_distance", "confirmed_distance"},

    {kMaterialRecord, "", "family", "posterior_ensemble"},
    {kMaterialRecord, "", "remark", "note"},
    {kMaterialRecord, "parameters[]", "remark", "note"},
    {kMaterialRecord, "posterior_ensemble", "points", "samples"},
    {kMaterialRecord, "posterior_ensemble", "anchors", "reference_sets"},
    {kMaterialRecord, "posterior_ensemble.combinations[]", "identified", "identifiable"},
    {kStudyResults, "parameters[]", "width_ratio", "posterior_to_prior_sd"},
    {kStudyResults, "measure_next[]", "longest_direction_left", "remaining_extent"},
};

constexpr RenamedJsonWord kRenamedJsonWords[] = {
    {kValidation, "comparisons[]", "kind", "claims", "criteria"},
    {kValidation, "comparisons[]", "kind", "damage", "breakage"},
    {kValidation, "comparisons[]", "kind", "softening", "stiffness_scaling"},
    {kValidation, "comparisons[]", "kind", "choices", "numerical_variants"},
    {kValidation, "comparisons[]", "verdict", "not enough data to say", "inconclusive"},
    {kValidation, "comparisons[]", "verdict", "information", "not judged"},
    {kValidation, "comparisons[].criteria[]", "verdict", "not enough data to say", "inconclusive"},
    {kValidation, "comparisons[].distribution", "verdict", "not enough data to say",
     "inconclusive"},
    {kValidation, "comparisons[].distribution", "verdict", "information", "not judged"},
    {kValidation, "comparisons[].value.components[]", "name", "seeds", "run-to-run variability"},
    {kValidation, "comparisons[].value.components[]", "name", "input", "input parameters"},

    {kStudyResults, "", "verdict", "undetermined", "not identifiable"},
    {kStudyResults, "", "verdict", "out of reach", "infeasible"},
    {kStudyResults, "", "verdict", "searched", "direct search only"},

    {kMaterialRecord, "", "kind", "printed", "published"},
};

// Calls `apply` for each object at a path.
template <class Json, class Apply>
void for_objects_at(Json& node, std::string_view path, const Apply& apply) {
  if (!node.is_object()) return;
  if (path.empty()) {
    apply(node);
    return;
  }
  const std::size_t end = std::min(path.find('.'), path.size());
  std::string_view key = path.substr(0, end);
  const std::string_view rest = path.substr(std::min(end + 1, path.size()));
  const bool is_list = key.ends_with("[]");
  if (is_list) key.remove_suffix(2);
  const auto found = node.find(std::string(key));
  if (found == node.end()) return;
  if (!is_list) {
    for_objects_at(*found, rest, apply);
  } else if (found->is_array()) {
    for (Json& element : *found) for_objects_at(element, rest, apply);
  }
}

// "kind" of the document; results of studies have none.
std::string kind_of(const OrderedJson& document) {
  if (!document.is_object()) return "";
  const auto kind = document.find("kind");
  if (kind == document.end()) return document.contains("study") ? std::string(kStudyResults) : "";
  return kind->is_string() ? kind->get<std::string>() : "";
}

template <class Json>
void rename_json_key(Json& object, const std::string& from, const std::string& to) {
  if (!object.contains(from) || object.contains(to)) return;
  Json renamed = Json::object();
  for (auto& [key, value] : object.items()) renamed[key == from ? to : key] = std::move(value);
  object = std::move(renamed);
}

template <class Json>
void replace_json_word(Json& document, std::string_view path, std::string_view key,
                       std::string_view from, std::string_view to) {
  for_objects_at(document, path, [&](Json& object) {
    const auto found = object.find(std::string(key));
    if (found != object.end() && found->is_string() &&
        found->template get_ref<const std::string&>() == from)
      *found = std::string(to);
  });
}

template <class Json>
void use_current(Json& document, std::string_view kind) {
  for (const RenamedJsonKey& k : kRenamedJsonKeys)
    if (k.kind == kind)
      for_objects_at(document, k.path, [&](Json& object) {
        rename_json_key(object, std::string(k.old_name), std::string(k.name));
      });
  for (const RenamedJsonWord& w : kRenamedJsonWords)
    if (w.kind == kind) replace_json_word(document, w.path, w.key, w.old_word, w.word);
}

}  // namespace

std::span<const RenamedJsonKey> renamed_json_keys() { return kRenamedJsonKeys; }
std::span<const RenamedJsonWord> renamed_json_words() { return kRenamedJsonWords; }

void use_current_json_names(OrderedJson& document) { use_current(document, kind_of(document)); }

void use_current_record_names(nlohmann::json& record) { use_current(record, kMaterialRecord); }

void use_first_record_names(OrderedJson& record) {
  for (const RenamedJsonWord& w : kRenamedJsonWords)
    if (w.kind == kMaterialRecord) replace_json_word(record, w.path, w.key, w.word, w.old_word);
  // Paths are in current names: keys of inner objects before those of the outer ones.
  for (std::size_t i = std::size(kRenamedJsonKeys); i-- > 0;)
    if (const RenamedJsonKey& k = kRenamedJsonKeys[i]; k.kind == kMaterialRecord)
      for_objects_at(record, k.path, [&](OrderedJson& object) {
        rename_json_key(object, std::string(k.name), std::string(k.old_name));
      });
}

}  // namespace firn
