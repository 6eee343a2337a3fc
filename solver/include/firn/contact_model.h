// Version of the contact model of this build. Results files, studies, validations and material
// records state it, so that results of different models are not mixed.
#pragma once

namespace firn {

// A number that a change of the force law, of contact regions or of contact history increases when
// it moves results by more than rounding. docs/contact.md lists what each model changed. Files
// without a number are of model 1.
inline constexpr int kContactModel = 7;

}  // namespace firn
