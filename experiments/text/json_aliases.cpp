#include "experiments/text/json_aliases.h"

#include <algorithm>
#include <string>
#include <utility>

namespace firn {
namespace {

using OrderedJson = nlohmann::ordered_json;

constexpr std::string_view kValidation = "validation", kStudyResults = "study",
                           kMaterialRecord = "material record";

constexpr JsonAlias kRenamedJsonKeys[] = {
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
    {kStudyResults, "models[]", "departure_sd", "gp_residual_sd"},
    {kStudyResults, "models[]", "discrepancy_sd", "gp_residual_sd"},
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

constexpr JsonAlias kRenamedJsonWords[] = {
    {kValidation, "comparisons[]", "claims", "criteria", "kind"},
    {kValidation, "comparisons[]", "damage", "breakage", "kind"},
    {kValidation, "comparisons[]", "softening", "stiffness_scaling", "kind"},
    {kValidation, "comparisons[]", "choices", "numerical_variants", "kind"},
    {kValidation, "comparisons[]", "not enough data to say", "inconclusive", "verdict"},
    {kValidation, "comparisons[]", "information", "not judged", "verdict"},
    {kValidation, "comparisons[].criteria[]", "not enough data to say", "inconclusive", "verdict"},
    {kValidation, "comparisons[].distribution", "not enough data to say", "inconclusive",
     "verdict"},
    {kValidation, "comparisons[].distribution", "information", "not judged", "verdict"},
    {kValidation, "comparisons[].value.components[]", "seeds", "run-to-run variability", "name"},
    {kValidation, "comparisons[].value.components[]", "input", "input parameters", "name"},

    {kStudyResults, "", "undetermined", "not identifiable", "verdict"},
    {kStudyResults, "", "out of reach", "infeasible", "verdict"},
    {kStudyResults, "", "searched", "direct search only", "verdict"},

    {kMaterialRecord, "", "printed", "published", "kind"},
};

// Calls `apply` for each object at a path.
template <class Apply>
void for_objects_at(OrderedJson& node, std::string_view path, const Apply& apply) {
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
    for (OrderedJson& element : *found) for_objects_at(element, rest, apply);
  }
}

// "kind" of the document; results of studies have none.
std::string kind_of(const OrderedJson& document) {
  if (!document.is_object()) return "";
  const auto kind = document.find("kind");
  if (kind == document.end()) return document.contains("study") ? std::string(kStudyResults) : "";
  return kind->is_string() ? kind->get<std::string>() : "";
}

void rename_json_key(OrderedJson& object, const std::string& from, const std::string& to) {
  if (!object.contains(from) || object.contains(to)) return;
  OrderedJson renamed = OrderedJson::object();
  for (auto& [key, value] : object.items()) renamed[key == from ? to : key] = std::move(value);
  object = std::move(renamed);
}

void replace_json_word(OrderedJson& document, std::string_view path, std::string_view key,
                       std::string_view from, std::string_view to) {
  for_objects_at(document, path, [&](OrderedJson& object) {
    const auto found = object.find(std::string(key));
    if (found != object.end() && found->is_string() && found->get_ref<const std::string&>() == from)
      *found = std::string(to);
  });
}

void use_current(OrderedJson& document, std::string_view kind) {
  for (const JsonAlias& k : kRenamedJsonKeys)
    if (k.document == kind)
      for_objects_at(document, k.path, [&](OrderedJson& object) {
        rename_json_key(object, std::string(k.old_name), std::string(k.name));
      });
  for (const JsonAlias& w : kRenamedJsonWords)
    if (w.document == kind) replace_json_word(document, w.path, w.key, w.old_name, w.name);
}

}  // namespace

std::span<const JsonAlias> renamed_json_keys() { return kRenamedJsonKeys; }
std::span<const JsonAlias> renamed_json_words() { return kRenamedJsonWords; }

void use_current_json_names(OrderedJson& document) { use_current(document, kind_of(document)); }

void use_current_record_names(OrderedJson& record) { use_current(record, kMaterialRecord); }

void use_first_record_names(OrderedJson& record) {
  for (const JsonAlias& w : kRenamedJsonWords)
    if (w.document == kMaterialRecord) replace_json_word(record, w.path, w.key, w.name, w.old_name);
  // Paths are in current names: keys of inner objects before those of the outer ones.
  for (std::size_t i = std::size(kRenamedJsonKeys); i-- > 0;)
    if (const JsonAlias& k = kRenamedJsonKeys[i]; k.document == kMaterialRecord)
      for_objects_at(record, k.path, [&](OrderedJson& object) {
        rename_json_key(object, std::string(k.name), std::string(k.old_name));
      });
}

}  // namespace firn
