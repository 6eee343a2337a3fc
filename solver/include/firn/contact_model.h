// The contact model of this build: what results files, studies, validations and material records
// state, so that numbers of two models are never taken for those of one.
#pragma once

namespace firn {

// A number that a change of the force law, of contact regions or of contact history increases when
// it moves results by more than rounding. docs/contact.md lists what each model changed. Files
// without a number are of model 1.
inline constexpr int kContactModel = 5;

}  // namespace firn
