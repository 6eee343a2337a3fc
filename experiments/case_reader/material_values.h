// Values of material records into a case, before it is read. docs/materials.md says what goes
// before what.
#pragma once

#include <vector>

#include "experiments/case/case.h"
#include "experiments/text/toml_document.h"

namespace firn {

// Sets what the requested records and those of [[material_records]] say. From weak to strong:
// records that the case names, the case's own keys, records that the request names, overrides that
// the document took before. A parameter that binds several keys is set whole or not at all. The
// document then names every record with its version and hash and the keys that it set, so that
// reading it again needs no record. Throws InputError.
std::vector<AppliedMaterial> apply_materials(TomlDocument& document,
                                             const MaterialRequest& request);

}  // namespace firn
