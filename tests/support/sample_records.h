// Records that the tests of the material database share.
#pragma once

#include <cmath>
#include <string>

#include "experiments/material_records/material_record.h"
#include "tests/support/scratch_folder.h"

namespace firn::test {

// Two frictions as a publication might print them.
inline MaterialRecord published_record(const std::string& name = "ice-steel") {
  MaterialRecord r;
  r.name = name;
  r.title = "Two frictions";
  r.materials = {"ice", "steel"};
  r.kind = RecordKind::published;
  r.parameters = {
      {"ice_ice",
       {"interactions.ice-ice.static_friction", "interactions.ice-ice.dynamic_friction"},
       0.1,
       "1",
       0.02,
       Interval{0.06, 0.14},
       ""},
      {"ice_steel", {"interactions.ice-steel.static_friction"}, 0.3, "1", {}, {}, "dry"},
      {"modulus", {"materials.ice.young_modulus"}, 0.01, "GPa", {}, {}, ""}};
  r.properties = {{"strength", 5.0, 0.5, Interval{1.0, 25.0}, "MPa", "-10 C", ""},
                  {"color", {}, {}, {}, "", "", "white"}};
  r.scope = {{"shape", "cubes"}};
  r.provenance.author = "an author";
  r.provenance.date = "2026-11-21";
  r.provenance.source = "a book, table 3";
  return r;
}

// The same from a study: ln(ice_ice) and ln(ice_steel) scatter along a valley.
inline MaterialRecord calibrated_record(const std::string& name = "ice-steel") {
  MaterialRecord r = published_record(name);
  r.kind = RecordKind::calibrated;
  PosteriorEnsemble f;
  f.axes = {{"ice_ice", Scale::logarithmic, {0.02, 0.5}, std::log(0.1)},
            {"ice_steel", Scale::linear, {0.05, 0.6}, 0.3}};
  f.covariance = {{0.04, -0.006}, {-0.006, 0.0025}};
  f.combinations = {{{0.6, 0.8}, true, -1.2, 0.1}, {{-0.8, 0.6}, false, 0, std::nullopt}};
  f.reference_sets = {{"answer",
                       {0.1, 0.3},
                       {{"angle_of_repose", 9.5, 0.4, "deg"}},
                       {{"drain", 1001, {{"angle_of_repose", 9.25, std::nullopt, "deg"}}},
                        {"drain", 1002, {{"angle_of_repose", 10.5, std::nullopt, "deg"}}}}}};
  r.ensemble = f;
  Provenance& p = r.provenance;
  p.raw_data = {{"responses of every run", "runs.csv", std::string(64, 'a')}};
  p.measurements = {
      {"drained angle", "angle_of_repose", 10, 0.97, "deg", "the paper", "drained box", 0.5}};
  p.study = "a study";
  p.program_version = "0.1.0";
  p.program_commit = "0123456789ab";
  p.program = "0123456789abcdef";
  p.contact_model = 2;
  p.seeds = {1, 2, 1001, 1002};
  p.estimators = {{"angle_of_repose", "robust line", 2}};
  p.command = "firn calibrate study.toml";
  p.cases = {{"drain", {"ice_ice", "ice_steel"}, "[case]\nname = \"a \\\"case\\\"\"\n"}};
  return r;
}

}  // namespace firn::test
