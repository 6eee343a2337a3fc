// Applies material records to the text of a case before it is read. Precedence: docs/materials.md.
#pragma once

#include <vector>

#include "experiments/case/case.h"
#include "experiments/text/toml_document.h"

namespace firn {

// Sets the values of the records in [[material_records]] and of the requested records. In ascending
// precedence: records that the case names, keys of the case, requested records, earlier overrides
// of the document. A parameter with several keys sets all of them or none. The document then lists
// each record with version, hash and the keys that it set, so that the resolved case does not need
// the records. Throws InputError, for a requested record MaterialRequestError.
std::vector<AppliedMaterial> apply_materials(TomlDocument& document,
                                             const MaterialRequest& request);

}  // namespace firn
